#pragma once

#include <vector>

#include "engine/model/body.h"

namespace lithe {

/// The inertial frame: no coordinates, markers that never move.
class Ground final : public Body {
 public:
  struct Cache : BodyCache {
    explicit Cache(const Ground&) {}
  };

  /// A frame fixed in the world at `position` (m) with axes `orientation` (marker axes to world axes).
  Marker marker(const Point& position = {}, const Matrix3& orientation = Matrix3::Identity());
  /// The same, under the name that other bodies have for it.
  Marker marker_at_world(const Point& point, const Matrix3& orientation = Matrix3::Identity()) {
    return marker(point, orientation);
  }

  Coordinates coordinates() const override { return {.frames = 0, .linear = 0}; }
  std::unique_ptr<BodyCache> make_cache() const override { return std::make_unique<Cache>(*this); }
  void initial_state(VectorRef, VectorRef) const override {}
  void evaluate(const BodyState&, Level) const override {}
  void add_residual(const BodyState&, const double*, const Vector3&, double*) const override {}
  void add_tangent(const BodyState&, const double*, const Vector3&, const TangentWeights&,
                   BodyTangent&) const override {}
  void marker_kinematics(const BodyState&, int marker, Level, MarkerKinematics&) const override;
  BodyEnergy energy(const BodyState&, const Vector3&) const override { return {}; }

 private:
  struct Pose {
    Vector3 position;
    Matrix3 orientation;
  };
  std::vector<Pose> markers_;
};

}  // namespace lithe
