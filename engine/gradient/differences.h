#pragma once

#include <array>

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

}  // namespace lithe
