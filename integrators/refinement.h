#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

namespace lithe {

/// Corrections of a linear solution, until they are round-off: correct() makes one and returns its size and that of the
/// solution. False where they do not shrink far enough: to 1e-6 where round-off ends progress.
template <class Correct>
bool refine(const Correct& correct, int most = 60) {
  constexpr double kSolved = 1e-14, kFine = 1e-11, kGood = 1e-6;
  constexpr int kStands = 3;  // corrections without progress: slow ones do not shrink one by one
  double last = 0, least = std::numeric_limits<double>::infinity();
  for (int k = 0, stands = 0; k < most; ++k) {
    const auto [change, size] = correct();
    if (!std::isfinite(change)) return false;
    // Corrections shrink by one factor: that which would come next is round-off.
    if (k > 0 && (change <= kSolved * size || change * std::min(change / last, 1.0) <= kSolved * size)) return true;
    if (k > 1 && change > 0.5 * last && change <= kFine * size) return true;
    stands = change > 0.9 * least ? stands + 1 : 0;
    if (stands >= kStands && change <= kGood * size) return true;
    least = std::min(least, change);
    last = change;
  }
  return false;
}

}  // namespace lithe
