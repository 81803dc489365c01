#pragma once

#include <limits>
#include <vector>

#include "engine/archive/archive.h"
#include "engine/gradient/parametric_scene.h"
#include "engine/run/event_finder.h"

namespace lithe {

/// Ends steps of a run at the events of its scene and at the kinks of its force laws (engine/run/kinks.h), which count
/// after the events. A step that passes one is taken again: first to where dense output
/// finds it, then to where its function passes the level at the end of a step, by Newton's method.
class EventLanding {
 public:
  /// The integrator has been started at `state`. All but that are borrowed.
  EventLanding(const ParametricScene& scene, const Drawing& drawing, bool at_kinks, Integrator& integrator,
               Evaluator& equations, const State& state);

  /// Before each step.
  void remember(State state);
  /// After it: whether it passed an event; then state and integrator are as before, and the step is to end at `stop`.
  bool cut(const State& before, State& state, double& stop);
  /// Whether the step ends at an event, and at which.
  bool met() const { return met_; }
  int number() const { return number_; }
  bool at_kink() const { return number_ >= events_; }
  int kink() const { return number_ - events_; }
  /// Whether there is nothing to land at.
  bool empty() const { return functions_.empty(); }
  /// From the state behind the event, where the integrator has been started.
  void go_on(const State& state);

 private:
  bool again(const State& before, State& state, double& stop, double time);
  double by_newton(const State& state);
  double value(const State& state);

  const Layout& layout_;
  Integrator& integrator_;
  Evaluator& equations_;
  EventFinder finder_;
  Snapshot now_;
  std::vector<EventFunction> functions_;
  std::vector<double> levels_;
  Archive mark_;                 // the integrator before the step
  int events_ = 0;               // how many there are
  int number_ = -1, tries_ = 0;  // of the event that steps are led to
  double last_off_ = std::numeric_limits<double>::infinity();
  bool met_ = false;
};

}  // namespace lithe
