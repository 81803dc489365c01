#pragma once

#include "engine/assembly/batch.h"
#include "engine/model/force_element.h"
#include "engine/model/joint_coordinate.h"
#include "joints/forces/friction_law.h"
#include "joints/forces/joint_surface.h"

namespace lithe {

/// Dry friction in a joint, driven by the joint's own reaction: regularized Coulomb with Stribeck's drop, and a viscous
/// part. A force against the sliding velocity s of the joint's surfaces, pressed by N (JointSurface has both):
///   F = μ(|s|) N + c_s |s|,   μ: FrictionLaw,   c_s: c, or c / r² of a pin and a ball
/// Below creep_speed the joint creeps: it holds no load at rest; JointBristles stick. Friction has no potential.
/// Beside contact of rigid surfaces time stepping finds it with the impulses of contact, which press the joint too.
///   graph.add<JointFriction>("rub", {pin.angle()}, {.joint = &pin, .coefficient = 0.1, .radius = 0.01});
///   graph.add<JointFriction>("rub", {sleeve.angle(), sleeve.displacement()}, {...});   // or of a screw
///   graph.add<JointFriction>("rub", ball.markers(), {...});
class JointFriction final : public ForceElement, public FrictionByImpulses {
 public:
  struct Parameters {
    const Constraint* joint = nullptr;  // its reaction gives the normal force
    double coefficient = 0;             // μ_k
    double static_coefficient = 0;      // μ_s; 0: μ_k
    double stribeck_speed = 0.1;        // v_s, m/s
    double creep_speed = 3e-3;          // v_c, m/s
    double viscous = 0;                 // c: of a pin or a ball N m s/rad, otherwise N s/m
    double radius = 0;                  // r, m; all but a slide need it
    double bending_arm = 0;             // l, m: between the bearing's halves; 0: bending gives no normal force
    double preload = 0;                 // N₀, N
  };
  /// Throws SceneError without a joint, for what turns without a radius, for coordinates other than one or an angle
  /// and the displacement along its axis, and for what is negative or not finite.
  JointFriction(CoordinateSet coordinates, Parameters parameters);
  /// Of a ball joint, on its own two markers.
  explicit JointFriction(Parameters parameters) : JointFriction(CoordinateSet({}), parameters) {}

  /// Known at run time; but its tensions alone depend on velocities, so that their damping is all of the tangent.
  static constexpr int kRows = -1;
  int marker_count() const override { return surface_.marker_count(); }
  int row_count() const override { return surface_.directions(); }
  std::vector<MeasuredAngle> angles() const override { return surface_.angles(); }
  const Constraint* reaction_of() const override { return surface_.joint(); }
  bool depends_on_time() const override { return false; }
  void evaluate(double time, std::span<const MarkerView> markers, ForceRows& rows) const override;

  bool is_set_valued() const override { return false; }
  const Constraint& pressed_by() const override { return *surface_.joint(); }
  double load() const override { return surface_.preload(); }
  int presses(std::span<const MarkerView> markers, Press* P) const override { return surface_.presses(markers, P); }
  Vector3 slid(std::span<const MarkerView> from, std::span<const MarkerView> to) const override {
    return surface_.slid(from, to);
  }
  double friction(double before, double after) const override { return law_.over_step(before, after); }

 private:
  const JointSurface surface_;
  const FrictionLaw law_;
  double viscous_;  // N s/m
};

extern template std::unique_ptr<ForceBatch> make_force_batch<JointFriction>();

}  // namespace lithe
