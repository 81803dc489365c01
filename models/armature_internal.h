#pragma once

#include "engine/assembly/batch.h"
#include "engine/model/joint_coordinate.h"
#include "engine/model/placeless_body.h"

namespace lithe {

/// A rotor that turns with a joint's coordinate: the armature of a robot's drive. One coordinate of its own, coupled to
/// the joint's; only its kinetic energy ½ a ẋ² counts, no weight and no gyroscopic moment.
class Armature final : public PlacelessBody {
 public:
  struct Parameters {
    double inertia = 1;  // a, kg m² of an angle, kg of a displacement
    double rate = 0;     // at the start
  };
  struct Cache : BodyCache {
    explicit Cache(const Armature&) {}
  };
  /// Throws SceneError for an inertia that is not positive, and for a value that is not finite.
  explicit Armature(Parameters parameters);

  JointCoordinate coordinate() const { return {JointCoordinate::Kind::displacement, {this, 0}, {this, 1}, /*axis=*/0}; }

  Coordinates coordinates() const override { return {.frames = 0, .linear = 1}; }
  std::unique_ptr<BodyCache> make_cache() const override { return std::make_unique<Cache>(*this); }
  void initial_state(VectorRef q, VectorRef v) const override { q[0] = 0, v[0] = p_.rate; }
  void evaluate(const BodyState&, Level) const override {}
  void add_residual(const BodyState&, const double* v_dot, const Vector3&, double* r) const override {
    *r += p_.inertia * *v_dot;
  }
  void add_tangent(const BodyState&, const double*, const Vector3&, const TangentWeights& weights,
                   BodyTangent& tangent) const override {
    tangent.linear[0] += p_.inertia * weights.acceleration;
  }
  /// Marker 0 stays at the origin, marker 1 moves along x by the coordinate.
  void marker_kinematics(const BodyState&, int marker, Level, MarkerKinematics&) const override;
  BodyEnergy energy(const BodyState& state, const Vector3&) const override {
    return {.kinetic = 0.5 * p_.inertia * state.v[0] * state.v[0]};
  }

 private:
  const Parameters p_;
};

extern template std::unique_ptr<BodyBatch> make_body_batch<Armature>();

}  // namespace lithe
