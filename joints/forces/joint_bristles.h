#pragma once

#include "engine/assembly/batch.h"
#include "engine/model/force_element.h"
#include "engine/model/system_graph.h"
#include "joints/forces/bristle_law.h"
#include "joints/forces/first_order_states.h"
#include "joints/forces/joint_surface.h"

namespace lithe {

/// Dry friction that sticks, in a joint, pressed by the joint's own reaction N (JointSurface): elastoplastic bristles
/// (BristleLaw) whose deflections z are states, so that every integrator carries them. Below breakaway, μ_s N, they
/// hold a load at rest for good: the joint gives by δ, and does not creep.
///   F = n μ_s (z + ...) + c_s s,   ṅ = (N - n) / τ_n
/// The load n that presses them follows N: so the force depends on states alone, Newton's matrix is exact, and a joint
/// that is about to jam still has one acceleration. States: z, up to three, and n in kN.
///   auto& states = graph.add<FirstOrderStates>("bristles", {.start = JointBristles::start()});
///   add_joint_bristles(graph, "rub", {slide.displacement()}, states, {.joint = &slide, .coefficient = 0.3});
class JointBristles final : public ForceElement {
 public:
  struct Parameters {
    const Constraint* joint = nullptr;           // its reaction gives the normal force
    double coefficient = 0;                      // μ_k
    double static_coefficient = 0;               // μ_s; 0: μ_k
    double stribeck_speed = 0.1;                 // v_s, m/s
    double breakaway_deflection = 1e-5;          // δ, m, on the sliding surface
    double damping_time = 1e-3;                  // τ, s
    double elastic_share = 0.9;                  // a: of the deflection of sliding, below which bristles are elastic
    double load_time = 1e-4;                     // τ_n, s
    double viscous = 0;                          // c: of a pin or a ball N m s/rad, otherwise N s/m
    double radius = 0;                           // r, m; all but a slide need it
    double bending_arm = 0;                      // l, m: between the bearing's halves; 0: bending gives no normal force
    double preload = 0;                          // N₀, N
    std::vector<JointCoordinate> coordinates{};  // set by add_joint_bristles()
  };
  /// Throws SceneError as JointFriction does, and for a coefficient that is not positive or above the static one, a
  /// breakaway_deflection or load_time that is not positive, an elastic_share that is not between 0 and 1.
  explicit JointBristles(Parameters parameters);
  /// The four states that it starts from: the load n, N, and deflections z, of 1 at breakaway.
  static VectorX start(double load = 0, const Vector3& deflection = {0, 0, 0});

  int marker_count() const override { return surface_.marker_count() + 2; }
  int row_count() const override { return 1; }
  std::vector<MeasuredAngle> angles() const override { return surface_.angles(); }
  const Constraint* reaction_of() const override { return surface_.joint(); }
  bool depends_on_time() const override { return false; }
  void evaluate(double time, std::span<const MarkerView> markers, ForceRows& rows) const override;

 private:
  const JointSurface surface_;
  const BristleLaw law_;
  const double load_time_;
  double viscous_;  // N s/m
};

extern template std::unique_ptr<ForceBatch> make_force_batch<JointBristles>();

/// On one coordinate, or on an angle and the displacement along its axis. `states`: a FirstOrderStates of its own, of
/// four.
JointBristles& add_joint_bristles(SystemGraph& graph, Located name, std::vector<JointCoordinate> coordinates,
                                  const FirstOrderStates& states, JointBristles::Parameters parameters);
/// Of a ball joint.
inline JointBristles& add_ball_bristles(SystemGraph& graph, Located name, const FirstOrderStates& states,
                                        JointBristles::Parameters parameters) {
  return add_joint_bristles(graph, std::move(name), {}, states, std::move(parameters));
}

}  // namespace lithe
