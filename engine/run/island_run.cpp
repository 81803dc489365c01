#include "engine/run/island_run.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "engine/assembly/failing_element.h"
#include "engine/assembly/lost_angles.h"
#include "engine/base/error.h"
#include "engine/base/interrupt.h"
#include "engine/base/log.h"
#include "engine/base/number_text.h"

namespace lithe {
namespace {

/// Index of the first entry that is not finite; -1: none.
int find_not_finite(const VectorX& x) {
  if (x.allFinite()) return -1;
  const double* at = std::find_if(x.data(), x.data() + x.size(), [](double value) { return !std::isfinite(value); });
  return static_cast<int>(at - x.data());
}

/// The name of a value that is not finite in a state; empty: nothing.
std::string find_not_finite(const State& state, const Layout& layout) {
  if (!std::isfinite(state.time)) return "the time";
  for (const auto& [vector, what] : {std::pair(&state.v_dot, "acceleration of "), std::pair(&state.v, "velocity of ")})
    if (const int i = find_not_finite(*vector); i >= 0) return what + layout.velocity_name(i);
  if (const int i = find_not_finite(state.lambda); i >= 0) return "multiplier of " + layout.row_name(i);
  const int i = find_not_finite(state.q);
  if (i < 0) return "";
  // The velocity of that coordinate has its name: three for the four numbers of a quaternion.
  for (const Layout::BodySlice& b : layout.bodies()) {
    const int local = i - b.q;
    if (local >= (b.frame ? 7 : 0) + b.linear) continue;
    const int rotation = std::max(local, 4) - 1;
    return "coordinate of " + layout.velocity_name(b.v + (b.frame && local >= 3 ? rotation : local));
  }
  return "coordinate " + std::to_string(i);
}

}  // namespace

IslandRun::IslandRun(const System& system, Integrator& integrator) try
    : system_(system),
      integrator_(integrator),
      equations_(system),
      snapshot_(system),
      inputs_(system),
      projector_(equations_) {
  make_finder();
} catch (...) {
  rethrow_as_error("the simulation", "Simulation", "see what it says");
}

void IslandRun::observe(Observer& observer, Schedule schedule) try { watches_.add(observer, schedule); } catch (...) {
  rethrow_as_error("the simulation", "Simulation::observe", "see what it says");
}

void IslandRun::run(State& state, double end, Multipliers multipliers) {
  check(state, end);
  try {
    go(state, end, multipliers);
  } catch (...) {
    rethrow_as_error("the run with " + integrator_.name(), time_text(state.time),
                     "see what it says; the state reached before is kept");
  }
}

void IslandRun::go(State& state, double end, Multipliers multipliers) {
  begin(state);
  started_ = false;  // until the run has ended well
  struct Release {
    const FollowedInputs& inputs;
    ~Release() { inputs.release(); }
  } const release{inputs_};
  stopped_by_.clear();
  const auto tell_due = [&] {
    const std::string by = watches_.tell_due(state.time, [&]() -> Snapshot& { return look(state); });
    if (!by.empty()) stopped_by_ = by;
    write_due_checkpoint(state);
  };
  follow_inputs(state);
  tell_due();
  follow_inputs(state);  // observers may set some
  // From one observed time to the next; a rest of round-off's size is no step.
  while (end - state.time > time_round_off(end) && stopped_by_.empty()) {
    advance(state, next_stop(state.time, end));
    inputs_.see(state.time);
    tell_due();
    if (const int signal = InterruptGuard::asked(); signal != 0)
      fail(state, "the run was interrupted by signal " + std::to_string(signal) + " (" + strsignal(signal) + ")",
           "run on from the state: it is the last good one, and what was recorded is kept");
    if (end - state.time > time_round_off(end)) follow_inputs(state);
  }
  if (multipliers == Multipliers::found) find_multipliers(state);
  started_ = true;
  steps_ = integrator_.statistics().steps;
}

/// Starts, unless the state goes on from the last run. Schedules begin here for observers that are new, and for all at
/// a new state.
void IslandRun::begin(State& state) {
  const bool resumed = same(state, last_);
  if (!resumed || !started_ || integrator_.statistics().steps != steps_) {
    started_ = false;
    if (!resumed) events_.clear(), restarts_.clear();
    const State given = state;
    try {
      integrator_.start(equations_, state);
      if (finder_) finder_->start(integrator_, state);
    } catch (...) {
      state = given;
      throw;
    }
    earlier_ = {};
    approach_ = {};
    inputs_.see(state.time);
    last_ = state;
    evaluated_ = false;
  }
  watches_.begin(state.time, !resumed);
  checkpoints_.begin(state.time, !resumed);
}

/// Where the integrator has left them out.
void IslandRun::find_multipliers(State& state) {
  if (state.lambda.size() == system_.layout().row_count()) return;
  state.lambda = last_.lambda = look(state).found_multipliers();
}

void IslandRun::check(const State& state, double end) const {
  const Layout& layout = system_.layout();
  if (state.q.size() != layout.q_count() || state.v.size() != layout.v_count())
    throw SceneError("the state has " + std::to_string(state.q.size()) + " coordinates and " +
                         std::to_string(state.v.size()) + " velocities; the system has " +
                         std::to_string(layout.q_count()) + " and " + std::to_string(layout.v_count()),
                     "Simulation::run", "start from system.initial_state()");
  // Accelerations and multipliers are the integrator's to find.
  if (!std::isfinite(state.time) || !state.q.allFinite() || !state.v.allFinite())
    throw SceneError(
        "the state to start from is not finite in " + find_not_finite({state.time, state.q, state.v, {}, {}}, layout),
        "Simulation::run", "start from system.initial_state()");
  if (!std::isfinite(end) || end < state.time - time_round_off(end))
    throw SceneError("cannot run from " + time_text(state.time) + " to " + time_text(end), "Simulation::run",
                     "give a later end: it is a time, not a duration");
}

double IslandRun::next_stop(double time, double end) const {
  const double stop = inputs_.next_stop(time, watches_.next_stop(time, end));
  return approach_.watched >= 0 ? std::min(stop, approach_.time) : stop;
}

void IslandRun::advance(State& state, double stop) {
  StepResult result;
  inputs_.end_at(stop);
  try {
    result = integrator_.step(equations_, state, stop, Multipliers::later);
  } catch (...) {
    state = last_;
    throw;
  }
  const auto step = [&] { return "the step from " + time_text(last_.time); };
  const auto failing_element = [&](double until) {
    const bool inside = until > last_.time && until < stop;
    const std::string found = find_failing_element(equations_, last_, inside ? until : stop);
    return found.empty() ? "" : "; " + found;
  };
  if (!result.ok()) {
    const std::string element = failing_element(stop);
    if (const std::string lost = element.empty() ? find_lost_angle(equations_, last_) : ""; !lost.empty())
      fail(state, step() + " failed: " + result.why + "; " + lost, kLostAngleFix);
    fail(state, step() + " failed: " + result.why + element,
         "give a smaller step or another tolerance; if neither helps, look for what happens there: a locked mechanism, "
         "an impact, a force that grows without bound");
  }
  if (!result.why.empty()) log::info(result.why);
  if (const std::string name = find_not_finite(state, system_.layout()); !name.empty())
    fail(state, step() + " left a value that is not finite: " + name + failing_element(state.time),
         "look for a force that divides by zero or overflows near there, or give a smaller step");
  if (!(state.time > last_.time && state.time <= stop)) {
    if (const std::string lost = state.time == last_.time ? find_lost_angle(equations_, last_) : ""; !lost.empty())
      fail(state, step() + " became shorter than time can tell: " + lost, kLostAngleFix);
    fail(state, step() + " to " + time_text(stop) + " ended at " + time_text(state.time) + failing_element(stop),
         "give a looser tolerance if steps became smaller than time can resolve; else fix the integrator: a step moves "
         "time, never past its stop");
  }
  if (finder_) {
    try {
      look_for_events(state);
    } catch (...) {
      state = last_;
      throw;
    }
  }
  record_happenings(state);
  try {
    last_ = state;
  } catch (...) {  // no memory: both go on without the multipliers, which are found anew
    state.lambda.resize(0), last_.lambda.resize(0);
    last_.quarter_turns = state.quarter_turns;
    throw;
  }
  evaluated_ = false;
}

Snapshot& IslandRun::look(const State& state) {
  if (!evaluated_)
    snapshot_.evaluate(state,
                       integrator_.approximates_accelerations() ? Accelerations::solved : Accelerations::as_left);
  evaluated_ = true;
  return snapshot_;
}

void IslandRun::fail(State& state, const std::string& what, const std::string& fix) {
  state = last_;
  watches_.tell_all(state.time, [&]() -> Snapshot& { return look(state); });
  try {
    find_multipliers(state);
  } catch (const Error&) {  // NOLINT: the failure itself matters more
  }
  throw SimulationError(what, time_text(last_.time) + ", " + integrator_.name(), fix);
}

}  // namespace lithe
