#pragma once

#include "engine/assembly/batch.h"
#include "engine/model/constraint.h"

namespace lithe {

/// Two spur gears on parallel z axes in mesh; it ties nothing else: hold each by a bearing on ground, or on a carrier
/// that may turn itself (planetary trains). The force acts at the pitch point, so it loads the bearings.
///   g = r_A φ_A + r_B φ_B - offset, φ the angle of the line of centres against each gear about its z axis, one row. A
///   ring gear has a negative radius. The offset is that of the drawing. Helix and pressure angles are neglected: the
///   force is tangential. For bevel and worm gears couple the angles: CoordinateCoupling.
class GearPair final : public Joint</*markers=*/2, /*rows=*/1> {
 public:
  struct Parameters {
    double radius_A = 0, radius_B = 0;  // pitch radii, m
  };
  /// Throws SceneError for radii that are zero or not finite.
  explicit GearPair(Parameters parameters);
  std::vector<MeasuredAngle> angles() const override {
    return {{.A = 0, .B = 1, .axis = 2, .to_point = true}, {.A = 1, .B = 0, .axis = 2, .to_point = true}};
  }
  bool depends_on_time() const override { return false; }
  void evaluate(double time, std::span<const MarkerView> markers, ConstraintRows& rows) const override;
  /// Refuses axes that are not parallel and centres that are not the sum of the radii apart (to 1 %): no mesh.
  void initialize(std::span<const MarkerView> markers) override;

 private:
  const Parameters parameters_;
  double offset_ = 0;
};

extern template std::unique_ptr<ConstraintBatch> make_constraint_batch<GearPair>();

}  // namespace lithe
