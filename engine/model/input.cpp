#include "engine/model/input.h"

#include <algorithm>
#include <cmath>

#include "engine/base/error.h"
#include "engine/base/number_text.h"
#include "engine/model/adjustable.h"
#include "engine/model/input_effort.h"

namespace lithe {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Known by its type in a MotionLaw.
struct InputLaw {
  const Input* input;
  Motion operator()(double time) const { return input->at(time); }
};

}  // namespace

Input::Input(Parameters parameters) : parameters_(std::move(parameters)) {
  const auto& p = parameters_;
  if (std::isnan(p.lower) || std::isnan(p.upper) || !(p.lower <= p.upper))
    throw SceneError("its bounds " + number_text(p.lower) + " and " + number_text(p.upper) + " are not in order", "",
                     "give .lower <= .upper");
  if (!std::isfinite(p.value)) throw SceneError("its value is not finite", "", "give a number");
  if (p.value < p.lower || p.value > p.upper)
    throw SceneError("its value " + number_text(p.value) + " is outside its bounds " + number_text(p.lower) + " to " +
                         number_text(p.upper),
                     "", "give a .value between .lower and .upper");
  reset();
}

void Input::require(double time, double value, const std::string& where) const {
  const std::string unit = parameters_.unit.empty() ? "" : " " + parameters_.unit;
  if (!std::isfinite(time) || !std::isfinite(value))
    throw SceneError("input '" + name() + "' is given " + number_text(value) + unit + " at " + time_text(time) +
                         ", which is not finite",
                     where, "give numbers");
  if (value < parameters_.lower || value > parameters_.upper)
    throw SceneError("input '" + name() + "' is given " + number_text(value) + unit + ", outside its bounds " +
                         number_text(parameters_.lower) + " to " + number_text(parameters_.upper),
                     where, "give a value inside, or draw it with other bounds (" + this->where() + ")");
}

void Input::set(double time, double value, std::source_location where) {
  require(time, value, to_string(where));
  Sample& last = samples_.back();
  if (time == last.time) {
    last.value = value;
    return;
  }
  if (time < last.time)
    throw SceneError(
        "input '" + name() + "' is set at " + time_text(time) + ", before its last sample at " + time_text(last.time),
        to_string(where), "give samples in the order of time; reset() forgets those given before");
  samples_.push_back({time, value});
}

void Input::reset(double time, double value, std::source_location where) {
  require(time, value, to_string(where));
  samples_.assign(1, {time, value});
}

Motion Input::among_samples(double time) const {
  if (forced_) return forced_as_;
  const auto after = [](double t, const Sample& s) { return t < s.time; };
  auto next = std::upper_bound(samples_.begin(), samples_.end(), time, after);
  // What ends at a kink sees what is before it.
  while (next != samples_.begin() && (next - 1)->time >= end_) --next;
  if (next == samples_.begin()) return {samples_.front().value, 0, 0};
  const Sample& from = *(next - 1);
  if (next == samples_.end() || between() == Between::held) return {from.value, 0, 0};
  if (between() == Between::smooth) return smooth_step_at(from.value, next->value, from.time, next->time, time);
  const double rate = (next->value - from.value) / (next->time - from.time);
  return {from.value + rate * (time - from.time), rate, 0};
}

double Input::next_kink(double time) const {
  if (between() == Between::smooth) return kInfinity;
  const auto after = [](double t, const Sample& s) { return t < s.time; };
  const auto next = std::upper_bound(samples_.begin(), samples_.end(), time, after);
  return next == samples_.end() ? kInfinity : next->time;
}

Input::operator MotionLaw() const { return InputLaw{this}; }
Input::operator std::function<double(double, double, double)>() const { return InputEffort{this}; }

const Input* Input::of(const MotionLaw& law) {
  const auto* found = law.target<InputLaw>();
  return found ? found->input : nullptr;
}

void require::without_jumps(const MotionLaw& law, const std::string& parameter) {
  const Input* input = Input::of(law);
  if (input && input->between() == Input::Between::held)
    throw SceneError(parameter + " is the input '" + input->name() + "', which jumps from sample to sample", "",
                     "draw that input with .between = Input::Between::smooth, or linear: bodies cannot jump");
}

}  // namespace lithe
