#include "engine/run/event_finder.h"

#include <algorithm>
#include <boost/math/tools/minima.hpp>
#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>
#include <limits>

#include "engine/archive/archive.h"
#include "engine/base/error.h"
#include "engine/base/number_text.h"
#include "engine/observe/observer.h"

namespace lithe {
namespace {

constexpr double kSoon = 1e-4;     // of a step: where a trend is read
constexpr double kNear = 0.3;      // of the smallest sample: an extremum of the parabola below is looked for
constexpr double kAtLevel = 1e-2;  // of the change over half a step: how far round-off and projection leave a level
constexpr int kMaxBrentIterations = 60;

/// Round-off of the step's own time, in parts of the step.
double resolution(const State& from, const State& to) {
  const double h = to.time - from.time;
  return std::max(4 * std::numeric_limits<double>::epsilon() * std::abs(to.time) / h, 1e-14);
}

}  // namespace

EventFinder::EventFinder(const System& system) : snapshot_(system) {}

void EventFinder::add(std::string name, EventFunction function, double level, Event::Direction direction) {
  watched_.push_back({std::move(name), std::move(function), level, direction});
}

double EventFinder::value(Watched& w) {
  double value = 0;
  try {
    value = w.function(snapshot_) - w.level;
  } catch (...) {
    rethrow_as_error("the function of the event '" + w.name + "'", time_text(snapshot_.time()),
                     "see what it reads there; the state reached before is kept");
  }
  if (!std::isfinite(value))
    throw SimulationError("the event '" + w.name + "' watches a value that is not finite", time_text(snapshot_.time()),
                          "give a function that is a number at every state");
  return value;
}

void EventFinder::evaluate(const Integrator& integrator, const State& state) {
  snapshot_.evaluate(state, integrator.follows_equations() ? Accelerations::solved : Accelerations::as_left);
}

void EventFinder::start(const Integrator& integrator, const State& state) {
  evaluate(integrator, state);
  for (Watched& w : watched_) {
    w.start = value(w);
    w.by_trend = w.start == 0;
  }
}

double EventFinder::time_left(int watched, double h) const {
  const Watched& w = watched_[watched];
  const double nearer = std::abs(w.middle) - std::abs(w.end);
  return w.middle * w.end > 0 && nearer > 0 ? 0.5 * h * std::abs(w.end) / nearer : 0;
}

void EventFinder::accept() {
  for (Watched& w : watched_) {
    w.start = w.end;
    w.by_trend = w.end == 0;
  }
}

void EventFinder::history(Archive& archive) {
  std::vector<std::string> names;
  std::vector<double> values;
  std::vector<int> trends;
  for (const Watched& w : watched_) names.push_back(w.name), values.push_back(w.start), trends.push_back(w.by_trend);
  const std::vector<std::string> now = names;
  archive("watched", names);
  archive("values", values);
  archive("by_trend", trends);
  if (names != now || values.size() != now.size() || trends.size() != now.size())
    throw SceneError("the checkpoint was written with other events, switches or located contacts", archive.source(),
                     "give the same ones, in the same order, before resume()");
  for (std::size_t i = 0; i < watched_.size(); ++i)
    watched_[i].start = values[i], watched_[i].by_trend = trends[i] != 0;
}

void EventFinder::resume(const Integrator& integrator, const State& state) {
  evaluate(integrator, state);
  for (Watched& w : watched_) {
    const double now = value(w);
    if (w.start * now > 0 && std::isfinite(w.start)) continue;
    w.start = now;
    w.by_trend = true;
  }
}

/// Whether the sign at the start is that of the trend. Not where a change of the state has moved the function away from
/// its level: towards the level its trend has the other sign.
bool EventFinder::by_trend(const Watched& w) const {
  const bool away = w.start * w.soon > 0 && std::abs(w.start) > kAtLevel * std::abs(w.middle - w.start);
  return w.by_trend && !away;
}

void EventFinder::look(const Step& step, double s) {
  const double time = step.from.time + s * (step.to.time - step.from.time);
  step.integrator.interpolate(snapshot_.system().layout(), step.from, step.to, time, state_);
  evaluate(step.integrator, state_);
}

double EventFinder::value_at(const Step& step, Watched& w, double s) {
  look(step, s);
  return value(w);
}

const std::vector<EventFinder::Crossing>& EventFinder::find(const Integrator& integrator, const State& from,
                                                            const State& to) {
  const Step step{integrator, from, to};
  crossings_.clear();
  // 1. Samples, all functions at once.
  evaluate(integrator, to);
  for (Watched& w : watched_) w.end = value(w);
  look(step, 0.5);
  for (Watched& w : watched_) w.middle = value(w);
  if (std::any_of(watched_.begin(), watched_.end(), [](const Watched& w) { return w.by_trend; })) {
    look(step, kSoon);
    for (Watched& w : watched_) w.soon = value(w);
  }
  // 2. Each between its samples.
  for (std::size_t i = 0; i < watched_.size(); ++i) find(step, static_cast<int>(i));
  std::stable_sort(crossings_.begin(), crossings_.end(),
                   [](const Crossing& a, const Crossing& b) { return a.time < b.time; });
  return crossings_;
}

void EventFinder::find(const Step& step, int watched) {
  Watched& w = watched_[watched];
  double s_start = 0, start = w.start;
  const bool trend = by_trend(w);
  if (trend) {
    // Its rate, by the parabola through the start, a moment later and the middle: a short flight after an impact may
    // end within the step. Its sign matters alone.
    const double bend =
        ((w.middle - w.start) / 0.5 - (w.soon - w.start) / kSoon) / (0.5 - kSoon);  // half the second derivative
    start = (w.soon - w.start) / kSoon - bend * kSoon;
    const double peak = -start / (2 * bend);
    s_start = start * w.middle < 0 && peak > 0 && peak < 0.5 ? peak : kSoon;
    if (w.start == 0 && w.soon == 0) {  // it stays at its level for a while: to leave it then is no passage
      if (w.middle == 0) return;
      start = w.middle;
      s_start = kSoon;
    }
  }
  const double sign = start > 0 ? 1 : -1;
  if (sign * w.middle > 0 && sign * w.end > 0) {
    // The parabola's least value, signs turned so that the samples are above zero.
    const double a = sign * (trend ? w.soon : w.start), m = sign * w.middle, b = sign * w.end;
    const double curvature = 2 * (a - 2 * m + b), slope = -3 * a + 4 * m - b;
    const double at = -slope / (2 * curvature);
    if (curvature > 0 && at > s_start && at < 1 && a + slope * at / 2 < kNear * std::min({a, m, b})) {
      const double s = extremum(step, w, sign);
      const double least = value_at(step, w, s);
      if (sign * least < 0 && s > s_start) {
        find_between(step, watched, s_start, start, s, least);
        find_between(step, watched, s, least, 1, w.end);
      }
    }
    return;
  }
  find_between(step, watched, s_start, start, 0.5, w.middle);
  // A function at its level has passed it.
  find_between(step, watched, 0.5, w.middle == 0 ? -start : w.middle, 1, w.end);
}

/// Where in the step sign · function is least.
double EventFinder::extremum(const Step& step, Watched& w, double sign) {
  std::uintmax_t iterations = kMaxBrentIterations;
  const auto function = [&](double s) { return sign * value_at(step, w, s); };
  return boost::math::tools::brent_find_minima(function, 0.0, 1.0, 26, iterations).first;
}

/// Adds the passage between two parts of the step with values a and b, if their signs differ as the event wants.
void EventFinder::find_between(const Step& step, int watched, double s_a, double a, double s_b, double b) {
  Watched& w = watched_[watched];
  if (!(a * b < 0 || (b == 0 && a != 0))) return;
  if (w.direction == Event::Direction::rising ? a > 0 : w.direction == Event::Direction::falling && a < 0) return;
  double s = s_b;
  if (b != 0 && s_b > s_a) {
    const double allowed = resolution(step.from, step.to);
    const double at_a = value_at(step, w, s_a), at_b = value_at(step, w, s_b);
    if (at_a * at_b < 0) {
      std::uintmax_t iterations = kMaxBrentIterations;
      s = boost::math::tools::toms748_solve([&](double at) { return value_at(step, w, at); }, s_a, s_b, at_a, at_b,
                                            [&](double l, double r) { return r - l <= allowed; }, iterations)
              .second;
    } else if (at_a * a <= 0) {
      s = s_a;  // the sample was round-off beside the dense output
    }
  }
  crossings_.push_back({watched, s == 1 ? step.to.time : step.from.time + s * (step.to.time - step.from.time), a < 0});
}

}  // namespace lithe
