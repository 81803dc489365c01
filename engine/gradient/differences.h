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

/// f' of fourth order by steps of h; in pairs, so that what does not change gives zero to the bit.
template <class Function>
VectorX smooth_difference(double h, const Function& f) {
  VectorX sum;
  for (std::size_t i = 0; i < kOffsets.size(); i += 2) {
    const VectorX ahead = f(kOffsets[i].steps * h), behind = f(kOffsets[i + 1].steps * h);
    if (i == 0) sum.setZero(ahead.size());
    sum += kOffsets[i].weight / h * (ahead - behind);
  }
  return sum;
}

/// f' of fourth order by steps of h or, where f has a kink or bends more quickly than that, of less: those whose error,
/// by how far second and fourth order are apart, and round-off are least.
template <class Function>
VectorX bent_difference(double h, const Function& f) {
  constexpr double kLeast = 1e-6, kRoundOff = 1e-15;  // of h; of f
  double least = std::numeric_limits<double>::infinity();
  VectorX best;
  for (double t = h; t >= kLeast * h; t *= 0.1) {
    const VectorX ahead = f(t), near = (ahead - f(-t)) / (2 * t), far = (f(2 * t) - f(-2 * t)) / (4 * t);
    const double apart = largest_entry(near - far), size = largest_entry(near);
    const double noise = kRoundOff * largest_entry(ahead) / t, error = apart > 0 ? apart * apart / size : 0;
    if (error + noise < least || best.size() == 0) least = error + noise, best = (4 * near - far) / 3;
    if (error <= noise) break;
  }
  return best;
}

}  // namespace lithe
