#pragma once

#include <string>

#include "engine/observe/snapshot.h"

namespace lithe {

class Archive;

/// Receives the states of a run: a recorder, a live plot, a log. Owned by the scene; the
/// simulation borrows it. May throw: the simulation ends there, with its state kept.
class Observer {
 public:
  Observer() = default;
  Observer(const Observer&) = delete;
  Observer& operator=(const Observer&) = delete;
  virtual ~Observer() = default;

  /// A state of the schedule, or the last good one before a failure.
  virtual void observe(Snapshot& snapshot) = 0;

  /// Its history, saved in checkpoints and loaded when a run is resumed: none by default.
  virtual void history(Archive& /*archive*/) {}
};

/// When an observer receives states; always at the first state too.
struct Schedule {
  double interval = 0;  // s; 0: after every step of the integrator
};
/// At t₀ + k·interval, k = 0, 1, 2 …, t₀ the time at which the observer's first run begins. Integrators stop there.
/// Throws SceneError unless interval > 0.
Schedule every(double interval);
/// At the first state and after every step.
inline Schedule every_step() { return {}; }

}  // namespace lithe
