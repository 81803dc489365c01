#pragma once

#include <optional>

#include "engine/assembly/batch.h"
#include "engine/model/constraint.h"
#include "engine/model/joint_coordinate.h"

namespace lithe {

/// Massless link with a hinge at A, its axis z_A, and a ball at B: B keeps on a circle about that axis; the turn of the
/// link and three rotations of B are left.
///   g = (½ (d · d - L²), z_A · d), d = p_B - p_A, two rows: the rod's (its multiplier is the tension over L), and the
///   shear of the hinge. (Haug 1989, ch. 9, composite joints)
class RevoluteSphericalJoint final : public Joint</*markers=*/2, /*rows=*/2> {
 public:
  struct Parameters {
    std::optional<double> length{};  // L, m; none: as drawn
  };

  /// Throws SceneError for a length that is not positive or not finite.
  explicit RevoluteSphericalJoint(Parameters parameters);

  double length() const { return length_; }
  /// Of the link, from x_A to the line from A to B about z_A.
  JointCoordinate angle() const { return {JointCoordinate::Kind::bearing, markers()[0], markers()[1]}; }
  std::vector<MeasuredAngle> angles() const override { return {{0, 1, 2, /*to_point=*/true}}; }
  bool depends_on_time() const override { return false; }
  void evaluate(double, std::span<const MarkerView> markers, ConstraintRows& rows) const override {
    const auto &A = markers[0], &B = markers[1];
    at_distance(A, B, length_, rows);
    in_plane(A, A.z(), B, rows);
  }
  /// Takes the length from the drawing if none was given; refuses markers in one place, and a link along the axis of
  /// its hinge: it could not turn.
  void initialize(std::span<const MarkerView> markers) override;

 private:
  const bool as_drawn_;
  double length_ = 0;
};

extern template std::unique_ptr<ConstraintBatch> make_constraint_batch<RevoluteSphericalJoint>();

}  // namespace lithe
