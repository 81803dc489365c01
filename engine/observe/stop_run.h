#pragma once

#include <string>

namespace lithe {

/// What an observer throws to end the run that tells it, at this state and without an error: as an event that stops it,
/// `by` becomes Simulation::stopped_by(). Other observers receive the state too.
struct StopRun {
  std::string by;
};

/// Calls `tell` until no observer asks for the end; returns who did, empty: nobody. An observer asks once a state.
template <class Tell>
std::string stopped_by_observers(const Tell& tell) {
  std::string by;
  while (true) try {
      tell();
      return by;
    } catch (const StopRun& stop) {
      by = stop.by;
    }
}

}  // namespace lithe
