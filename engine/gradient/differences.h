#pragma once

#include <array>
#include <limits>

#include "engine/base/math.h"

namespace lithe {

/// A central difference of fourth order, f' h = Σ weight f(x + steps h): error h⁴ f⁽⁵⁾/30. In pairs of opposite steps.
struct Offset {
  double steps, weight;
};
inline constexpr std::array<Offset, 4> kOffsets{{{1, 8.0 / 12}, {-1, -8.0 / 12}, {2, -1.0 / 12}, {-2, 1.0 / 12}}};

/// h for directions whose largest entry is one (m, rad, or the unit of a modal coordinate): 1e-16 f⁽⁵⁾ beside a
/// round-off of 1e-12.
inline constexpr double kDirectionStep = 1e-4;

/// |x| of the largest entry; 0 without any.
inline double largest_entry(ConstVectorRef x) { return x.size() > 0 ? x.lpNorm<Eigen::Infinity>() : 0; }

/// f' of fourth order by steps of h or, where f has a kink or bends more quickly than that, of less, until second and
/// fourth order agree, or to round-off for an agreement of zero; else as near to that as round-off allows.
template <class Function>
VectorX bent_difference(double h, double agree, const Function& f) {
  constexpr double kLeast = 1e-6, kRoundOff = 1e-14;  // of h; of f
  double best_off = std::numeric_limits<double>::infinity();
  VectorX best;
  for (double t = h; t >= kLeast * h; t *= 0.1) {
    const VectorX ahead = f(t), near = (ahead - f(-t)) / (2 * t), far = (f(2 * t) - f(-2 * t)) / (4 * t);
    const double off = largest_entry(near - far);
    if (off < best_off || best.size() == 0) best_off = off, best = (4 * near - far) / 3;
    if (off <= agree * largest_entry(near) + kRoundOff * largest_entry(ahead) / t) break;
  }
  return best;
}
inline constexpr double kOrdersOfKinks = 1e-3;  // agreement that tells of a kink, where none is expected

}  // namespace lithe
