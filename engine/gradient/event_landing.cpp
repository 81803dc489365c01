#include "engine/gradient/event_landing.h"

#include <algorithm>
#include <cmath>

#include "engine/assembly/evaluator.h"
#include "engine/gradient/differences.h"
#include "engine/run/kinks.h"

namespace lithe {

EventLanding::EventLanding(const ParametricScene& scene, const Drawing& drawing, bool at_kinks, Integrator& integrator,
                           Evaluator& equations, const State& state)
    : layout_(drawing.system().layout()),
      integrator_(integrator),
      equations_(equations),
      finder_(drawing.system()),
      now_(drawing.system()) {
  const auto add = [&](const std::string& name, EventFunction function, double level, Event::Direction direction) {
    functions_.push_back(function);
    levels_.push_back(level);
    finder_.add(name, std::move(function), level, direction);
  };
  for (const ParametricEvent& event : scene.events) {
    const Drawing::Place place = drawing.find(event.column);
    add(event.name, watch(drawing.sensor(place.sensor), place.column), event.level, event.direction);
  }
  events_ = static_cast<int>(functions_.size());
  if (at_kinks)
    for (const Kink& kink : find_kinks(drawing.system()))
      add(kink.name, kink.function, kink.level, Event::Direction::both);
  if (!empty()) finder_.start(integrator, state);
}

void EventLanding::remember(State state) {
  mark_ = Archive();
  integrator_.history(mark_, equations_, state);
  mark_.rewind();
}

bool EventLanding::cut(const State& before, State& state, double& stop) {
  constexpr int kMostTries = 12;
  constexpr double kSameTime = 4e-16;
  met_ = false;
  if (number_ >= 0 && state.time == stop) {
    const double off = by_newton(state);
    met_ = std::abs(off) <= kSameTime * std::abs(stop) || std::abs(off) >= last_off_ || ++tries_ > kMostTries;
    if (met_) return false;
    last_off_ = std::abs(off);
    return again(before, state, stop, stop + off);
  }
  const auto& crossings = finder_.find(integrator_, before, state);
  if (crossings.empty() || crossings.front().watched == number_) {  // a step on the way there
    finder_.accept();
    return false;
  }
  number_ = crossings.front().watched;
  tries_ = 0;
  last_off_ = std::numeric_limits<double>::infinity();
  return again(before, state, stop, crossings.front().time);
}

void EventLanding::go_on(const State& state) {
  finder_.start(integrator_, state);
  finder_.dealt_with(number_);
  number_ = -1;
  met_ = false;
}

bool EventLanding::again(const State& before, State& state, double& stop, double time) {
  stop = std::max(time, std::nextafter(before.time, std::numeric_limits<double>::infinity()));
  state = before;
  integrator_.start(equations_, state);
  state = before;
  equations_.recall(state.quarter_turns);
  integrator_.history(mark_, equations_, state);
  mark_.rewind();
  return true;
}

/// How much later the function passes its level, by its rate along the motion.
double EventLanding::by_newton(const State& state) {
  const double h = kDirectionStep / (1 + std::max(largest_entry(state.v), largest_entry(state.v_dot)));
  double rate = 0;
  State near = state;
  for (const Offset& offset : kOffsets) {
    const double t = offset.steps * h;
    near.time = state.time + t;
    near.v = state.v + t * state.v_dot;
    layout_.retract(state.q, t * state.v, near.q);
    rate += offset.weight / h * value(near);
  }
  return -value(state) / rate;
}

double EventLanding::value(const State& state) {
  now_.evaluate(state, Accelerations::solved);
  return functions_[static_cast<std::size_t>(number_)](now_) - levels_[static_cast<std::size_t>(number_)];
}

}  // namespace lithe
