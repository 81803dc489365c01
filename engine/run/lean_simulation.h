#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/motion/make_integrator.h"
#include "engine/run/mode_freezing.h"
#include "engine/run/simulation.h"
#include "engine/run/sleeping_integrator.h"
#include "engine/simplify/simplification.h"

namespace lithe {

/// What may be spared; with nothing spared it is a Simulation.
struct LeanOptions {
  AssembleOptions assemble{};
  bool simplify = false;  // a simpler scene runs (engine/simplify/simplification.h), observers see the whole
  bool split = true;      // islands have steps of their own
  bool sleep = true;      // islands at rest are not stepped
  std::optional<ModeFreezing::Parameters> freeze{};  // quiet modes stand still: around each island's integrator
};

/// The loop over time, island by island: parts of a scene that nothing ties (split(), engine/model/islands.h) have
/// systems and integrators of their own, so that a stiff or fast one does not force its steps on the others; those at
/// rest sleep (engine/run/sleeping_integrator.h). Islands meet at the times that observers wait for, and there
/// observers see the whole.
///   LeanSimulation simulation{graph, [] { return std::make_unique<Automatic>(); }};
///   State state = simulation.start();
///   simulation.observe(recorder, every(0.01));
///   simulation.run(state, 10);
class LeanSimulation {
 public:
  /// Turns a state of the scene that runs into one of the scene that observers see; lambda is left empty.
  using Expand = std::function<void(const State& small, State& whole)>;

  /// An integrator an island. The graph must outlive the simulation. Throws SceneError as assemble() does, and as
  /// ModeFreezing does for parameters that are not positive.
  LeanSimulation(SystemGraph& graph, const MakeIntegrator& make_integrator, const LeanOptions& options = {});
  /// Runs `graph`, a simpler scene made by hand that stands for `whole`, and shows observers that one. Throws
  /// SceneError for LeanOptions::simplify.
  LeanSimulation(SystemGraph& graph, const MakeIntegrator& make_integrator, const System& whole, Expand expand,
                 const LeanOptions& options = {});
  ~LeanSimulation();

  /// What runs, as one: of states given to run().
  const System& system() const { return system_; }
  /// What observers see.
  const System& observed() const { return expand_ ? *whole_ : system_; }
  /// The state of system() in which the scene was drawn.
  State start() const { return simple_ ? simple_->start() : system_.initial_state(); }
  /// Between states of system() and of the whole, and what was done; null without LeanOptions::simplify.
  const Simplification* simplification() const { return simple_.get(); }

  /// Tells `observer` of the states of later runs. Throws SceneError for every_step() where several islands run, or a
  /// simpler scene: they have no steps in common.
  void observe(Observer& observer, Schedule schedule);
  /// Looks for `event` in later runs. Throws SceneError likewise: events watch all of a scene.
  void on(Event event);
  /// Checkpoints of the whole, as Simulation writes them, where islands meet: at the end of a run, and at times that
  /// observers wait for; save() takes the state that the last run ended with.
  void checkpoint(std::string path, Schedule schedule);
  void save(State& state, const std::string& path);
  void save(State& state, Archive& archive);
  State resume(const std::string& path);
  State resume(Archive& archive);

  /// As Simulation has them: of all islands by time, and at one time in their order.
  const std::vector<EventRecord>& events() const;
  const std::string& stopped_by() const;

  /// As Simulation::run, for a state of system(). Of a changed state only the islands that it changes start anew. Where
  /// an island fails, the others are brought to its last good time, observers are told, and SimulationError names its
  /// bodies; if they cannot be, the state is that of the last time at which all met.
  void run(State& state, double end);

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
  bool is_one() const { return islands_.size() == 1 && !expand_; }
  void refuse(const std::string& what, const std::string& where) const;
  void check(const State& state, double end) const;
  void advance(State& state, double stop, Multipliers multipliers);
  [[noreturn]] void fail(State& state, const Island& failed, const SimulationError& error);
  void gather(State& state, double time) const;
  void gather_events();
  Snapshot& look(const State& state);
  void history(Archive& archive, State& state);
  void write_due_checkpoint(State& state);

  std::unique_ptr<Simplification> simple_;  // null: the scene runs as drawn
  const System system_;
  const System* whole_ = nullptr;  // null: system_
  Expand expand_;
  std::vector<std::unique_ptr<Island>> islands_;
  bool reacts_;                      // observers need multipliers: joints rub
  std::vector<EventRecord> events_;  // of all islands, where there are several

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
