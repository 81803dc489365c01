#include "integrators/linearly_implicit.h"

#include <algorithm>

#include "engine/archive/archive.h"
#include "engine/base/checks.h"
#include "engine/base/error.h"
#include "engine/motion/projection.h"

namespace lithe {

LinearlyImplicit::LinearlyImplicit(Parameters parameters) : parameters_(parameters) {
  require::at("LinearlyImplicit", [&] { require::positive(parameters.step, "step"); });
  if (parameters.order != 1 && parameters.order != 2)
    throw SceneError("order is " + std::to_string(parameters.order), "LinearlyImplicit", "give 1 or 2");
}

std::string LinearlyImplicit::name() const {
  return parameters_.order == 1 ? "linearly implicit Euler" : "linearly implicit Euler, extrapolated";
}

void LinearlyImplicit::prepare(EquationsOfMotion& equations, State& state) {
  const int nv = equations.layout().v_count(), rows = equations.layout().row_count();
  if (!resumes()) statistics_ = {};
  for (VectorX* x : {&d_, &turned_, &rv_}) x->setZero(nv);
  for (VectorX* x : {&rl_, &rl2_}) x->setZero(rows);
  if (state.v_dot.size() != nv) state.v_dot.setZero(nv);
  if (state.lambda.size() != rows) state.lambda.setZero(rows);
  Projector(equations).accelerations(state.time, state.q, state.v, state.v_dot, state.lambda);
  start_ = {state.q, state.v, state.v_dot, state.lambda};
  half_ = end_ = whole_ = start_;
}

/// One step of order 1, from a point to another that ends at `time`.
void LinearlyImplicit::euler(EquationsOfMotion& equations, double time, double h, const Point& from, Point& to) {
  const Layout& layout = equations.layout();
  // 1. The equations at the end that an unchanged velocity would lead to; their derivatives there.
  d_ = h * from.v;
  layout.retract(from.q, d_, to.q);
  equations.evaluate(time, to.q, from.v, Level::velocity);
  ++statistics_.evaluations;
  rv_.setZero();
  equations.residual(rv_, from.lambda, turned_);
  if (broken_ < 0 && !turned_.allFinite())
    broken_ = static_cast<int>(
        std::find_if(turned_.data(), turned_.data() + turned_.size(), [](double x) { return !std::isfinite(x); }) -
        turned_.data());
  equations.factorize({h * h, h, 1}, from.v_dot, from.lambda, &d_);
  ++statistics_.factorizations;
  // 2. M v̇ + h D v̇ + h² K v̇ + Gᵀ λ' = f, with the velocities that the constraints allow.
  rv_ = -turned_;
  equations.constraint(Level::velocity, rl2_);
  equations.constraint(Level::position, rl_);
  rl_ = h * rl2_ - rl_;  // what is left of g after step 2
  rl2_ /= -h;
  equations.solve(rv_, rl2_);
  to.lambda = from.lambda + rl2_;
  layout.chart_rates(d_, rv_, to.v_dot);
  to.v = from.v + h * to.v_dot;
  // 3. Positions onto g = 0, along the same factor.
  for (int row : equations.velocity_rows()) rl_[row] = 0;
  turned_.setZero();
  equations.solve(turned_, rl_);
  turned_ += h * h * rv_;
  layout.retract(to.q, turned_, to.q);
}

/// A point onto g = 0 and G v + ∂g/∂t = 0, along the last factor.
void LinearlyImplicit::project(EquationsOfMotion& equations, double time, Point& at) {
  if (rl_.size() == 0) return;
  equations.evaluate(time, at.q, at.v, Level::velocity);
  ++statistics_.evaluations;
  equations.constraint(Level::velocity, rl2_);
  equations.constraint(Level::position, rl_);
  rl2_ = -rl2_;
  rl_ = -rl_;
  rv_.setZero();
  equations.solve(rv_, rl2_);
  at.v += rv_;
  rv_.setZero();
  equations.solve(rv_, rl_);
  equations.layout().retract(at.q, rv_, at.q);
}

bool LinearlyImplicit::keep(Archive& archive, EquationsOfMotion& /*equations*/, const State& /*state*/) {
  archive.same("step", parameters_.step);
  archive.same("order", parameters_.order);
  archive("statistics", statistics_);
  return true;
}

StepResult LinearlyImplicit::advance(EquationsOfMotion& equations, State& state, double t_stop) {
  if (!(t_stop > state.time)) return {};
  // Equal steps up to t_stop, no longer than the given one.
  const double left = t_stop - state.time, count = std::max(1.0, std::ceil(left / parameters_.step - 1e-6));
  const double h = std::abs(count * parameters_.step - left) > 1e-9 * left ? left / count : parameters_.step;
  const double time = count == 1 ? t_stop : state.time + h;

  const Layout& layout = equations.layout();
  broken_ = -1;
  start_.q = state.q;
  start_.v = state.v;
  start_.v_dot = state.v_dot;
  start_.lambda = state.lambda;
  if (parameters_.order == 1) {
    euler(equations, time, h, start_, end_);
  } else {
    euler(equations, time, h, start_, whole_);
    euler(equations, state.time + h / 2, h / 2, start_, half_);
    project(equations, state.time + h / 2, half_);  // both halves begin with ġ = 0, or λ would be of order 1
    euler(equations, time, h / 2, half_, end_);
    layout.difference(start_.q, end_.q, d_);
    layout.difference(start_.q, whole_.q, turned_);
    d_ = 2 * d_ - turned_;
    layout.retract(start_.q, d_, end_.q);
    end_.v = 2 * end_.v - whole_.v;
    end_.v_dot = 2 * end_.v_dot - whole_.v_dot;
    end_.lambda = 2 * end_.lambda - whole_.lambda;
    project(equations, time, end_);
  }
  if (!end_.q.allFinite() || !end_.v.allFinite() || !end_.v_dot.allFinite() || !end_.lambda.allFinite())
    return {StepResult::Outcome::failed, "the equations give no finite values at the step of " + step_text(h) +
                                             (broken_ < 0 ? "" : "; first in " + layout.velocity_name(broken_))};
  state.time = time;
  state.q = end_.q;
  state.v = end_.v;
  state.v_dot = end_.v_dot;
  state.lambda = end_.lambda;
  ++statistics_.steps;
  return {};
}

}  // namespace lithe
