#include "engine/integrator.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace lithe {

void Integrator::start(EquationsOfMotion& equations, State& state) {
  equations.recall(state.quadrants);
  quadrants_ = state.quadrants;
  turn_rates_.setZero(quadrants_.size());
  last_length_ = 0;
  longest_ = std::numeric_limits<double>::infinity();
  prepare(equations, state);
}

StepResult Integrator::step(EquationsOfMotion& equations, State& state, double t_stop) {
  equations.recall(state.quadrants);
  quadrants_ = state.quadrants;
  const double begin = state.time;
  StepResult result = advance(equations, state, std::min(t_stop, begin + longest_));
  if (!result.ok()) return result;
  equations.track(state.quadrants);
  if (turn_rates_.size() > 0 && turn_rates_.size() == state.quadrants.size())
    limit_turn(state.quadrants, state.time - begin);
  return result;
}

/// From the mean rates of the last two steps, how long the next may be for its fastest angle to move by 1.6 quadrants:
/// automatic steps would else outgrow half a turn where a body spins steadily, and turns be lost.
void Integrator::limit_turn(const VectorX& quadrants, double length) {
  constexpr double kFarthest = 1.6, kLargestGrowth = 10;  // of a step over the one before
  if (!(length > 0)) return;
  quadrants_ = (quadrants - quadrants_) / length;
  const double rate = quadrants_.cwiseAbs().maxCoeff();
  const double growth = 2 * (quadrants_ - turn_rates_).cwiseAbs().maxCoeff() / (length + last_length_);
  const double now = rate + growth * length / 2;
  turn_rates_.swap(quadrants_);
  last_length_ = length;
  longest_ = std::numeric_limits<double>::infinity();
  const double allowed = 2 * kFarthest / (now + std::sqrt(now * now + 2 * growth * kFarthest));
  if (allowed < kLargestGrowth * length)  // in whole steps, so that fixed ones stay as they are
    longest_ = allowed > length ? std::floor(allowed / length) * length : allowed;
}

std::string step_text(double h) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2g s", h);
  return text;
}

double error_ratio(ConstVectorRef error, ConstVectorRef magnitudes, const Tolerance& tolerance) {
  double sum = 0;
  for (Eigen::Index i = 0; i < error.size(); ++i) {
    const double ratio = error[i] / (tolerance.absolute + tolerance.relative * magnitudes[i]);
    sum += ratio * ratio;
  }
  return error.size() > 0 ? std::sqrt(sum / static_cast<double>(error.size())) : 0;
}

}  // namespace lithe
