#pragma once

#include <optional>
#include <string>
#include <vector>

#include "engine/assembly/assembler.h"
#include "engine/assembly/system.h"
#include "engine/model/state.h"
#include "engine/motion/integrator.h"
#include "engine/motion/projection.h"
#include "engine/observe/event.h"
#include "engine/observe/observer.h"
#include "engine/observe/observer_schedules.h"
#include "engine/run/checkpoint.h"
#include "engine/run/event_finder.h"

namespace lithe {

/// The loop over time: one integrator, any observers; borrows all of them. Observers see states through an assembler of
/// their own. Their schedules cut the integrator's steps, so that observed times are met exactly, never interpolated.
/// Events are located within steps. Where force laws change their form (ForceElement::switches, a stop met or left),
/// the step ends and the integrator starts anew: across such a kink no method keeps its order, and its error estimate
/// errs. The same where surfaces of compliant contacts meet or part, which events() tells of too, as of the impacts,
/// meeting and parting of rigid ones, which time stepping locates within its steps.
class Simulation {
 public:
  Simulation(const System& system, Integrator& integrator);
  Simulation(const System&& system, Integrator& integrator) = delete;  // borrowed: a temporary would be gone

  /// Tells `observer` of the states of later runs.
  void observe(Observer& observer, Schedule schedule);

  /// Looks for `event` in later runs. Throws SceneError for one without name or function.
  void on(Event event);
  /// What happened since the last start at a new state, by time.
  const std::vector<EventRecord>& events() const { return events_; }
  /// The event that ended the last run before its time; empty: none did.
  const std::string& stopped_by() const { return stopped_by_; }

  /// Moves the state to time `end`, exactly, or to an event that stops the run. Observers of every step are told of the
  /// states at events that end a step (restart, stop). Observers are told of the first state too; index-3 integrators
  /// may have shifted its velocities a little (integrators/generalized_alpha.h). A state left as the last run made it
  /// goes on from there: run(state, 1), run(state, 2) is run(state, 2) where a step ends at 1. Any other starts the
  /// integrator, and the schedules, anew. Throws SceneError for an end before the state's time or a state that does not
  /// fit the system; SimulationError where the integrator fails or leaves a coordinate that is not finite, or where
  /// events accumulate: ever more of them in ever shorter times; where an element, observer or event throws, memory
  /// runs out, or a signal asks to end (engine/base/interrupt.h). It names the element and the time. Then the state is
  /// the last good one, observers have been told of it (but after lack of memory or an exception), and the next run
  /// starts from it. Multipliers::later leaves State::lambda empty at the end where the integrator does.
  void run(State& state, double end, Multipliers multipliers = Multipliers::found);

  /// Writes checkpoints of later runs to `path`, each in the place of the one before: at their first state, then after
  /// the first step that ends at or beyond t₀ + k·interval. Steps are not cut: the run is the same, bit for bit, as
  /// without, but for methods that cannot tell their history (Integrator::history), which start anew there. Throws
  /// FileError from run() where one cannot be written; the run may then be gone on with.
  void checkpoint(std::string path, Schedule schedule);
  /// A checkpoint of this state, by hand. Where it is the one that the last run ended with, resuming goes on with the
  /// same bits as this simulation; any other is one to start from. Methods that cannot tell their history are started
  /// anew, which may move the state by round-off.
  void save(State& state, const std::string& path);
  void save(State& state, Archive& archive);
  /// The state of a checkpoint, from which run() goes on with the bits of the run that wrote it: in the same scene,
  /// with the same kind of integrator, observers and events in the same order, all of them told of before. Observers
  /// that keep something (Recorder) have it again. Throws FileError for a file that is damaged or of another version,
  /// SceneError where scene, integrator, observers or events are others, saying which; then nothing has been changed
  /// but the integrator, which the next run starts anew.
  State resume(const std::string& path);
  State resume(Archive& archive);

  /// Of the integrator, since it was started from a new state; events that start it anew do not count.
  IntegratorStatistics statistics() const;

 private:
  friend class LeanSimulation;
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
  void check_accumulation(State& state, const std::string& name);
  void find_multipliers(State& state);
  Snapshot& look(const State& state);
  [[noreturn]] void fail(State& state, const std::string& what, const std::string& fix);

  const System& system_;
  Integrator& integrator_;
  Assembler equations_;
  Snapshot snapshot_;
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
