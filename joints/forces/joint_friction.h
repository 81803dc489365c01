#pragma once

#include "engine/assembly/batch.h"
#include "engine/model/force_element.h"
#include "engine/model/joint_coordinate.h"
#include "joints/forces/friction_law.h"

namespace lithe {

/// Dry friction in a joint, driven by the joint's own reaction: regularized Coulomb with Stribeck's drop, and a viscous
/// part.
///   μ(s): FrictionLaw,   s: sliding speed, m/s
///   an angle:        torque = r μ(r φ̇) N + c φ̇,   N = |F_lateral| + |F_axial| + |T_lateral| / l + N₀
///   a displacement:  force  = μ(ẋ) N + c ẋ,        N = |F_lateral| + |T_lateral| / l + |T_axial| / r + N₀
/// F, T: the joint's reaction at its second marker, along the coordinate's axis and across it; a term without a given
/// arm is left out. Below creep_speed the joint creeps: it holds no load at rest. Friction has no potential.
///   graph.add<JointFriction>("rub", {pin.angle()}, {.joint = &pin, .coefficient = 0.1, .radius = 0.01});
class JointFriction final : public Force</*markers=*/2, /*rows=*/1> {
 public:
  struct Parameters {
    const Constraint* joint = nullptr;  // its reaction gives the normal force
    double coefficient = 0;             // μ_k
    double static_coefficient = 0;      // μ_s; 0: μ_k
    double stribeck_speed = 0.1;        // v_s, m/s
    double creep_speed = 3e-3;          // v_c, m/s
    double viscous = 0;                 // c, N m s/rad or N s/m
    double radius = 0;                  // r, m; an angle needs it
    double bending_arm = 0;             // l, m: between the bearing's halves; 0: bending gives no normal force
    double preload = 0;                 // N₀, N
  };
  /// Throws SceneError without a joint, for an angle without a radius, and for what is negative or not finite.
  JointFriction(CoordinateSet coordinate, Parameters parameters);

  std::vector<MeasuredAngle> angles() const override { return coordinate_.angles(); }
  const Constraint* reaction_of() const override { return parameters_.joint; }
  bool depends_on_time() const override { return false; }
  void evaluate(double time, std::span<const MarkerView> markers, ForceRows& rows) const override;

 private:
  const CoordinateSet coordinate_;
  Parameters parameters_;
  FrictionLaw law_;
};

extern template std::unique_ptr<ForceBatch> make_force_batch<JointFriction>();

}  // namespace lithe
