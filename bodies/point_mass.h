#pragma once

#include <vector>

#include "engine/assembly/batch.h"
#include "engine/model/point_body.h"

namespace lithe {

/// A particle: three coordinates, the position of its mass in the world, and no axes.
///   m (p̈ - g) = f
/// Joints and forces must act at its position without a moment; assemble() refuses others
/// (engine/model/point_body.h).
class PointMass final : public PointBody {
 public:
  struct Parameters {
    double mass = 1;            // kg
    Vector3 position{0, 0, 0};  // world axes, m
    Vector3 velocity{0, 0, 0};  // world axes, m/s
  };
  struct Cache : BodyCache {
    explicit Cache(const PointMass&) {}
  };

  /// Throws SceneError for mass <= 0, NaN.
  explicit PointMass(Parameters parameters);

  const Parameters& parameters() const { return parameters_; }
  /// A frame that moves with the mass and keeps its axes `orientation` (marker axes to world axes).
  Marker marker(const Matrix3& orientation = Matrix3::Identity());
  /// The same; SceneError for a point of the world where the mass is not drawn (to 1e-9 of its distance, and 1e-9 m).
  Marker marker_at_world(const Point& point, const Matrix3& orientation = Matrix3::Identity());

  Coordinates coordinates() const override { return {.frames = 0, .linear = 3}; }
  std::unique_ptr<BodyCache> make_cache() const override { return std::make_unique<Cache>(*this); }
  void initial_state(VectorRef q, VectorRef v) const override { q = parameters_.position, v = parameters_.velocity; }
  void evaluate(const BodyState&, Level) const override {}
  void add_residual(const BodyState&, const double* v_dot, const Vector3& gravity, double* r) const override;
  void add_tangent(const BodyState&, const double* v_dot, const Vector3& gravity, const TangentWeights&,
                   BodyTangent&) const override;
  void marker_kinematics(const BodyState&, int marker, Level, MarkerKinematics&) const override;
  BodyEnergy energy(const BodyState&, const Vector3& gravity) const override;

 private:
  const Parameters parameters_;
  std::vector<Matrix3> axes_;  // of the markers
};

extern template std::unique_ptr<BodyBatch> make_body_batch<PointMass>();

}  // namespace lithe
