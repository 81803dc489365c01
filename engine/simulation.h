#pragma once

#include <vector>

#include "engine/assembler.h"
#include "engine/integrator.h"
#include "engine/observer.h"
#include "engine/state.h"
#include "engine/system.h"

namespace lithe {

/// The loop over time: one integrator, any observers; borrows all of them. Observers see states through an assembler of
/// their own. Their schedules cut the integrator's steps, so that observed times are met exactly, never interpolated.
class Simulation {
 public:
  Simulation(const System& system, Integrator& integrator);
  Simulation(const System&& system, Integrator& integrator) = delete;  // borrowed: a temporary would be gone

  /// Tells `observer` of the states of later runs.
  void observe(Observer& observer, Schedule schedule);

  /// Moves the state to time `end`, exactly. Observers are told of the first state too; index-3 integrators may have
  /// shifted its velocities a little (integrators/generalized_alpha.h). A state left as the last run made it goes on
  /// from there: run(state, 1), run(state, 2) is run(state, 2) where a step ends at 1. Any other starts the integrator,
  /// and the schedules, anew.
  /// Throws SceneError for an end before the state's time or a state that does not fit the system; SimulationError
  /// where the integrator fails or leaves a coordinate that is no number. Then the state is the last good one,
  /// observers have been told of it, and the next run starts from it.
  void run(State& state, double end);

  /// Of the integrator, since it was started.
  const IntegratorStatistics& statistics() const { return integrator_.statistics(); }

 private:
  struct Watch {
    Observer* observer;
    Schedule schedule;
    double origin = 0;  // t₀ of the schedule
    long told = 0;      // states of the schedule, so far
    double told_time = 0;
    bool begun = false;

    double next_time() const;
    double slack(double time) const;
    bool is_due(double time) const;
  };
  void check(const State& state, double end) const;
  double next_stop(double time, double end) const;
  void advance(State& state, double stop);
  void tell_due(const State& state);
  void tell(Watch& watch, const State& state);
  [[noreturn]] void fail(State& state, const std::string& what, const std::string& mend);

  const System& system_;
  Integrator& integrator_;
  Assembler equations_;
  Snapshot snapshot_;
  std::vector<Watch> watches_;
  State last_;              // the last good state
  bool evaluated_ = false;  // snapshot_ holds last_
  bool started_ = false;    // the integrator's history belongs to last_
  long steps_ = 0;          // its count then: an integrator lent to others has lost that history
};

}  // namespace lithe
