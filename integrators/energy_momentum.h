#pragma once

#include "integrators/momentum_balance.h"

namespace lithe {

/// Energy- and momentum-conserving midpoint rule (Simo & Wong 1991; Gonzalez 1996, 1999). With v_m = ½ (v + v') a step
/// goes along constant v_m from q by its middle q_m to q',
///   x' = x + h ẋ_m,   R' = R exp(θ),  2 sin(|θ|/2) = h |ω_m|, θ along ω_m,   η' = η + h η̇_m,
/// and balances each body's momenta P (linear), l (angular, about the frame's origin, body axes), π (elastic) with the
/// forces F, torques τ and slopes of the middle, constraint forces -G_mᵀλ included:
///   P' - P = h F_m
///   R' l' - R l + (x' - x) × ½ (P + P') = h R_m τ_m
///   π' - π = h (∂T/∂η + F_η)_m - c M_ηη η̇_m
///   g(q', t') = 0
/// Exact, to the tolerance of Newton: linear momentum; angular momentum, if no joint acts; and the
/// balance of energy with the work of constant forces (weight of rigid bodies), of elastic bodies (linear in η) and
/// of reactions whose rows are linear in points and axes of each body: points held together, axes held to the ground,
/// hinges of planar mechanisms, all by the choice of θ. c, a scalar a body, gives an elastic body's kinetic energy its
/// exact change.
/// Not exact: springs that stretch and rotate, axes of two bodies that both rotate, rolling, joints on modes. Their
/// work is that of the forces at the middle; energy errs by O(h²), bounded if the motion is resolved. A stiff rotating
/// spring makes it unstable (stability laboratory S24): use a method that damps. Joints open by O(h²) in the middle of
/// a step, so the angular momentum of bodies held together errs by O(h²) too, bounded (Rattle conserves it).
///
/// Order 2 in q, v, λ; fixed step; no damping. G v = 0 holds for v_m, thus for v' within O(h²). A body turns less than
/// half a turn a step: h |ω| < 2.
class EnergyMomentum final : public MomentumBalance {
 public:
  struct Parameters {
    double step = 0;                  // s; must be given
    double newton_tolerance = 1e-15;  // what may be left of v', relative to 1 + the largest velocity
  };

  /// Throws SceneError for a step or tolerance that is not positive.
  explicit EnergyMomentum(Parameters parameters)
      : MomentumBalance(parameters.step, parameters.newton_tolerance, "EnergyMomentum") {}

  std::string name() const override { return "energy-momentum midpoint rule"; }

 protected:
  void prepare(EquationsOfMotion& equations, State& state) override;
  Attempt attempt(EquationsOfMotion& equations, const State& start, double h, double time) override;

 private:
  bool move(const Layout& layout, const State& start, double h);
  void evaluate_step(EquationsOfMotion& equations, const State& start, double h, double time);
  void balance(const Layout& layout, const State& start, double h);

  VectorX v_middle_, q_middle_, d_;              // v_m, the middle, half the increment
  VectorX momentum_, momentum_end_;              // M v at both ends
  VectorX momentum_middle_, slope_, mass_rate_;  // M v_m, ∂L/∂q - Gᵀλ, the deformation's part of (dM/dt) v_m
  VectorX elastic_;                              // M_ηη η̇_m
  VectorX x_, rate_rows_;
};

}  // namespace lithe
