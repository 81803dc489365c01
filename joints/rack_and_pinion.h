#pragma once

#include "engine/assembly/batch.h"
#include "engine/model/constraint.h"

namespace lithe {

/// Pinion A turns about its z axis and rolls on rack B, which runs along x_B with its teeth towards the pinion; it ties
/// nothing else: hold the pinion by a bearing, the rack by a slide. The force acts in the pitch point.
///   g = x_B · (p_A - p_B) + r φ - offset, φ the angle of the pinion about z_B, one row; the pinion is on the +y side
///   of the rack. A negative radius: on the -y side. The offset is that of the drawing.
class RackAndPinion final : public Joint</*markers=*/2, /*rows=*/1> {
 public:
  struct Parameters {
    double radius = 0;  // r, pitch radius, m
  };
  /// Throws SceneError for a radius that is zero or not finite.
  explicit RackAndPinion(Parameters parameters);
  std::vector<MeasuredAngle> angles() const override { return {{1, 0, 2}}; }
  bool depends_on_time() const override { return false; }
  void evaluate(double time, std::span<const MarkerView> markers, ConstraintRows& rows) const override;
  void initialize(std::span<const MarkerView> markers) override;

 private:
  const double radius_;
  double offset_ = 0;
};

extern template std::unique_ptr<ConstraintBatch> make_constraint_batch<RackAndPinion>();

}  // namespace lithe
