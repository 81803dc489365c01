#include "engine/gradient/recorded_run.h"

#include <algorithm>
#include <optional>

#include "engine/base/error.h"
#include "engine/contact/contact_forces.h"
#include "engine/gradient/contact_numbers.h"
#include "engine/gradient/event_landing.h"
#include "engine/observe/observer_schedules.h"
#include "engine/study/study_run.h"

namespace lithe {

namespace {

std::size_t bytes_of(const State& s) {
  return sizeof(State) +
         sizeof(double) * static_cast<std::size_t>(s.q.size() + s.v.size() + s.v_dot.size() + s.lambda.size() +
                                                   s.quarter_turns.size()) +
         sizeof(int) * s.left_out.size();
}

[[noreturn]] void refuse(const ParametricScene& scene, const std::string& what, const std::string& fix) {
  throw SceneError(what, "the gradient of scene '" + scene.name + "'", fix);
}

}  // namespace

RecordedRun::RecordedRun(const ParametricScene& scene, const Drawing& drawing, std::size_t memory, const Look& look)
    : scene_(scene), drawing_(drawing), equations_(drawing.system()), memory_(memory) {
  if (!(scene.duration > 0)) refuse(scene, "its duration is not positive", "give one in seconds");
  if (!scene.integrator) refuse(scene, "it has no integrator", "give ParametricScene::integrator");
  integrator_ = scene.integrator();
  method_ = dynamic_cast<const DifferentiableSteps*>(integrator_.get());
  if (method_) derivative_ = method_->step_derivative();
  if (!derivative_ && !(method_ && method_->repeated_step(equations_)))
    refuse(scene, "the steps of " + integrator_->name() + " with these settings cannot be differentiated yet",
           "take GeneralizedAlpha{{.step = ...}} (index 3, one fixed step), ExplicitRungeKutta, Radau or LieBdf; "
           "for contacts between rigid surfaces MoreauJean");
  if (equations_.contacts()) refuse_contacts();
  repeats_ = !derivative_;

  State state = drawing.system().initial_state(), before;
  const double begun = thread_seconds();
  double aside = 0;  // s, spent on the tape and on looking
  integrator_->start(equations_, state);
  state_bytes_ = bytes_of(state);
  const auto note = [&](double stop) {
    const double now = thread_seconds();
    record(state, stop);
    look(state);
    aside += thread_seconds() - now;
  };
  note(0);
  std::optional<EventLanding> events;
  // Of rigid contacts time stepping knows the kinks; elsewhere they are passed within steps where these cannot be taken
  // again.
  const bool rigid = equations_.parts().rigid_contacts;
  const bool at_kinks = !rigid && method_->repeated_step(equations_) != nullptr;
  if (!rigid) events.emplace(scene, drawing, at_kinks, *integrator_, equations_, state);
  if (events && events->empty()) events.reset();
  double stop = scene.duration, usual = 0, settled = 0;  // s
  while (scene.duration - state.time > time_round_off(scene.duration)) {
    before = state;
    if (events) events->remember(state);
    advance(*integrator_, equations_, state, stop);
    if (events && events->cut(before, state, stop)) continue;
    if (const std::string why = derivative_ ? derivative_->refuse_step(before, state) : ""; !why.empty())
      refuse(scene, "the step to t = " + std::to_string(state.time) + " s cannot be differentiated: " + why,
             "look for a singular pose on the way, or take another method");
    if (const auto record = method_->step_record();
        derivative_ && derivative_->by_repetition({before, state, record.get()}))
      repeats_ = true;
    const bool at_kink = events && events->met() && events->at_kink(), at_event = events && events->met() && !at_kink;
    // Short steps behind a kink join that over it, until states no longer pass the kink when they are moved.
    if (at_kink) settled = state.time + std::max(usual, state.time - before.time);
    if (state.time < settled && !at_event && scene.duration - state.time > time_round_off(scene.duration)) {
      kinks_[steps() + 1].push_back({at_kink ? events->kink() : -1, stop, state.time, method_->step_record()});
      repeats_ = true;
      if (at_kink) integrator_->start(equations_, state);
    } else {
      usual = state.time - times_.back();
      note(stop);
    }
    if (at_kink) {
      stop = scene.duration;
      events->go_on(state);
      continue;
    }
    if (!events || !events->met()) continue;
    jump(events->number(), *integrator_, equations_, state);
    events_[steps() + 1] = events->number();
    stop = scene.duration;
    note(stop);
    events->go_on(state);
  }
  seconds_ = thread_seconds() - begun - aside;
  if (!all_) states_.clear();
  find_probes();
}

/// What contacts there are, and how methods take them.
void RecordedRun::refuse_contacts() {
  const bool rigid = equations_.contacts()->any_rigid();
  if (derivative_ && equations_.contacts()->remembers())
    refuse(scene_,
           "its contacts remember (a restitution's speed of impact, bristles), which " + integrator_->name() +
               " cannot differentiate yet",
           "take ExplicitRungeKutta or Radau");
  if (rigid && !scene_.events.empty())
    refuse(scene_, "events with contacts between rigid surfaces cannot be differentiated yet",
           "leave the events out, or give the contacts a compliant law");
  if (const std::string why = method_->refuse_repetition(equations_); !why.empty())
    refuse(scene_, why, "leave it out, or take differences of runs with sweep()");
}

/// The tape's own states, or checkpoints.
void RecordedRun::find_probes() {
  for (const double share : {0.0, 0.37, 1.0}) {
    if (all_)
      probes_.push_back(states_[static_cast<std::size_t>(share * static_cast<double>(states_.size() - 1))].state);
    else
      probes_.push_back(
          checkpoints_[static_cast<std::size_t>(share * static_cast<double>(checkpoints_.size() - 1))].state);
    VectorX& lambda = probes_.back().lambda;
    if (lambda.size() == 0) lambda.setZero(equations_.layout().row_count());  // of a method that leaves it out
  }
}

RecordedRun::~RecordedRun() = default;

int RecordedRun::event_before(long state) const {
  const auto found = events_.find(state);
  return found == events_.end() ? -1 : found->second;
}

void RecordedRun::jump(int event, Integrator& integrator, Evaluator& equations, State& state) const {
  apply_event(scene_.events[static_cast<std::size_t>(event)], drawing_, equations, state);
  integrator.start(equations, state);
}

void RecordedRun::record(const State& state, double stop) {
  if (touching_.empty() && !state.contacts.empty()) touching_.push_back(state);
  memory_at_end_ = contact_numbers(state.contacts).size();
  times_.push_back(state.time);
  stops_.push_back(stop);
  keep(state, steps());
}

void RecordedRun::advance(Integrator& integrator, Evaluator& equations, State& state, double stop) const {
  double before = state.time;
  const auto& method = dynamic_cast<const DifferentiableSteps&>(integrator);
  StepResult result;
  do {
    before = state.time;
    result = integrator.step(equations, state, stop, Multipliers::later);
  } while (result.ok() && state.time > before && method.within_step(state));
  if (!result.ok() || !(state.time > before) || !state.q.allFinite() || !state.v.allFinite())
    throw SimulationError("the step from t = " + std::to_string(before) +
                              " s failed: " + (result.ok() ? "it left values that are not finite" : result.why),
                          "scene '" + scene_.name + "', " + integrator.name(), "run it with Simulation to see more");
}

/// A state of the first pass.
void RecordedRun::keep(const State& state, long step) {
  if (step % stride_ == 0) {
    Checkpoint& mark = checkpoints_.emplace_back();
    mark.state = state;
    State copy = state;
    integrator_->history(mark.history, equations_, copy);
    mark.history.rewind();
    // Half of the memory is for checkpoints, half for the stretch between two.
    if (checkpoint_bytes_ == 0) checkpoint_bytes_ = state_bytes_ + mark.history.bytes().size();
    if (checkpoints_.size() > 1 && checkpoints_.size() * checkpoint_bytes_ > memory_ / 2) thin();
  }
  if (!all_) return;
  add(state, step, *integrator_);
  bytes_ = states_bytes_;
  if (bytes_ > memory_) {
    all_ = false;
    states_ = {};
  }
}

/// To the states in memory.
void RecordedRun::add(const State& state, long step, const Integrator& integrator) {
  const auto kinks = kinks_.find(step);
  const Taken& taken =
      states_.emplace_back(Taken{state, dynamic_cast<const DifferentiableSteps&>(integrator).step_record(),
                                 kinks == kinks_.end() ? std::vector<PassedKink>{} : kinks->second});
  states_bytes_ += state_bytes_ + (taken.record ? taken.record->bytes() : 0);
}

/// Every second checkpoint goes.
void RecordedRun::thin() {
  std::vector<Checkpoint> kept;
  for (std::size_t i = 0; i < checkpoints_.size(); i += 2) kept.push_back(std::move(checkpoints_[i]));
  checkpoints_ = std::move(kept);
  stride_ *= 2;
}

int RecordedRun::stretch_count() const { return all_ ? 1 : static_cast<int>((steps() + stride_ - 1) / stride_); }

long RecordedRun::first(int stretch) const { return all_ ? 0 : stretch * stride_; }

const std::vector<RecordedRun::Taken>& RecordedRun::stretch(int number) {
  if (all_ || number == present_) return states_;
  present_ = number;
  Checkpoint& mark = checkpoints_[static_cast<std::size_t>(number)];
  State state = mark.state;
  const auto integrator = scene_.integrator();
  Evaluator equations(drawing_.system());
  State start = state;
  integrator->start(equations, start);
  equations.recall(state.quarter_turns);
  integrator->history(mark.history, equations, state);
  states_.clear();
  states_bytes_ = 0;
  add(state, number * stride_, *integrator);
  const long last = std::min(steps(), (number + 1) * stride_);
  for (long step = number * stride_; step < last; ++step) {
    if (const auto kinks = kinks_.find(step + 1); kinks != kinks_.end())
      for (const PassedKink& kink : kinks->second) {
        advance(*integrator, equations, state, kink.stop);
        if (kink.number >= 0) integrator->start(equations, state);
      }
    if (const int event = event_before(step + 1); event >= 0)
      jump(event, *integrator, equations, state);
    else
      advance(*integrator, equations, state, stops_[static_cast<std::size_t>(step) + 1]);
    if (state.time != times_[static_cast<std::size_t>(step) + 1])
      throw SimulationError("the run from a checkpoint at t = " + std::to_string(mark.state.time) + " s left its steps",
                            "RecordedRun", "give more memory, so that all states are kept");
    add(state, step + 1, *integrator);
  }
  bytes_ = std::max(bytes_, states_bytes_ + checkpoints_.size() * checkpoint_bytes_);
  return states_;
}

}  // namespace lithe
