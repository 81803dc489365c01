#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/assembly/system.h"
#include "engine/model/state.h"
#include "engine/motion/integrator.h"
#include "engine/motion/make_integrator.h"
#include "engine/observe/event.h"
#include "engine/observe/observer.h"
#include "engine/observe/observer_schedules.h"
#include "engine/observe/snapshot.h"
#include "engine/run/checkpoint.h"
#include "engine/run/mode_freezing.h"

namespace lithe {

class IslandRun;
class Simplification;

/// What a simulation that is made from a graph may spare.
struct SimulationOptions {
  AssembleOptions assemble{};
  bool simplify = false;  // a simpler scene runs (engine/simplify/simplification.h), observers see the whole
  bool split = true;      // islands have steps of their own
  bool sleep = true;      // islands at rest are not stepped
  std::optional<ModeFreezing::Parameters> freeze{};  // quiet modes stand still: around each island's integrator
};

/// The loop over time. Either one system runs with one integrator:
///   System system = assemble(graph);
///   Automatic integrator;
///   Simulation simulation{system, integrator};
///   State state = system.initial_state();
///   simulation.run(state, 10);
/// or a graph runs island by island: parts of a scene that nothing ties (split(), engine/model/islands.h) have systems
/// and integrators of their own, so that a stiff or fast one does not force its steps on the others; those at rest
/// sleep (engine/run/sleeping_integrator.h). Islands meet at the times that observers wait for, and there observers see
/// the whole:
///   Simulation simulation{graph, [] { return std::make_unique<Automatic>(); }, {.simplify = true}};
///   State state = simulation.start();
///   simulation.observe(recorder, every(0.01));
///   simulation.run(state, 10);
///
/// Observers are borrowed, and see states through an evaluator of their own. Their schedules cut the integrator's
/// steps, so that observed times are met exactly, never interpolated. Events are located within steps. Where force laws
/// change their form (ForceElement::switches, a stop met or left), the step ends and the integrator starts anew: across
/// such a kink no method keeps its order, and its error estimate errs. The same where surfaces of compliant contacts
/// meet or part. events() reports that too, and the impacts, meeting and parting of rigid ones, which time stepping
/// locates within its steps.
class Simulation {
 public:
  /// One island, no shortcuts. Borrows both.
  Simulation(const System& system, Integrator& integrator);
  Simulation(const System&& system, Integrator& integrator) = delete;  // borrowed: a temporary would be gone
  /// An integrator an island. The graph must outlive the simulation. Throws SceneError as assemble() does, and as
  /// ModeFreezing does for parameters that are not positive.
  Simulation(SystemGraph& graph, const MakeIntegrator& make_integrator, const SimulationOptions& options = {});
  ~Simulation();

  /// What runs, as one: of states given to run().
  const System& system() const { return system_; }
  /// What observers see: system(), or with SimulationOptions::simplify the scene as drawn.
  const System& observed() const { return observed_; }
  /// The state of system() in which the scene was drawn.
  State start() const;
  /// Between states of system() and of the whole, and what was done; null without SimulationOptions::simplify.
  const Simplification* simplification() const { return simple_.get(); }

  /// Tells `observer` of the states of later runs. Throws SceneError for every_step() where several islands run, or a
  /// simpler scene: they have no steps in common.
  void observe(Observer& observer, Schedule schedule);

  /// Looks for `event` in later runs. Throws SceneError for one without name or function, and where several islands
  /// run, or a simpler scene: events watch all of a scene.
  void on(Event event);
  /// What happened since the last start at a new state, by time; at one time in the order of the islands.
  const std::vector<EventRecord>& events() const;
  /// The event, or who else (StopRun), that ended the last run before its time; empty: none did.
  const std::string& stopped_by() const;

