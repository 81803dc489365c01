#pragma once

#include "integrators/momentum_balance.h"

namespace lithe {

/// RATTLE on the Lie group of the bodies' poses (Andersen 1983; Hante & Arnold 2021): the variational method of the
/// discrete Lagrangian
///   L_d = h/2 (L(q, D) + L(q', D)),   q' = q ⊕ h D,   L = ½ vᵀ M v - V,
/// with one velocity D for the whole step. With P = M D, slopes s = ∂L/∂q at fixed D, θ = h D of a frame's rotation:
///   Jr⁻¹(θ) ½ (P + P')         = M v + h/2 (s - Gᵀλ₊)                    g(q', t') = 0
///   M' v' + h/2 G'ᵀλ₋          = exp(-θ) (M v + h/2 (s - Gᵀλ₊)) + h/2 s'    G' v' + ∂g/∂t = 0
/// (Jr and exp act on the rows of rotations.) Symplectic, time-reversible, order 2: energy is bounded and does not
/// drift, momenta that the scene conserves are kept to round-off, g and ġ hold at the end of every step. Fixed step.
/// Flexible bodies: exact for masses at most quadratic in η, with entries of the rows of η at most linear.
///
/// Limits. Like every method of its kind it does not damp: a frequency ω bounds the step, h ω < 2. Damping and drives
/// are taken at both ends, half each: order 2, reversible, but no energy is conserved then. Rows on velocities alone
/// (rolling) hold at D on average over both ends and at v' (McLachlan & Perlmutter 2006): not symplectic.
class Rattle final : public MomentumBalance {
 public:
  struct Parameters {
    double step = 0;                  // s; must be given
    double newton_tolerance = 1e-14;  // what may be left of D, relative to 1 + the largest velocity
  };

  /// Throws SceneError for a step or tolerance that is not positive.
  explicit Rattle(Parameters parameters) : MomentumBalance(parameters.step, parameters.newton_tolerance, "Rattle") {}

  std::string name() const override { return "RATTLE"; }

 protected:
  void prepare(EquationsOfMotion& equations, State& state) override;
  Attempt attempt(EquationsOfMotion& equations, const State& start, double h, double time) override;

 private:
  bool solve_step_velocity(EquationsOfMotion& equations, const State& start, double h, double time);
  bool solve_end_velocity(EquationsOfMotion& equations, const State& start, double h);
  void evaluate_step(EquationsOfMotion& equations, const State& start, double h, double time);

  VectorX D_, d_;  // velocity of the step, its increment h D
  VectorX q_middle_;
  VectorX lambda_begin_, lambda_end_;  // λ₊, λ₋
  VectorX momentum_, momentum_end_;    // M D at both ends
  VectorX slope_, slope_end_;          // ∂L/∂q - Gᵀλ there
  VectorX mass_rate_, mass_rate_end_;  // the deformation's part of (dM/dt) D
  VectorX launch_;                     // M v, later M v + h/2 slope
  VectorX rate_rows_;
};

}  // namespace lithe
