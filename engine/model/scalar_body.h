#pragma once

#include "engine/model/joint_coordinate.h"
#include "engine/model/placeless_body.h"

namespace lithe {

/// A placeless body of one coordinate x and constant mass, which connectors act on through its two markers: marker 0
/// stays at the origin, marker 1 moves along x by the coordinate. Not affected by gravity.
class ScalarBody : public PlacelessBody {
 public:
  struct Cache : BodyCache {
    explicit Cache(const ScalarBody&) {}
  };

  JointCoordinate coordinate() const { return {JointCoordinate::Kind::displacement, {this, 0}, {this, 1}, /*axis=*/0}; }

  Coordinates coordinates() const override { return {.frames = 0, .linear = 1}; }
  std::unique_ptr<BodyCache> make_cache() const override { return std::make_unique<Cache>(*this); }
  void initial_state(VectorRef q, VectorRef v) const override { q[0] = 0, v[0] = rate_; }
  void evaluate(const BodyState&, Level) const override {}
  void add_residual(const BodyState&, const double* v_dot, const Vector3&, double* r) const override {
    *r += mass_ * *v_dot;
  }
  void add_tangent(const BodyState&, const double*, const Vector3&, const TangentWeights& weights,
                   BodyTangent& tangent) const override {
    tangent.linear[0] += mass_ * weights.acceleration;
  }
  void marker_kinematics(const BodyState&, int marker, Level, MarkerKinematics&) const override;

 protected:
  /// Starts at x = 0 with this rate.
  ScalarBody(double mass, double rate) : mass_(mass), rate_(rate) { set_marker_count(2); }
  double mass() const { return mass_; }

 private:
  const double mass_, rate_;
};

}  // namespace lithe
