#pragma once

#include <algorithm>
#include <cmath>

namespace lithe {

/// Corrections of a linear solution, until they are round-off: correct() makes one and returns its size and that of the
/// solution. False where they do not shrink far enough: to 1e-6 where round-off ends progress.
template <class Correct>
bool refine(const Correct& correct, int most = 12) {
  constexpr double kSolved = 1e-14, kGood = 1e-6;
  double last = 0;
  for (int k = 0; k < most; ++k) {
    const auto [change, size] = correct();
    if (!std::isfinite(change)) return false;
    // Corrections shrink by one factor: that which would come next is round-off.
    if (k > 0 && (change <= kSolved * size || change * std::min(change / last, 1.0) <= kSolved * size)) return true;
    if (k > 1 && change > 0.5 * last && change <= kGood * size) return true;
    last = change;
  }
  return false;
}

}  // namespace lithe
