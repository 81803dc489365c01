#include "engine/run/simulation.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <unordered_map>

#include "engine/base/error.h"
#include "engine/base/number_text.h"
#include "engine/model/islands.h"
#include "engine/run/island_run.h"
#include "engine/run/sleeping_integrator.h"
#include "engine/simplify/simplification.h"

namespace lithe {
namespace {

/// A run of numbers that a vector of the whole and one of an island share.
struct Share {
  int whole, island, count;
};
using Shares = std::vector<Share>;

void scatter(const Shares& shares, const VectorX& whole, VectorX& island) {
  for (const Share& s : shares) island.segment(s.island, s.count) = whole.segment(s.whole, s.count);
}
void gather(const Shares& shares, const VectorX& island, VectorX& whole) {
  for (const Share& s : shares) whole.segment(s.whole, s.count) = island.segment(s.island, s.count);
}
bool same(const Shares& shares, const VectorX& whole, const VectorX& island) {
  return std::all_of(shares.begin(), shares.end(), [&](const Share& s) {
    return whole.segment(s.whole, s.count) == island.segment(s.island, s.count);
  });
}

/// Where the numbers of each body and connector lie.
struct Places {
  struct Place {
    int row, row_count, angle, angle_count;
  };
  std::unordered_map<const Body*, Layout::BodySlice> bodies;
  std::unordered_map<const Connector*, Place> connectors;
  std::unordered_map<const ContactElement*, int> contacts;
  int angles = 0;

  explicit Places(const System& system) {
    for (const auto& slice : system.layout().bodies()) bodies.emplace(slice.body, slice);
    const SystemGraph& graph = system.graph();
    for (std::size_t i = 0; i < graph.constraints().size(); ++i) {
      const auto& rows = system.layout().rows()[i];
      add(*graph.constraints()[i].constraint, rows.first, rows.count);
    }
    for (const auto& f : graph.forces()) add(*f.force, 0, 0);
    for (const ContactRecord& contact : system.contacts()) contacts.emplace(contact.element, contact.number);
  }
  void add(const Connector& connector, int row, int rows) {
    const int count = static_cast<int>(connector.angles().size());
    connectors[&connector] = {row, rows, angles, count};
    angles += count;
  }
};

/// "'crank', 'rod' and 3 more"
std::string names(const Layout& layout) {
  constexpr std::size_t kNamed = 3;
  const std::vector<std::string> bodies = layout.body_names();
  const std::size_t named = bodies.size() <= kNamed + 1 ? bodies.size() : kNamed;
  std::string text;
  for (std::size_t i = 0; i < named; ++i) text += (i == 0 ? "'" : ", '") + bodies[i] + "'";
  if (named < bodies.size()) text += " and " + std::to_string(bodies.size() - named) + " more";
  return text;
}

}  // namespace

/// A part of the scene, with all that runs it.
struct Simulation::Island {
  /// The whole as one island.
  Island(const System& whole, Integrator& borrowed)
      : system(whole),
        freezing(dynamic_cast<const ModeFreezing*>(&borrowed)),
        sleeper(dynamic_cast<const SleepingIntegrator*>(&borrowed)),
        integrator(borrowed),
        run(system, integrator) {}
  Island(const System& whole, std::unique_ptr<Integrator> method, bool sleep)
      : system(whole),
        owned(std::move(method)),
        freezing(dynamic_cast<const ModeFreezing*>(owned.get())),
        sleeper(make_sleeper(sleep)),
        integrator(*owned),
        run(system, integrator),
        state(whole.initial_state()) {
    find_shares(Places(whole));
  }
  Island(std::unique_ptr<SystemGraph> part, const Places& whole, std::unique_ptr<Integrator> method,
         const SimulationOptions& options)
      : graph(std::move(part)),
        assembled(std::make_unique<const System>(assemble(*graph, options.assemble))),
        system(*assembled),
        owned(std::move(method)),
        freezing(dynamic_cast<const ModeFreezing*>(owned.get())),
        sleeper(make_sleeper(options.sleep)),
        integrator(*owned),
        run(system, integrator),
        state(system.initial_state()) {
    find_shares(whole);
  }

