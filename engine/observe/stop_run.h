#pragma once

#include <string>

namespace lithe {

/// What an observer throws to end the run that tells it, at this state and without an error: as an event that stops it,
/// `by` becomes Simulation::stopped_by(). The observer counts as told of the state; others receive it too.
struct StopRun {
  std::string by;
  /// Never empty: that would say that nobody asked.
  const std::string& who() const {
    static const std::string unnamed = "an observer";
    return by.empty() ? unnamed : by;
  }
};

}  // namespace lithe
