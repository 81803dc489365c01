#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/base/error.h"
#include "engine/base/number_text.h"
#include "engine/contact/rigid_contacts.h"
#include "engine/run/island_run.h"
#include "engine/run/kinks.h"

namespace lithe {
namespace {

constexpr double kSameTime = 1e-12;      // relative: passages that are one event
constexpr double kNearEnd = 1e-3;        // of a step: a switch passed there has not spoilt it
constexpr int kMaxApproaches = 4;        // of one switch
constexpr std::size_t kManyEvents = 16;  // in a row
constexpr double kShortly = 1e-5;        // of the time since the first of them

}  // namespace

void IslandRun::on(Event event) {
  if (event.name.empty() || !event.function)
    throw SceneError(event.name.empty() ? "an event has no name" : "the event '" + event.name + "' watches nothing",
                     "Simulation::on", "give .name and .function, as in .function = watch(height(ball.marker()))");
  watched_events_.push_back(std::move(event));
  make_finder();
  started_ = false;  // functions have no values yet
}

void IslandRun::make_finder() {
  finder_.reset();
  const auto finder = [&]() -> EventFinder& { return finder_ ? *finder_ : finder_.emplace(system_); };
  for (const Event& e : watched_events_) finder().add(e.name, e.function, e.level, e.direction);
  meetings_.clear();
  for (const Kink& kink : find_kinks(system_)) {
    finder().add(kink.name, kink.function, kink.level, Event::Direction::both);
    if (kink.a >= 0) meetings_.push_back({kink.name, kink.a, kink.b});
  }
}

IntegratorStatistics IslandRun::statistics() const {
  IntegratorStatistics sum = earlier_;
  sum += integrator_.statistics();
  return sum;
}

void IslandRun::restart(State& state) {
  earlier_ += integrator_.statistics();
  integrator_.start(equations_, state);
}

bool IslandRun::ends_step(int watched) const {
  return is_switch(watched) || watched_events_[watched].action != Event::Action::record;
}

void IslandRun::record(const EventFinder::Crossing& crossing) {
  events_.push_back({crossing.time, watched_events_[crossing.watched].name, crossing.watched});
}

/// What time stepping tells of rigid surfaces in the step from last_ to `state`, among the events of that step by time.
void IslandRun::record_happenings(const State& state) {
  RigidContacts* contacts = equations_.parts().rigid_contacts;
  if (!contacts) return;
  for (const RigidContacts::Happening& happening : contacts->happenings()) {
    const double time = last_.time + happening.time;
    if (time > state.time) continue;  // the state has been moved back to an event before
    const auto later = std::upper_bound(events_.begin(), events_.end(), time,
                                        [](double t, const EventRecord& e) { return t < e.time; });
    events_.insert(later, {time, system_.contacts()[happening.element].element->name(), -1, happening.event});
  }
  contacts->happenings().clear();
}

/// After a step from last_ to `state`: what passed its level in it. Moves the state back to the first event that ends
/// the step.
void IslandRun::look_for_events(State& state) {
  const double h = state.time - last_.time;
  const auto& crossings = finder_->find(integrator_, last_, state);
  const auto end = std::find_if(crossings.begin(), crossings.end(),
                                [&](const EventFinder::Crossing& c) { return ends_step(c.watched); });
  // 1. Beyond a switch another law holds, which has spoilt the step and its dense output: once more, up to there.
  if (end != crossings.end() && is_switch(end->watched) && approach_.tries < kMaxApproaches &&
      end->time - last_.time > kNearEnd * h && state.time - end->time > kNearEnd * h) {
    approach_ = {end->watched, approach_.tries + 1, end->time};
    state = last_;
    return restart(state);
  }
  // 2. What is but recorded, up to the end of the step.
  for (auto c = crossings.begin(); c != end; ++c) record(*c);
  met_.clear();
  if (end == crossings.end()) {
    if (approach_.watched < 0 || state.time < approach_.time) return finder_->accept();
    // The spoilt step told too early a time: on from here, or surfaces would count as met that do not touch yet.
    const double left = finder_->time_left(approach_.watched, h);
    if (approach_.tries < kMaxApproaches && left > kSameTime * std::abs(state.time)) {
      approach_ = left < h ? Approach{approach_.watched, approach_.tries + 1, state.time + left} : Approach{};
      return finder_->accept();
    }
    met_.push_back({approach_.watched, state.time, finder_->below(approach_.watched)});  // round-off before its switch
  } else {
    // 3. To the event, with all others that happen then.
    const double same = kSameTime * std::max(std::abs(end->time), h);
    double time = end->time;
    for (auto c = end; c != crossings.end() && c->time <= end->time + same; ++c) {
      time = c->time;
      met_.push_back(*c);
      if (!is_switch(c->watched)) record(*c);
    }
    integrator_.interpolate(system_.layout(), last_, state, time, at_event_);
    state = at_event_;
  }
  meet(state);
}

void IslandRun::move_onto_constraints(State& state) {
  constexpr double kTolerance = 1e-13;  // in the units of the rows; or round-off if larger
  constexpr int kMaxIterations = 20;
  equations_.recall(state.quarter_turns);
  if (!projector_.position(state.time, state.q, kTolerance, kMaxIterations).converged)
    fail(state, "the state at an event cannot be moved onto the constraints",
         "give a smaller step or tolerance; if the event changes positions, leave them where joints close");
  equations_.track(state.quarter_turns);
  projector_.velocity(state.time, state.q, state.v);
}

/// Where an input jumps or bends, or has been set: what holds from here on begins anew.
void IslandRun::follow_inputs(State& state) {
  if (!inputs_.changed(state.time)) return;
  move_onto_constraints(state);
  restart(state);
  if (finder_) finder_->start(integrator_, state);
  approach_ = {};
  last_ = state;
  evaluated_ = false;
}

/// Goes on from the events in met_, with `state` at their time.
void IslandRun::meet(State& state) {
  equations_.recall(state.quarter_turns);
  equations_.evaluate(state.time, state.q, state.v, Level::position);
  equations_.track(state.quarter_turns);
  move_onto_constraints(state);
  const double time = state.time;
  bool restarted = false;
  const int first_meeting = finder_->count() - static_cast<int>(meetings_.size());
  for (const EventFinder::Crossing& c : met_) {
    if (c.watched < first_meeting) continue;
    const Meeting& pair = meetings_[c.watched - first_meeting];
    events_.push_back(
        {time, pair.name, -1, {c.rising ? ContactChange::parting : ContactChange::meeting, pair.a, pair.b}});
  }
  for (const EventFinder::Crossing& c : met_) {
    if (is_switch(c.watched)) continue;
    const Event& event = watched_events_[c.watched];
    if (event.action == Event::Action::stop && stopped_by_.empty()) stopped_by_ = event.name;
    restarted |= event.action == Event::Action::restart;
    if (!event.change) continue;
    try {
      event.change(state);
    } catch (...) {
      rethrow_as_error("the change of the event '" + event.name + "'", time_text(time),
                       "see what it does to the state");
    }
    state.time = time;
    check(state, time);
    move_onto_constraints(state);
  }
  restart(state);
  finder_->start(integrator_, state);
  for (const EventFinder::Crossing& c : met_) finder_->dealt_with(c.watched);
  approach_ = {};
  if (!restarted) return;
  if (restarts_.empty()) first_restart_ = time;
  restarts_.push_back(time);
  if (restarts_.size() > kManyEvents) restarts_.erase(restarts_.begin());
  const auto restarting =
      std::find_if(met_.begin(), met_.end(), [&](const EventFinder::Crossing& c) { return !is_switch(c.watched); });
  check_accumulation(state, watched_events_[restarting->watched].name);
}

/// Events that come ever faster have no end before some time: a run would take for ever to reach it.
void IslandRun::check_accumulation(State& state, const std::string& name) {
  if (restarts_.size() < kManyEvents) return;
  const double now = restarts_.back(), span = now - restarts_.front();
  const bool faster = now - restarts_[kManyEvents - 2] < 0.9 * (restarts_[1] - restarts_[0]);
  const bool at_once = span <= 100 * std::numeric_limits<double>::epsilon() * std::abs(now);
  if (!at_once && !(faster && span < kShortly * (now - first_restart_))) return;
  restarts_.clear();
  last_ = state;
  evaluated_ = false;
  fail(state,
       "events accumulate: '" + name + "' happened " + std::to_string(kManyEvents) + " times in the last " +
           step_text(span),
       "let its change put the body to rest below some small speed, or stop there: with a restitution below 1 a ball "
       "bounces infinitely often in a finite time (Zeno)");
}

}  // namespace lithe
