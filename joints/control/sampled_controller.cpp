#include "joints/control/sampled_controller.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "engine/archive/archive.h"
#include "engine/base/dense.h"
#include "engine/base/number_text.h"
#include "engine/run/simulation.h"

namespace lithe {

SampledLaw discrete_state_space(const MatrixX& A, const MatrixX& B, const MatrixX& C, const MatrixX& D,
                                const VectorX& start) {
  const Eigen::Index n = A.rows();
  const auto shape = [](const MatrixX& m) { return std::to_string(m.rows()) + " x " + std::to_string(m.cols()); };
  if (A.cols() != n || B.rows() != n || C.cols() != n || D.rows() != C.rows() || D.cols() != B.cols() ||
      (start.size() != 0 && start.size() != n))
    throw SceneError("A " + shape(A) + ", B " + shape(B) + ", C " + shape(C) + ", D " + shape(D) + " and start " +
                         shape(start) + " do not fit",
                     "discrete_state_space", "give A n x n, B n x inputs, C outputs x n, D outputs x inputs");
  if (!A.allFinite() || !B.allFinite() || !C.allFinite() || !D.allFinite() || !start.allFinite())
    throw SceneError("a coefficient is not finite", "discrete_state_space", "give numbers");
  if (n > 0) {
    const Eigen::EigenSolver<MatrixX> eigen(A, false);
    const double radius = eigen.eigenvalues().cwiseAbs().maxCoeff();
    if (radius > 1 + 1e-9)
      throw SceneError(
          "the controller is unstable by itself: an eigenvalue of its A has magnitude " + number_text(radius),
          "discrete_state_space",
          "give eigenvalues within the unit circle; coefficients are by rising delay, and of samples, not "
          "of a continuous controller");
  }
  return {start.size() == 0 ? VectorX(VectorX::Zero(n)) : start, static_cast<int>(B.cols()), static_cast<int>(C.rows()),
          [=](double, const VectorX& u, VectorX& x, VectorX& y) {
            y = C * x + D * u;
            x = (A * x + B * u).eval();
          }};
}

SampledLaw difference_equation(std::vector<double> b, std::vector<double> a) {
  if (a.empty() || b.empty() || a[0] == 0)
    throw SceneError("a difference equation has no b, or no a_0", "difference_equation",
                     "give both by rising delay, a_0 not zero: {b0, b1}, {1, a1}");
  // Observable form: x_i holds what later outputs owe to the past.
  const auto n = std::max(a.size(), b.size()) - 1;
  a.resize(n + 1, 0), b.resize(n + 1, 0);
  const auto count = static_cast<Eigen::Index>(n);
  MatrixX A = MatrixX::Zero(count, count), B(count, 1), C = MatrixX::Zero(1, count), D(1, 1);
  D(0, 0) = b[0] / a[0];
  for (Eigen::Index i = 0; i < count; ++i) {
    const auto next = static_cast<std::size_t>(i) + 1;
    A(i, 0) = -a[next] / a[0];
    if (i + 1 < count) A(i, i + 1) = 1;
    B(i, 0) = (b[next] - a[next] * D(0, 0)) / a[0];
  }
  if (count > 0) C(0, 0) = 1;
  return discrete_state_space(A, B, C, D);
}

SampledController::SampledController(Parameters parameters) : parameters_(std::move(parameters)) {
  const auto& p = parameters_;
  const auto refuse = [&](const std::string& problem, const std::string& fix) {
    throw SceneError("sampled controller '" + p.name + "': " + problem, "", fix);
  };
  if (!(p.interval > 0) || !std::isfinite(p.interval))
    refuse("its interval is " + number_text(p.interval) + " s", "give .interval, the time between samples, above 0");
  if (!(p.delay >= 0) || !std::isfinite(p.delay))
    refuse("its delay is " + number_text(p.delay) + " s", "give .delay, 0 or more");
  if (!p.law.step) refuse("it has no law", "give .law: discrete_state_space(...), difference_equation(...)");
  if (p.law.inputs != static_cast<int>(p.inputs.size()) || p.law.outputs != static_cast<int>(p.outputs.size()))
    refuse("its law has " + std::to_string(p.law.inputs) + " inputs and " + std::to_string(p.law.outputs) +
               " outputs, and it is given " + std::to_string(p.inputs.size()) + " and " +
               std::to_string(p.outputs.size()),
           "give one sensor for each input, one Input for each output");
  for (const Reading& reading : p.inputs)
    if (reading.column < 0 || reading.column >= static_cast<int>(reading.sensor.columns().size()))
      refuse("sensor '" + reading.sensor.name() + "' has no column " + std::to_string(reading.column),
             "count columns from 0");
  std::set<const Input*> driven;
  for (const Input* output : p.outputs) {
    if (!output) refuse("an output goes to no Input", "give the address of one");
    if (output->between() != Input::Between::held)
      refuse("input '" + output->name() + "' does not hold its samples",
             "draw it with .between = Input::Between::held");
    if (!driven.insert(output).second) refuse("two outputs go to input '" + output->name() + "'", "keep one");
  }
  u_.setZero(p.law.inputs), y_.setZero(p.law.outputs);
}

void SampledController::join(Simulation& simulation) { simulation.observe(*this, every(parameters_.interval)); }

void SampledController::observe(Snapshot& snapshot) {
  const auto& p = parameters_;
  const double time = snapshot.time();
  const auto check = [&](double value, const std::string& what) {
    if (!std::isfinite(value))
      throw SimulationError(what + " is " + number_text(value) + ".",
                            "sampled controller '" + p.name + "', " + time_text(time),
                            "look at its sensors and at its law.");
  };
  if (begun_ && time == time_) return;  // the state from which a run goes on
  if (!begun_ || time < time_) {
    begun_ = true;
    x_ = p.law.start;
    origin_ = time;
    for (Input* output : p.outputs) output->reset(time, output->parameters().value);
  }
  time_ = time;
  // A whole number of intervals later is a sample, to the last digit: as every() counts them.
  const double periods = std::round(p.delay / p.interval);
  const bool whole = std::abs(p.delay - periods * p.interval) < 1e-9 * p.interval;
  const double arrival =
      whole ? origin_ + (std::round((time - origin_) / p.interval) + periods) * p.interval : time + p.delay;
  for (std::size_t i = 0; i < p.inputs.size(); ++i) {
    double& u = u_[static_cast<Eigen::Index>(i)] = p.inputs[i].sensor.value(snapshot, p.inputs[i].column);
    check(u, "sensor '" + p.inputs[i].sensor.name() + "'");
  }
  p.law.step(time, u_, x_, y_);
  if (y_.size() != p.law.outputs)
    throw SimulationError(
        "its law gives " + std::to_string(y_.size()) + " outputs instead of " + std::to_string(p.law.outputs) + ".",
        "sampled controller '" + p.name + "'", "keep the size of y.");
  for (std::size_t i = 0; i < p.outputs.size(); ++i) {
    const double y = y_[static_cast<Eigen::Index>(i)];
    check(y, "the output to '" + p.outputs[i]->name() + "'");
    p.outputs[i]->set(std::max(time, arrival), y);
  }
}

void SampledController::history(Archive& archive) {
  archive.group("sampled controller", [&] {
    archive("begun", begun_);
    archive("origin", origin_);
    archive("time", time_);
    if (archive.loads()) x_ = parameters_.law.start;
    if (x_.size() > 0 && (begun_ || !archive.loads())) archive("x", x_);
  });
}

}  // namespace lithe
