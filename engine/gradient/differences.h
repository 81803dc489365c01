#pragma once

#include <algorithm>
#include <array>
#include <limits>

#include "engine/base/error.h"
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

/// Of each term of a function that is differenced.
inline constexpr double kTermRoundOff = 1e-15;

/// |x| of the largest entry; 0 without any.
inline double largest_entry(ConstVectorRef x) { return x.size() > 0 ? x.lpNorm<Eigen::Infinity>() : 0; }

/// f' of fourth order by steps of h or, where f bends far more quickly than that, has a kink or is not defined so far
/// away, of less: those whose error, by how far second and fourth order are apart, and round-off are least. Errors are
/// beside `scale`, the largest such f' so far, which it raises: what nearly vanishes has little but round-off. In
/// pairs, so that what does not change gives zero to the bit. `terms`: the size of what cancels in f, whose last bits
/// are in it too.
template <class Function>
VectorX difference(double h, bool kinks, double& scale, const Function& f, double terms = 0) {
  constexpr double kLeast = 1e-6, kGood = 1e-13, kPlain = 1e-6;  // of h; of f'
  double least = std::numeric_limits<double>::infinity();
  VectorX best;
  for (double t = h; t >= kLeast * h; t *= 0.1) {
    VectorX ahead, near, far;
    try {
      ahead = f(t), near = (ahead - f(-t)) / (2 * t), far = (f(2 * t) - f(-2 * t)) / (4 * t);
    } catch (const SimulationError&) {  // a film that is gone there, say
      if (0.1 * t < kLeast * h && best.size() == 0) throw;
      continue;
    }
    const bool first = best.size() == 0;
    scale = std::max(scale, largest_entry(near));
    double apart = largest_entry(near - far);
    if (scale > 0) apart = std::max(apart, kTermRoundOff * terms / t);  // agreement beyond that is chance
    const double error = apart > 0 ? apart * apart / scale : 0;
    const double noise = kTermRoundOff * largest_entry(ahead) / t;
    if (error + noise < least || first) best = (4 * near - far) / 3;
    if (error + noise < least) least = error + noise;
    if (error <= std::max(noise, (first && !kinks ? kPlain : kGood) * scale)) break;
  }
  return best;
}

}  // namespace lithe
