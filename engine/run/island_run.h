#pragma once

#include <optional>
#include <string>
#include <vector>

#include "engine/assembly/evaluator.h"
#include "engine/assembly/system.h"
#include "engine/model/state.h"
#include "engine/motion/integrator.h"
#include "engine/motion/projection.h"
#include "engine/observe/event.h"
#include "engine/observe/observer.h"
#include "engine/observe/observer_schedules.h"
#include "engine/run/checkpoint.h"
#include "engine/run/event_finder.h"
#include "engine/run/followed_inputs.h"

namespace lithe {

/// The loop over time of one system by one integrator, which Simulation (engine/run/simulation.h) is made of: one an
/// island. Borrows both, and its observers. Its functions are those of Simulation that have the same names.
class IslandRun {
 public:
  IslandRun(const System& system, Integrator& integrator);

  void observe(Observer& observer, Schedule schedule);
  void on(Event event);
  const std::vector<EventRecord>& events() const { return events_; }
  const std::string& stopped_by() const { return stopped_by_; }

  void run(State& state, double end, Multipliers multipliers);

  void checkpoint(std::string path, Schedule schedule);
  void save(State& state, Archive& archive);
  State resume(Archive& archive);

  IntegratorStatistics statistics() const;

 private:
  friend class Simulation;
  void begin(State& state);
  void history(Archive& archive, State& state);
  void check_loaded(const Archive& archive, const State& state) const;
  void write_due_checkpoint(State& state);
  void go(State& state, double end, Multipliers multipliers);
  void check(const State& state, double end) const;
  double next_stop(double time, double end) const;
  void make_finder();
  void restart(State& state);
  void advance(State& state, double stop);
  void look_for_events(State& state);
  bool is_switch(int watched) const { return watched >= static_cast<int>(watched_events_.size()); }
  bool ends_step(int watched) const;
  void record(const EventFinder::Crossing& crossing);
  void record_happenings(const State& state);
  void meet(State& state);
  void follow_inputs(State& state);
  void move_onto_constraints(State& state);
  void check_accumulation(State& state, const std::string& name);
  void find_multipliers(State& state);
  Snapshot& look(const State& state);
  [[noreturn]] void fail(State& state, const std::string& what, const std::string& fix);

  const System& system_;
  Integrator& integrator_;
  Evaluator equations_;
  Snapshot snapshot_;
  FollowedInputs inputs_;
  ObserverSchedules watches_;
  State last_;              // the last good state
  bool evaluated_ = false;  // snapshot_ holds last_
  bool started_ = false;    // the integrator's history belongs to last_
  long steps_ = 0;          // its count then: an integrator lent to others has lost that history

  std::vector<Event> watched_events_;
  std::vector<EventRecord> events_;
  struct Meeting {
    std::string name;
    int a, b;
  };
  std::vector<Meeting> meetings_;  // the last of finder_'s functions: gaps of located contacts
  std::string stopped_by_;
  std::optional<EventFinder> finder_;  // of watched_events_, then of the switches of force laws; none: nothing to find
  Projector projector_;
  State at_event_;
  std::vector<EventFinder::Crossing> met_;  // that happen at one time
  IntegratorStatistics earlier_;            // of the integrator's starts before its present one
  struct Approach {                         // to a switch: steps end there
    int watched = -1, tries = 0;
    double time = 0;  // s
  } approach_;
  std::vector<double> restarts_;  // times of the last ones by events, s
  double first_restart_ = 0;
  CheckpointSchedule checkpoints_;
  std::optional<SceneFingerprint> scene_;  // once asked for
};

}  // namespace lithe
