#include "engine/motion/projection.h"

#include <limits>

namespace lithe {

Projector::Projector(EquationsOfMotion& equations)
    : equations_(equations),
      zero_v_(VectorX::Zero(equations.layout().v_count())),
      zero_rows_(VectorX::Zero(equations.layout().row_count())),
      dv_(zero_v_),
      dl_(zero_rows_),
      given_(zero_rows_) {}

Projector::Result Projector::position(double time, VectorRef q, double tolerance, int max_iterations, Factor factor) {
  Result result;
  if (dl_.size() == 0) return {true, 0, 0.0};
  double moved = 0;
  for (;; ++result.iterations) {
    equations_.evaluate(time, q, zero_v_, Level::position);
    equations_.constraint(Level::position, dl_);
    const double before = result.residual;
    result.residual = dl_.cwiseAbs().maxCoeff<Eigen::PropagateNaN>();
    // Done at the tolerance, or where round-off ends progress.
    result.converged =
        result.residual <= tolerance ||
        (result.iterations > 0 && moved < 1e-14 * (1 + q.cwiseAbs().maxCoeff()) && result.residual >= 0.5 * before);
    if (result.converged || result.iterations == max_iterations || !std::isfinite(result.residual)) return result;
    if (factor == Factor::fresh || (factor == Factor::first && result.iterations == 0))
      equations_.factorize({0, 0, 1}, zero_v_, zero_rows_, nullptr);
    dv_.setZero();
    dl_ = -dl_;
    equations_.solve(dv_, dl_);
    moved = dv_.cwiseAbs().maxCoeff();
    if (moved > 1) dv_ *= 1 / moved;  // a metre or a radian at a time
    equations_.layout().retract(q, dv_, q);
  }
}

void Projector::velocity(double time, ConstVectorRef q, VectorRef v) {
  if (dl_.size() == 0) return;
  equations_.evaluate(time, q, v, Level::velocity);
  equations_.constraint(Level::velocity, dl_);
  equations_.factorize({0, 0, 1}, zero_v_, zero_rows_, nullptr);
  dv_.setZero();
  dl_ = -dl_;
  equations_.solve(dv_, dl_);
  v += dv_;
}

void Projector::accelerations(double time, ConstVectorRef q, ConstVectorRef v, VectorRef v_dot, VectorRef lambda,
                              Factor factor) {
  equations_.evaluate(time, q, v, Level::acceleration);
  if (equations_.reacts()) {
    if (!lambda.allFinite()) lambda.setZero();
    given_ = lambda;
    const double guess = given_.size() > 0 ? given_.cwiseAbs().maxCoeff() : 0;
    // The round-off of a guess that is far off stays in v̇.
    constexpr double kFar = 1e6;
    if (iterate_reactions(v_dot, lambda) && guess <= kFar * (1 + lambda.cwiseAbs().maxCoeff())) return;
    lambda.setZero();
    if (guess > 0 && iterate_reactions(v_dot, lambda)) return;
    lambda = given_;  // or what is tried next would begin with what has diverged
    v_dot.setConstant(std::numeric_limits<double>::quiet_NaN());  // integrators meet it with a smaller step
    return;
  }
  if (factor != Factor::last) equations_.factorize({0, 0, 1}, zero_v_, zero_rows_, nullptr);
  equations_.residual(zero_v_, zero_rows_, v_dot);  // -f
  v_dot = -v_dot;
  equations_.constraint(Level::acceleration, lambda);
  equations_.solve(v_dot, lambda);
}

/// Newton on M v̇ + Gᵀλ = f(λ), G v̇ = γ. The second is linear and holds from the first correction on. False where it
/// does not converge.
bool Projector::iterate_reactions(VectorRef v_dot, VectorRef lambda) {
  constexpr int kMaxIterations = 50;
  constexpr double kConverged = 1e-12;
  v_dot.setZero();
  double last = 0;
  for (int k = 0; k < kMaxIterations; ++k) {
    equations_.residual(v_dot, lambda, dv_);
    dv_ = -dv_;
    if (k == 0)
      equations_.constraint(Level::acceleration, dl_);
    else
      dl_.setZero();
    equations_.factorize({0, 0, 1}, v_dot, lambda, nullptr);
    equations_.solve(dv_, dl_);
    v_dot += dv_;
    lambda += dl_;
    const double size = dl_.cwiseAbs().maxCoeff(), allowed = kConverged * (1 + lambda.cwiseAbs().maxCoeff());
    if (size <= allowed || (k > 2 && size <= 1e3 * allowed && size >= 0.5 * last)) {  // or round-off ends progress
      equations_.residual(v_dot, lambda, dv_);  // tensions belong to the last lambda
      return true;
    }
    if (!std::isfinite(size)) return false;
    last = size;
  }
  return false;
}

}  // namespace lithe
