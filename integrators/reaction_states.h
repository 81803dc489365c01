#pragma once

#include <vector>

#include "engine/model/state.h"
#include "engine/motion/equations_of_motion.h"
#include "integrators/joint_friction_impulses.h"

namespace lithe {

/// States that follow the reaction of a joint (the load n of JointBristles, ṅ = (N - n)/τ) beside contacts of rigid
/// surfaces, whose impulses press joints by far more than what a step is linearised about: N is a length, which the
/// factor of a step takes for linear, so that an impact that turns the reaction round would press with -N. Here they
/// follow N of all that the joint bears over the step, as reactions P/h, friction of other joints that time stepping
/// finds included. Velocities on which rows of joints act are left as they are: what rubs by reactions at once is no
/// state (JointFrictionImpulses).
class ReactionStates {
 public:
  /// Of a run that begins.
  void forget() { joined_.clear(); }
  /// What acts besides the smooth motion: impulses of contact, in the rows of RigidContacts::problem(), null where
  /// there are none; and friction in joints.
  struct Impulses {
    const VectorX* contact;
    const JointFrictionImpulses& friction;
  };
  /// With the factor of the step, from a smooth motion to `smooth` that has these multipliers at the state evaluated
  /// last: v, to which impulses have led.
  void follow(EquationsOfMotion& equations, const VectorX& smooth, const VectorX& lambda, double h,
              const Impulses& impulses, VectorX& v);
  /// With the factor of the step, by the midpoint rule from `start` to v along d, whose multipliers' impulses are near
  /// `total` without these. Leaves the equations in the middle of the step.
  void follow_midpoint(EquationsOfMotion& equations, const State& start, double h, const VectorX& total,
                       const Impulses& impulses, const VectorX& d, VectorX& v);

 private:
  static void add(EquationsOfMotion& equations, const Impulses& impulses, VectorX& push);
  void find_joined(const EquationsOfMotion& equations);
  void keep_states(EquationsOfMotion& equations, const VectorX& v_dot, const VectorX& lambda);

  std::vector<char> joined_;  // velocities that rows of joints know
  VectorX push_, lambda_, v_dot_, with_, without_, none_, d_, q_;
};

}  // namespace lithe
