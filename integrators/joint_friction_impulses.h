#pragma once

#include "engine/cones/joint_friction_problem.h"
#include "engine/model/state.h"
#include "engine/motion/equations_of_motion.h"

namespace lithe {

/// Set-valued friction in joints as a part of a time-stepping method: impulses p along the directions D in which the
/// surfaces slide, and with them the joints' reactions Λ, from a step that was computed without friction. With the
/// step's factor of [S Gᵀ; G 0], in its middle,
///   (Y, L) = K⁻¹ (D, 0),   v' = v_free + Y p,   Λ' = Λ_free + L p,   d' = d_free + h/2 Y p,
/// while velocities are those at the step's end: with joints closed there, surfaces that stick rest there to round-off.
/// Implicit in the normal force too, so that a joint which jams stays at rest. Order 2 while surfaces slide or stick,
/// 1 over the steps in which they begin to.
class JointFrictionImpulses {
 public:
  /// Throws SceneError where contacts of rigid surfaces are in the scene too: their impulses are not found together.
  static void check(EquationsOfMotion& equations);
  /// At the start of a step: how the surfaces slide, and takes the last step's friction out of the velocities.
  void leave_out(EquationsOfMotion& equations, State& state);
  /// As leave_out() found it: the step was not taken.
  void put_back(VectorX& v) const;
  /// With the equations evaluated in the middle of the step from `start` to `time`, and factorised with its weights. v,
  /// d and the rows' impulses come without friction; q and v leave with it, joints closed. False: no joint has any.
  bool apply(EquationsOfMotion& equations, const State& start, double time, VectorX& rows, const VectorX& d, VectorX& q,
             VectorX& v);
  /// Keeps its mean forces over h in the velocities that are for it.
  void keep(EquationsOfMotion& equations, double h, VectorX& v, VectorX& v_dot) const;
  /// Sweeps of the solver in the last step.
  int sweeps() const { return sweeps_; }

 private:
  void respond(EquationsOfMotion& equations);
  void form(EquationsOfMotion& equations, double h);
  void hold(const std::vector<char>& sticks, VectorX& correction);

  JointFrictionProblem problem_;
  std::vector<std::vector<MatrixX>> by_lambda_;  // of each surface
  MatrixX D_, Y_, L_;
  VectorX p_, kept_, d_, v_, rv_, rl_, closed_, corrected_, felt_, way_;
  std::vector<int> places_;  // of what is kept
  int sweeps_ = 0;
  bool warned_ = false;
};

}  // namespace lithe