  void find_shares(const Places& whole) {
    const Places own(system);
    for (const auto& [body, slice] : own.bodies) {
      const Layout::BodySlice& there = whole.bodies.at(body);
      q.push_back({there.q, slice.q, body->coordinates().q_count()});
      v.push_back({there.v, slice.v, body->coordinates().v_count()});
    }
    for (const auto& [connector, place] : own.connectors) {
      const Places::Place& there = whole.connectors.at(connector);
      rows.push_back({there.row, place.row, place.row_count});
      angles.push_back({there.angle, place.angle, place.angle_count});
    }
    for (const ContactRecord& contact : system.contacts()) contacts.push_back(whole.contacts.at(contact.element));
  }

  /// Puts its integrator into one that may sleep; null: it must not.
  const SleepingIntegrator* make_sleeper(bool may_sleep) {
    if (!may_sleep || depends_on_time(system.graph())) return nullptr;
    auto wrapped = std::make_unique<SleepingIntegrator>(std::move(owned));
    const SleepingIntegrator* made = wrapped.get();
    owned = std::move(wrapped);
    return made;
  }
  bool asleep() const { return sleeper && sleeper->asleep(); }

  /// Takes its part of a state, unless it is where it stands: then it goes on as if nobody had asked. What sleeps does
  /// not watch the clock.
  void take(const State& whole) {
    if ((whole.time == state.time || asleep()) && same(q, whole.q, state.q) && same(v, whole.v, state.v) &&
        same(v, whole.v_dot, state.v_dot))
      return;
    touched = true;
    state = system.initial_state();
    state.time = whole.time;
    scatter(q, whole.q, state.q);
    scatter(v, whole.v, state.v);
    scatter(v, whole.v_dot, state.v_dot);
    if (whole.lambda.size() > 0) scatter(rows, whole.lambda, state.lambda);
    scatter(angles, whole.quarter_turns, state.quarter_turns);
    state.contacts.clear();
    for (const ContactTrace& trace : whole.contacts)
      for (std::size_t i = 0; i < contacts.size(); ++i)
        if (contacts[i] == trace.element) state.contacts.emplace_back(trace).element = static_cast<int>(i);
  }

  /// The same of a state that it has passed: what happened up to there has happened.
  void take_back(const State& whole) {
    const auto& all = run.events_;
    events_before.assign(
        all.begin(), std::find_if(all.begin(), all.end(), [&](const EventRecord& e) { return e.time > whole.time; }));
    take(whole);
  }

  void move(double stop, Multipliers multipliers) {
    if (!touched && sleeper && sleeper->sleeps_until(stop)) return;
    touched = false;
    run.run(state, stop, multipliers);
    run.events_.insert(run.events_.begin(), events_before.begin(), events_before.end());
    events_before.clear();
  }