  /// Moves the state, one of system(), to time `end`, exactly, or to an event that stops the run. Observers of every
  /// step receive the states at events that end a step (restart, stop). Observers receive the first state too;
  /// index-3 integrators may have shifted its velocities a little (integrators/generalized_alpha.h). A state left as
  /// the last run made it continues from there: run(state, 1), run(state, 2) is run(state, 2) where a step ends at 1.
  /// Any other starts the integrator, and the schedules, anew; of several islands only those that it changes start
  /// anew. Throws SceneError for an end before the state's time or a state that does not fit the system;
  /// SimulationError where the integrator fails or leaves a coordinate that is not finite, or where events accumulate:
  /// ever more of them in ever shorter times; where an element, observer or event throws, memory runs out, or a signal
  /// asks to end (engine/base/interrupt.h). It names the element and the time. Then the state is the last good one,
  /// observers have received it (but after lack of memory or an exception), and the next run starts from it. Where one
  /// of several islands fails, the error names its bodies, and the others are brought to its last good time; if they
  /// cannot be, the state is that of the last time at which all met. Multipliers::later leaves State::lambda empty at
  /// the end where the integrator does.
  void run(State& state, double end, Multipliers multipliers = Multipliers::found);

  /// Writes checkpoints of later runs to `path`, each in the place of the one before: at their first state, then after
  /// the first step that ends at or beyond t₀ + k·interval; of several islands, or a simpler scene, where islands meet:
  /// at times that observers wait for, and at the end of a run. Steps are not cut: the run is the same, bit for bit, as
  /// without, but for methods that cannot tell their history (Integrator::history), which start anew there. Throws
  /// FileError from run() where one cannot be written; the run can then be continued.
  void checkpoint(std::string path, Schedule schedule);
  /// A checkpoint of this state, by hand. Where it is the one that the last run ended with, resuming continues with the
  /// same bits as this simulation; any other is one to start from. Methods that cannot tell their history are started
  /// anew, which may move the state by round-off.
  void save(State& state, const std::string& path);
  void save(State& state, Archive& archive);
  /// The state of a checkpoint, from which run() continues with the bits of the run that wrote it: in the same scene,
  /// with the same kind of integrator, islands, observers and events in the same order, all of them added before.
  /// Observers that keep something (Recorder) have it again. Throws FileError for a file that is damaged or of another
  /// version, SceneError where scene, islands, integrator, observers or events differ, saying which; then nothing
  /// has been changed but the integrators, which the next run starts anew.
  State resume(const std::string& path);
  State resume(Archive& archive);

  /// Of the integrator, since it was started from a new state; events that start it anew do not count. The sum of all
  /// islands.
  IntegratorStatistics statistics() const;

  struct IslandReport {
    std::vector<std::string> bodies;
    int degrees_of_freedom;
    std::string integrator;
    bool asleep;
    IntegratorStatistics statistics;  // since the island was started from a new state
  };
  std::vector<IslandReport> islands() const;
  /// The same as text, a line an island, with what ModeFreezing reports of its modes.
  std::string report() const;

 private:
  struct Island;
  void refuse(const std::string& what, const std::string& where) const;
  void check(const State& state, double end) const;
  void advance(State& state, double stop, Multipliers multipliers);
  [[noreturn]] void fail(State& state, const Island& failed, const SimulationError& error);
  void gather(State& state, double time) const;
  void gather_events();
  Snapshot& look(const State& state);
  void history(Archive& archive, State& state);
  void write_due_checkpoint(State& state);

  std::unique_ptr<Simplification> simple_;   // null: the scene runs as drawn
  std::unique_ptr<const System> assembled_;  // null: borrowed
  const System& system_;
  const System& observed_;
  std::vector<std::unique_ptr<Island>> islands_;
  IslandRun* one_ = nullptr;  // runs all that observers see; the rest is of several islands, or a simpler scene
  bool reacts_ = false;       // observers need multipliers: joints rub
  std::vector<EventRecord> events_;

  ObserverSchedules watches_;
  State last_;                // the last good state of all
  bool begun_ = false;        // a run has started there
  State refined_, expanded_;  // scratch
  std::optional<Snapshot> snapshot_;
  bool evaluated_ = false;  // snapshot_ holds last_
  CheckpointSchedule checkpoints_;
  std::optional<SceneFingerprint> scene_;  // once asked for
};

}  // namespace lithe
