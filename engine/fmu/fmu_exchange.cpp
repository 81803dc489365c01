// The part of FmuInstance that is for model exchange.
#include <algorithm>
#include <cmath>

#include "engine/base/error.h"
#include "engine/base/number_text.h"
#include "engine/fmu/fmu_instance.h"

namespace lithe {
namespace {

constexpr double kMove = 1e-3;  // of a known's size, for differences

}  // namespace

void FmuInstance::set_time(double time) {
  if (!std::isfinite(time)) throw SceneError("the time is not finite", model_.scene.name, "give a time in seconds");
  state_.time = time;
  evaluated_ = false;
}

void FmuInstance::set_states(std::span<const double> x) {
  const VectorX given = Eigen::Map<const VectorX>(x.data(), std::ssize(x));
  equations_->read(given, state_);
  x_ = given;
  evaluated_ = false;
}

const VectorX& FmuInstance::derivatives() {
  Snapshot& now = look();
  if (rates_.size() == 0) rates_ = equations_->derivatives(now, x_);
  return rates_;
}

void FmuInstance::indicators(std::span<double> values) {
  Snapshot& now = look();
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = equations_->indicator(static_cast<int>(i), now, sides_);
}

bool FmuInstance::complete_step() {
  Snapshot& now = look();
  const bool off = equations_->drift(now, x_) > equations_->allowed_drift(tolerance_);
  if (equations_->track(now, state_)) evaluated_ = false;
  return off;
}

bool FmuInstance::update() {
  const bool off = equations_->drift(look(), x_) > equations_->allowed_drift(tolerance_);
  if (off) {
    evaluated_ = false;
    State moved = state_;
    equations_->project(*snapshot_, moved);
    state_ = moved;
    x_ = equations_->states_of(state_);
  }
  sides_ = equations_->sides(look());
  return off;
}

void FmuInstance::directional_derivative(std::span<const unsigned> unknowns, std::span<const unsigned> knowns,
                                         std::span<const double> seed, std::span<double> sensitivity) {
  using Role = FmuVariable::Role;
  // 1. How far to go along the seed.
  double largest = 0;
  for (std::size_t i = 0; i < knowns.size(); ++i) {
    const FmuVariable& known = variable(knowns[i]);
    if (known.role != Role::state && known.role != Role::input && known.role != Role::parameter)
      throw SceneError("there are no derivatives by '" + known.name + "'", model_.scene.name,
                       "ask for those by states, inputs and parameters");
    const double range = known.upper - known.lower;
    const double size = known.role == Role::state ? known.nominal
                        : std::isfinite(range)    ? range
                                                  : std::max(1.0, std::abs(get(knowns[i])));
    if (!std::isfinite(seed[i]))
      throw SceneError("the seed of '" + known.name + "' is not finite", model_.scene.name, "give numbers");
    largest = std::max(largest, std::abs(seed[i]) / size);
  }
  for (const unsigned unknown : unknowns)
    if (variable(unknown).role < Role::output)
      throw SceneError("there are no derivatives of '" + variable(unknown).name + "'", model_.scene.name,
                       "ask for those of outputs, state derivatives and event indicators");
  std::fill(sensitivity.begin(), sensitivity.end(), 0);
  if (!(largest > 0)) return;
  const double h = kMove / largest;

  // 2. There and back; what was set is set again, whatever happens.
  struct Restored {
    FmuInstance& instance;
    const VectorX x = instance.x_;
    const State state = instance.state_;
    ~Restored() {
      instance.x_ = x, instance.state_ = state, instance.evaluated_ = false;
      for (const Input* input : instance.graph_.inputs()) input->release();
    }
  } const base{*this};
  for (const auto& [steps, weight] : {std::pair(1.0, 8.0), {-1.0, -8.0}, {2.0, -1.0}, {-2.0, 1.0}}) {
    VectorX x = base.x;
    for (std::size_t i = 0; i < knowns.size(); ++i) {
      const FmuVariable& known = variables_[knowns[i]];
      const double move = steps * h * seed[i];
      if (known.role == Role::state)
        x[known.place] += move;
      else
        graph_.inputs()[static_cast<std::size_t>(known.place)]->force({get(knowns[i]) + move, 0, 0});
    }
    set_states({x.data(), static_cast<std::size_t>(x.size())});
    for (std::size_t i = 0; i < unknowns.size(); ++i) sensitivity[i] += weight / (12 * h) * get(unknowns[i]);
  }
}

void FmuInstance::adjoint_derivative(std::span<const unsigned> unknowns, std::span<const unsigned> knowns,
                                     std::span<const double> seed, std::span<double> sensitivity) {
  const double one = 1;
  std::vector<double> column(unknowns.size());
  for (std::size_t j = 0; j < knowns.size(); ++j) {
    directional_derivative(unknowns, knowns.subspan(j, 1), {&one, 1}, column);
    sensitivity[j] = 0;
    for (std::size_t i = 0; i < unknowns.size(); ++i) sensitivity[j] += seed[i] * column[i];
  }
}

}  // namespace lithe