  std::unique_ptr<SystemGraph> graph;       // null: the whole's
  std::unique_ptr<const System> assembled;  // likewise
  const System& system;
  std::unique_ptr<Integrator> owned;  // null: borrowed
  const ModeFreezing* freezing;       // null: no modes are frozen
  const SleepingIntegrator* sleeper;  // null: it never sleeps
  Integrator& integrator;
  IslandRun run;
  State state;                             // its time stands still while it sleeps
  bool touched = true;                     // since it moved last
  long earlier_events = 0;                 // that it had when the run of the whole began
  std::vector<EventRecord> events_before;  // of the time that it was taken back to, until it moves
  Shares q, v, rows, angles;
  std::vector<int> contacts;  // number in the whole of each of its contact elements
};

Simulation::Simulation(const System& system, Integrator& integrator) try : system_(system), observed_(system) {
  islands_.push_back(std::make_unique<Island>(system, integrator));
  one_ = &islands_.front()->run;
} catch (...) {
  rethrow_as_error("the simulation", "Simulation", "see what it says");
}

Simulation::Simulation(SystemGraph& graph, const MakeIntegrator& make_integrator, const SimulationOptions& options)
    : simple_(options.simplify ? std::make_unique<Simplification>(graph) : nullptr),
      assembled_(std::make_unique<const System>(assemble(simple_ ? simple_->graph() : graph, options.assemble))),
      system_(*assembled_),
      observed_(simple_ ? simple_->whole() : system_) {
  SystemGraph& runs = simple_ ? simple_->graph() : graph;
  const auto make = [&]() -> std::unique_ptr<Integrator> {
    if (!options.freeze) return make_integrator();
    return std::make_unique<ModeFreezing>(make_integrator(), *options.freeze);
  };
  auto parts = split(runs);
  const Places places(system_);
  if (options.split && parts.size() > 1)
    for (auto& part : parts) islands_.push_back(std::make_unique<Island>(std::move(part), places, make(), options));
  else
    islands_.push_back(std::make_unique<Island>(system_, make(), options.sleep));
  if (islands_.size() == 1 && !simple_) one_ = &islands_.front()->run;
  reacts_ = std::any_of(runs.forces().begin(), runs.forces().end(),
                        [](const auto& f) { return f.force->reaction_of() != nullptr; });
}

Simulation::~Simulation() = default;

State Simulation::start() const { return simple_ ? simple_->start() : system_.initial_state(); }

void Simulation::refuse(const std::string& what, const std::string& where) const {
  throw SceneError(what + (islands_.size() > 1 ? "this one runs as " + std::to_string(islands_.size()) + " islands"
                                               : "another, simpler one runs"),
                   "Simulation::" + where, "use {.simplify = false, .split = false}");
}

void Simulation::observe(Observer& observer, Schedule schedule) {
  if (one_) return one_->observe(observer, schedule);
  if (schedule.interval == 0) refuse("observers of every step need a scene with steps in common, and ", "observe");
  watches_.add(observer, schedule);
}

void Simulation::on(Event event) {
  if (!one_) refuse("events watch all of a scene at every step, and ", "on");
  one_->on(std::move(event));
}

const std::vector<EventRecord>& Simulation::events() const { return one_ ? one_->events() : events_; }
/// Within a run there are only ever more of them.
void Simulation::gather_events() {
  long count = 0;
  for (const auto& island : islands_) count += std::ssize(island->run.events()) - island->earlier_events;
  if (count == std::ssize(events_)) return;
  events_.clear();
  for (const auto& island : islands_) {
    const auto& own = island->run.events();
    events_.insert(events_.end(), own.begin() + island->earlier_events, own.end());
  }
  std::stable_sort(events_.begin(), events_.end(),
                   [](const EventRecord& a, const EventRecord& b) { return a.time < b.time; });
}
const std::string& Simulation::stopped_by() const { return islands_.front()->run.stopped_by(); }

void Simulation::check(const State& state, double end) const {
  const Layout& layout = system_.layout();
  if (state.q.size() != layout.q_count() || state.v.size() != layout.v_count())
    throw SceneError("the state has " + std::to_string(state.q.size()) + " coordinates and " +
                         std::to_string(state.v.size()) + " velocities; the scene that runs has " +
                         std::to_string(layout.q_count()) + " and " + std::to_string(layout.v_count()),
                     "Simulation::run", "start from start() of the simulation");
  if (!std::isfinite(end) || end < state.time - time_round_off(end))
    throw SceneError("cannot run from " + time_text(state.time) + " to " + time_text(end), "Simulation::run",
                     "give a later end: it is a time, not a duration");
}

void Simulation::run(State& state, double end, Multipliers multipliers) {
  if (one_) return one_->run(state, end, multipliers);
  check(state, end);
  // Accelerations and multipliers are the integrators' to find.
  if (state.v_dot.size() != state.v.size()) state.v_dot.setZero(state.v.size());
  if (state.lambda.size() != system_.layout().row_count()) state.lambda.resize(0);
  const VectorX& drawn = system_.initial_state().quarter_turns;
  if (state.quarter_turns.size() != drawn.size()) state.quarter_turns = drawn;

  // 1. To each island its part; those that it changes start anew, accelerations become consistent.
  const bool resumed = begun_ && same(state, last_);
  for (auto& island : islands_) island->take(state);
  if (!resumed) {
    events_.clear();
    for (auto& island : islands_) island->earlier_events = island->touched ? 0 : std::ssize(island->run.events());
    last_ = state;
    evaluated_ = false;
  }
  const auto needed = [&](double stop) {
    return reacts_ ? Multipliers::found : stop == end ? multipliers : Multipliers::later;
  };
  begun_ = resumed;
  if (!resumed) advance(state, state.time, needed(state.time));
  begun_ = true;
  watches_.begin(state.time, !resumed);
  checkpoints_.begin(state.time, !resumed);
  std::string stopped_by;
  const auto tell_due = [&] {
    stopped_by = watches_.tell_due(state.time, [&]() -> Snapshot& { return look(state); });
    write_due_checkpoint(state);
  };
  tell_due();

  // 2. From one meeting to the next.
  while (end - state.time > time_round_off(end) && stopped_by.empty()) {
    const double stop = watches_.next_stop(state.time, end);
    advance(state, stop, needed(stop));
    tell_due();
  }
  islands_.front()->run.stopped_by_ = stopped_by;
}

/// All islands to `stop`.
void Simulation::advance(State& state, double stop, Multipliers multipliers) {
  for (auto& island : islands_) {
    try {
      island->move(stop, multipliers);
    } catch (const SimulationError& error) {
      fail(state, *island, error);
    }
  }
  gather(state, stop);
  gather_events();
  last_ = state;
  evaluated_ = false;
}

void Simulation::checkpoint(std::string path, Schedule schedule) {
  if (one_) return one_->checkpoint(std::move(path), schedule);
  if (path.empty()) throw SceneError("checkpoints need a path", "Simulation::checkpoint", "give one, as in \"run.h5\"");
  checkpoints_ = {std::move(path), schedule};
}

void Simulation::save(State& state, Archive& archive) {
  if (one_) return one_->save(state, archive);
  if (!begun_ || !same(state, last_)) run(state, state.time);
  history(archive, state);
}

void Simulation::save(State& state, const std::string& path) {
  Archive archive(path);
  save(state, archive);
  write_checkpoint(archive, path);
}

State Simulation::resume(Archive& archive) {
  if (!archive.loads()) archive.rewind();  // the one that was just saved into
  if (one_) return one_->resume(archive);
  State state = system_.initial_state();
  begun_ = false;  // unless all goes well
  history(archive, state);
  begun_ = true;
  return state;
}

State Simulation::resume(const std::string& path) {
  Archive archive = read_checkpoint(path);
  return resume(archive);
}

void Simulation::write_due_checkpoint(State& state) {
  if (!checkpoints_.pass(state.time)) return;
  Archive archive(checkpoints_.path());
  history(archive, state);
  write_checkpoint(archive, checkpoints_.path());
}

/// Where all islands have met.
void Simulation::history(Archive& archive, State& state) {
  if (!scene_) scene_.emplace(system_);
  scene_->same(archive);
  archive.same("islands", static_cast<double>(islands_.size()));
  archive("time", state.time);
  for (std::size_t i = 0; i < islands_.size(); ++i)
    archive.group("island " + std::to_string(i), [&] {
      Island& island = *islands_[i];
      island.run.history(archive, island.state);
      island.run.started_ = true;
      archive("touched", island.touched);
      archive("earlier events", island.earlier_events);
    });
  if (archive.loads()) state.v_dot.setZero(system_.layout().v_count());
  if (archive.loads()) events_.clear(), gather_events();
  gather(state, state.time);
  if (archive.loads() || !same(state, last_)) last_ = state, evaluated_ = false;
  archive.group("observers", [&] { watches_.history(archive); });
  archive.group("checkpoints", [&] { checkpoints_.history(archive); });
}

void Simulation::fail(State& state, const Island& failed, const SimulationError& error) {
  state = last_;
  try {
    const double time = failed.state.time;
    for (auto& island : islands_) {
      if (island.get() == &failed) continue;
      if (island->state.time > time) island->take_back(last_);
      island->move(time, Multipliers::found);
    }
    gather(state, time);
    evaluated_ = evaluated_ && same(state, last_);
    last_ = state;
  } catch (const SimulationError&) {  // NOLINT: they met at last_
  }
  gather_events();
  watches_.tell_all(state.time, [&]() -> Snapshot& { return look(state); });
  throw SimulationError("in the island of " + names(failed.system.layout()) + ": " + error.problem(), error.where(),
                        error.fix());
}

void Simulation::gather(State& state, double time) const {
  const bool found = std::all_of(islands_.begin(), islands_.end(), [](const auto& island) {
    return island->state.lambda.size() == island->system.layout().row_count();
  });
  state.lambda.resize(found ? system_.layout().row_count() : 0);
  state.time = time;
  for (const auto& island : islands_) {
    const State& part = island->state;
    lithe::gather(island->q, part.q, state.q);
    lithe::gather(island->v, part.v, state.v);
    lithe::gather(island->v, part.v_dot, state.v_dot);
    if (found) lithe::gather(island->rows, part.lambda, state.lambda);
    lithe::gather(island->angles, part.quarter_turns, state.quarter_turns);
  }
  state.contacts.clear();
  for (const auto& island : islands_)
    for (const ContactTrace& trace : island->state.contacts)
      state.contacts.emplace_back(trace).element = island->contacts[trace.element];
  std::stable_sort(state.contacts.begin(), state.contacts.end(),
                   [](const ContactTrace& a, const ContactTrace& b) { return a.element < b.element; });
}

/// As observers see it: of islands whose method approximates accelerations and multipliers, those of their equations.
Snapshot& Simulation::look(const State& state) {
  if (!snapshot_) snapshot_.emplace(observed_);
  if (evaluated_) return *snapshot_;
  refined_ = state;
  for (const auto& island : islands_) {
    if (!island->integrator.approximates_accelerations()) continue;
    Snapshot& part = island->run.look(island->state);
    lithe::gather(island->v, part.accelerations(), refined_.v_dot);
    if (refined_.lambda.size() > 0) lithe::gather(island->rows, part.multipliers(), refined_.lambda);
  }
  if (simple_) simple_->expand(refined_, expanded_);
  snapshot_->evaluate(simple_ ? expanded_ : refined_);
  evaluated_ = true;
  return *snapshot_;
}

IntegratorStatistics Simulation::statistics() const {
  IntegratorStatistics sum;
  for (const auto& island : islands_) sum += island->run.statistics();
  return sum;
}

std::vector<Simulation::IslandReport> Simulation::islands() const {
  std::vector<IslandReport> reports;
  for (const auto& island : islands_) {
    reports.push_back({island->system.layout().body_names(), island->system.degrees_of_freedom(),
                       island->integrator.name(), island->asleep(), island->run.statistics()});
  }
  return reports;
}

std::string Simulation::report() const {
  std::ostringstream text;
  const auto reports = islands();
  text << reports.size() << (reports.size() == 1 ? " island\n" : " islands\n");
  for (std::size_t i = 0; i < reports.size(); ++i) {
    const auto& [bodies, freedoms, integrator, asleep, done] = reports[i];
    text << "  " << names(islands_[i]->system.layout()) << ": " << freedoms << " degrees of freedom, " << integrator;
    if (asleep)
      text << ", asleep";
    else
      text << ", " << done.steps << " steps, " << done.evaluations << " evaluations";
    if (islands_[i]->freezing) text << "; " << islands_[i]->freezing->report();
    text << "\n";
  }
  return text.str();
}

}  // namespace lithe
