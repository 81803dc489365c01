#pragma once

#include "engine/assembly/batch.h"
#include "engine/model/friction_by_impulses.h"
#include "engine/model/system_graph.h"
#include "joints/forces/first_order_states.h"
#include "joints/forces/friction_law.h"
#include "joints/forces/joint_surface.h"

namespace lithe {

/// Dry friction in a joint by Coulomb's set-valued law, pressed by the joint's own reaction N (JointSurface):
///   |F| <= μ(0) N where the surfaces stick,   F = -μ(|s|) N s / |s| where they slide,   and -c_s s besides
/// Surfaces that stick do not move at all. For MoreauJean and NonsmoothGeneralizedAlpha, which find F together with the
/// joints' reactions; others refuse the scene. The mean force F over the last step, along each direction, is a state
/// (N), and acts wherever the equations are evaluated otherwise.
///   auto& rub = add_joint_coulomb_friction(graph, "rub", {slide.displacement()}, {.joint = &slide, .coefficient =
///   0.3});
class JointCoulombFriction final : public ForceElement, public FrictionByImpulses {
 public:
  struct Parameters {
    const Constraint* joint = nullptr;           // its reaction gives the normal force
    double coefficient = 0;                      // μ_k
    double static_coefficient = 0;               // μ_s; 0: μ_k
    double stribeck_speed = 0.1;                 // v_s, m/s
    double viscous = 0;                          // c: of a pin or a ball N m s/rad, otherwise N s/m
    double radius = 0;                           // r, m; all but a slide need it
    double bending_arm = 0;                      // l, m: between the bearing's halves; 0: bending gives no normal force
    double preload = 0;                          // N₀, N
    std::vector<JointCoordinate> coordinates{};  // set by add_joint_coulomb_friction()
  };
  /// Throws SceneError as JointFriction does, and for a coefficient above the static one.
  explicit JointCoulombFriction(Parameters parameters);

  int marker_count() const override { return surface_.marker_count() + 1; }
  int row_count() const override { return surface_.directions(); }
  std::vector<MeasuredAngle> angles() const override { return surface_.angles(); }
  const Constraint* reaction_of() const override { return surface_.joint(); }
  bool depends_on_time() const override { return false; }
  void evaluate(double time, std::span<const MarkerView> markers, ForceRows& rows) const override;

  bool is_set_valued() const override { return true; }
  const Constraint& pressed_by() const override { return *surface_.joint(); }
  double load() const override { return surface_.preload(); }
  int presses(std::span<const MarkerView> markers, Press* P) const override { return surface_.presses(markers, P); }
  Vector3 slid(std::span<const MarkerView> from, std::span<const MarkerView> to) const override {
    return surface_.slid(from, to);
  }
  double friction(double before, double after) const override { return law_.at((before + after) / 2).mu; }

 private:
  const JointSurface surface_;
  const StribeckLaw law_;
  double viscous_;  // N s/m
};

extern template std::unique_ptr<ForceBatch> make_force_batch<JointCoulombFriction>();

/// On one coordinate, or on an angle and the displacement along its axis; on none: of a ball joint. Its state is a
/// FirstOrderStates of its own, named as it is with " force" behind.
JointCoulombFriction& add_joint_coulomb_friction(SystemGraph& graph, Located name,
                                                 std::vector<JointCoordinate> coordinates,
                                                 JointCoulombFriction::Parameters parameters);

}  // namespace lithe
