#pragma once

#include "engine/assembly/batch.h"
#include "engine/model/joint_coordinate.h"
#include "engine/model/placeless_body.h"

namespace lithe {

/// The integral of a signal, for controllers: one coordinate of unit mass on which only its controller acts, so that
/// its rate is the integral of that force over time. It has no energy and is not affected by gravity.
class IntegralState final : public PlacelessBody {
 public:
  struct Parameters {
    double start = 0;  // of the integral
  };
  struct Cache : BodyCache {
    explicit Cache(const IntegralState&) {}
  };
  /// Throws SceneError for a value that is not finite.
  explicit IntegralState(Parameters parameters);

  /// Its rate is the integral.
  JointCoordinate coordinate() const { return {JointCoordinate::Kind::displacement, {this, 0}, {this, 1}, /*axis=*/0}; }

  Coordinates coordinates() const override { return {.frames = 0, .linear = 1}; }
  std::unique_ptr<BodyCache> make_cache() const override { return std::make_unique<Cache>(*this); }
  void initial_state(VectorRef q, VectorRef v) const override { q[0] = 0, v[0] = start_; }
  void evaluate(const BodyState&, Level) const override {}
  void add_residual(const BodyState&, const double* v_dot, const Vector3&, double* r) const override { *r += *v_dot; }
  void add_tangent(const BodyState&, const double*, const Vector3&, const TangentWeights& weights,
                   BodyTangent& tangent) const override {
    tangent.linear[0] += weights.acceleration;
  }
  /// Marker 0 stays at the origin, marker 1 moves along x by the coordinate.
  void marker_kinematics(const BodyState&, int marker, Level, MarkerKinematics&) const override;
  BodyEnergy energy(const BodyState&, const Vector3&) const override { return {}; }

 private:
  const double start_;
};

extern template std::unique_ptr<BodyBatch> make_body_batch<IntegralState>();

}  // namespace lithe
