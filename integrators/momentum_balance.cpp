#include "integrators/momentum_balance.h"

#include <algorithm>

#include "engine/archive/archive.h"
#include "engine/base/checks.h"

namespace lithe {
namespace {

constexpr int kMaxSplits = 12;                  // a step that will not converge is halved that often
constexpr double kSlow = 0.3;                   // rate of corrections that asks for a new factor
constexpr double kRoundOff = 1e-13;             // corrections below that do not shrink are taken as round-off;
constexpr double kRoundOffAfterFactor = 1e-10;  // below this, where a new factor has not helped,
constexpr int kHovering = 16;                   // or after so many, which may go up and down without end

/// Equal steps up to t_stop, no longer than the given one.
double natural_step(double step, double left) {
  const double count = std::ceil(left / step - 1e-9);
  return count <= 1 ? left : (std::abs(count * step - left) > 1e-9 * left ? left / count : step);
}

}  // namespace

MomentumBalance::MomentumBalance(double step, double newton_tolerance, const std::string& type)
    : newton_tolerance_(newton_tolerance), step_(step) {
  require::at(type, [&] {
    require::positive(step, "step");
    require::positive(newton_tolerance, "newton_tolerance");
  });
}

void MomentumBalance::prepare(EquationsOfMotion& equations, State& state) {
  const Layout& layout = equations.layout();
  const int nv = layout.v_count(), rows = layout.row_count();
  if (!resumes()) statistics_ = {};
  for (VectorX* x : {&v_, &v_dot_, &rv_, &zero_v_, &x_, &product_, &offset_}) x->setZero(nv);
  for (VectorX* x : {&lambda_, &rl_, &zero_rows_}) x->setZero(rows);
  q_ = state.q;
  deforms_ = std::any_of(layout.bodies().begin(), layout.bodies().end(),
                         [](const auto& b) { return b.linear > 0 || b.part > 0; });  // frames may couple as they turn
  equations_ = &equations;
  projector_.emplace(equations);
  if (state.v_dot.size() != nv) state.v_dot.setZero(nv);
  if (state.lambda.size() != rows) state.lambda.setZero(rows);
  projector_->accelerations(state.time, state.q, state.v, state.v_dot, state.lambda);
}

void MomentumBalance::evaluate(EquationsOfMotion& equations, double time, ConstVectorRef q, ConstVectorRef v) {
  equations.evaluate(time, q, v, Level::velocity);
  ++statistics_.evaluations;
}

void MomentumBalance::factorize(EquationsOfMotion& equations, const TangentWeights& weights, const State& start,
                                ConstVectorRef lambda) {
  if (equations.reacts())
    equations.residual(zero_v_, lambda, offset_);  // friction's tangent belongs to these reactions
  equations.factorize(weights, start.v_dot, lambda, nullptr);
  ++statistics_.factorizations;
}

/// The residual is linear in v̇.
void MomentumBalance::multiply_mass(EquationsOfMotion& equations, ConstVectorRef x, VectorRef out) {
  equations.residual(zero_v_, zero_rows_, offset_);
  equations.residual(x, zero_rows_, out);
  out -= offset_;
}

/// The equations of motion in quasi-velocities (Euler, Poincaré) are dP/dt + (0, ω × P_ω, 0) = ∂L/∂q, P = M D, so
///   ∂L/∂q = f + (dM/dt) D + (0, ω × P_ω, 0).
/// A turn changes M as it changes the axes of translation: (dM/dt) D = (ω × P_p, 0, 0) - M (ω × ṗ, 0, 0), world axes.
void MomentumBalance::slope(EquationsOfMotion& equations, ConstVectorRef q, ConstVectorRef D, ConstVectorRef lambda,
                            VectorRef momentum, VectorRef out) {
  x_.setZero();
  for (const auto& b : equations.layout().bodies())
    if (b.frame) x_.segment<3>(b.v) = (orientation(q, b) * D.segment<3>(b.v + 3)).cross(D.segment<3>(b.v));
  equations.residual(x_, lambda, out);
  x_ += D;
  equations.residual(x_, lambda, momentum);
  momentum -= out;
  out = -out;
  for (const auto& b : equations.layout().bodies()) {
    if (!b.frame) continue;
    const Vector3 omega = D.segment<3>(b.v + 3);
    out.segment<3>(b.v) += (orientation(q, b) * omega).cross(momentum.segment<3>(b.v));
    out.segment<3>(b.v + 3) += omega.cross(momentum.segment<3>(b.v + 3));
  }
}

void MomentumBalance::add_deformed_momentum(EquationsOfMotion& equations, ConstVectorRef q, ConstVectorRef q_axes,
                                            ConstVectorRef D, double weight, VectorRef out) {
  const auto& bodies = equations.layout().bodies();
  x_ = D;
  for (const auto& b : bodies)
    if (b.frame) x_.segment<3>(b.v) = orientation(q, b) * (orientation(q_axes, b).transpose() * D.segment<3>(b.v));
  multiply_mass(equations, x_, product_);
  for (const auto& b : bodies)
    if (b.frame)
      product_.segment<3>(b.v) =
          orientation(q_axes, b) * (orientation(q, b).transpose() * product_.segment<3>(b.v)).eval();
  out += weight * product_;
}

bool MomentumBalance::finish(EquationsOfMotion& equations, double time, Projector::Factor factor) {
  if (equations_ != &equations) {
    equations_ = &equations;
    projector_.emplace(equations);
  }
  projector_->accelerations(time, q_, v_, v_dot_, lambda_, factor);
  ++statistics_.evaluations;
  if (factor != Projector::Factor::last) ++statistics_.factorizations;
  return v_dot_.allFinite() && q_.allFinite();
}

void MomentumBalance::Corrections::add(double size) {
  const double rate = count > 0 && last > 0 ? size / last : 1;
  // What is left after this correction, by the rate at which corrections shrink; or round-off ends progress.
  const double left = rate < 1 ? size * std::min(1.0, rate / (1 - rate)) : size;
  const bool stalled = count > 0 && rate > kSlow && (wants_factor || size <= kRoundOff);
  done = left <= tolerance || ((stalled || count >= kHovering) && size <= kRoundOffAfterFactor);
  diverges = !std::isfinite(size) || (stalled && !done && rate > 2 && count > 1);
  wants_factor = count > 0 && rate > kSlow;
  last = size;
  ++count;
}

bool MomentumBalance::keep(Archive& archive, EquationsOfMotion& /*equations*/, const State& /*state*/) {
  archive.same("step", step_);
  archive.same("newton_tolerance", newton_tolerance_);
  archive("statistics", statistics_);
  return true;
}

StepResult MomentumBalance::advance(EquationsOfMotion& equations, State& state, double t_stop) {
  if (!(t_stop > state.time)) return {};
  double h = natural_step(step_, t_stop - state.time);
  for (int tries = 0;; ++tries) {
    const bool last = state.time + h >= t_stop - 1e-9 * h;
    const double time = last ? t_stop : state.time + h;
    const Attempt outcome = attempt(equations, state, h, time);
    if (outcome == Attempt::taken) {
      state.time = time;
      state.q = q_;
      state.v = v_;
      state.v_dot = v_dot_;
      state.lambda = lambda_;
      ++statistics_.steps;
      return {};
    }
    ++statistics_.rejected;
    ++statistics_.newton_failures;
    if (tries >= kMaxSplits) {
      Eigen::Index worst = 0;
      rv_.cwiseAbs().maxCoeff(&worst);
      return {StepResult::Outcome::failed,
              (outcome == Attempt::no_number ? "velocities or reactions are not finite at steps of "
                                             : "Newton does not converge at steps of ") +
                  step_text(h) + "; largest correction in " +
                  equations.layout().velocity_name(static_cast<int>(worst))};
    }
    h *= 0.5;
  }
}

}  // namespace lithe
