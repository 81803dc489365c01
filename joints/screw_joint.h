#pragma once

#include "engine/assembly/batch.h"
#include "engine/model/constraint.h"
#include "engine/model/joint_coordinate.h"

namespace lithe {

/// Nut on a screw: a cylindrical joint whose displacement along z_A and angle about it belong together; one freedom.
///   g = (x_A · z_B, y_A · z_B, x_A · d, y_A · d, z_A · d - (lead / 2π) φ - offset), five rows; a positive lead moves B
///   along +z when it turns right-handed about z. The offset is that of the drawing.
class ScrewJoint final : public Joint</*markers=*/2, /*rows=*/5> {
 public:
  struct Parameters {
    double lead = 0;  // m a turn
  };
  /// Throws SceneError for a lead that is zero or not finite.
  explicit ScrewJoint(Parameters parameters);

  JointCoordinate angle() const { return {JointCoordinate::Kind::angle, markers()[0], markers()[1]}; }
  JointCoordinate displacement() const { return {JointCoordinate::Kind::displacement, markers()[0], markers()[1]}; }
  std::vector<MeasuredAngle> angles() const override { return {{0, 1, 2}}; }

  bool depends_on_time() const override { return false; }
  void evaluate(double time, std::span<const MarkerView> markers, ConstraintRows& rows) const override;
  void initialize(std::span<const MarkerView> markers) override;

 private:
  const double rise_;  // m a radian
  double offset_ = 0;
};

extern template std::unique_ptr<ConstraintBatch> make_constraint_batch<ScrewJoint>();

}  // namespace lithe
