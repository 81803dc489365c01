#pragma once

#include <cmath>
#include <span>
#include <vector>

namespace lithe {

/// A cycle of a history: from valley to peak, in the unit of the history.
struct LoadCycle {
  double range, mean;
  double count;  // 1, or ½: a half cycle
};

/// Rainflow counting of ASTM E1049-85 (2017), 5.4.4, value by value: a range that a larger one follows is a cycle, or a
/// half one if it begins the history; what is left at the end are half cycles. It keeps the reversals alone that may
/// still be matched. T. Endo and M. Matsuishi, 1968.
class RainflowCounter {
 public:
  /// take(LoadCycle) is called for each cycle that ends here.
  template <class Take>
  void add(double value, Take&& take) {
    const auto n = open_.size();
    if (n > 0 && value == open_[n - 1]) return;
    if (n > 1 && (value > open_[n - 1]) == (open_[n - 1] > open_[n - 2])) {  // further along the same way
      open_[n - 1] = value;
      return;
    }
    close(take);
    open_.push_back(value);
  }
  /// The end of the history; what comes then is another one.
  template <class Take>
  void finish(Take&& take) {
    close(take);
    for (std::size_t i = 1; i < open_.size(); ++i) take(cycle(open_[i - 1], open_[i], 0.5));
    open_.clear();
  }

 private:
  static LoadCycle cycle(double from, double to, double count) {
    return {std::abs(to - from), 0.5 * (from + to), count};
  }
  template <class Take>
  void close(Take&& take) {
    for (auto n = open_.size(); n > 2; n = open_.size()) {
      const double *last = &open_[n - 1], range = std::abs(last[-1] - last[-2]);
      if (std::abs(last[0] - last[-1]) < range) return;
      take(cycle(last[-2], last[-1], n == 3 ? 0.5 : 1));
      if (n == 3)
        open_.erase(open_.begin());
      else
        open_.erase(open_.end() - 3, open_.end() - 1);
    }
  }

  std::vector<double> open_;  // the last one may still grow
};

/// All cycles of a history, in the order in which they end. SceneError for a value that is not finite.
std::vector<LoadCycle> rainflow(std::span<const double> history);

}  // namespace lithe
