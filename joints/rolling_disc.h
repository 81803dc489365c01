#pragma once

#include "engine/assembly/batch.h"
#include "engine/model/constraint.h"

namespace lithe {

/// A thin disc rolls on a plane and never slips nor lifts off: coin, wheel, knife edge. Marker A: the plane, normal
/// z_A; marker B: the centre of the disc, axle z_B. With n = z_A, a = z_B, u the unit vector in the disc that points
/// most along n, the disc touches at c = p_B - r u, and
///   g   = n · (p_B - p_A) - r sqrt(1 - (n·a)²) = 0                                      it touches
///   ġ_x = x_A · s = 0,  ġ_y = y_A · s = 0,  s = v_B - w_B × r u - v_A - w_A × (c - p_A)     no slip: on velocities
///   alone
/// one holonomic and two nonholonomic rows; three velocities are left, five positions. A disc that lies flat has no
/// lowest point: kept away from. (Neimark and Fufaev 1972; Whittaker's rolling disc)
class RollingDisc final : public Joint</*markers=*/2, /*rows=*/3> {
 public:
  struct Parameters {
    double radius = 0;  // r, m
  };
  /// Throws SceneError for a radius that is not positive.
  explicit RollingDisc(Parameters parameters);
  bool depends_on_time() const override { return false; }
  void evaluate(double time, std::span<const MarkerView> markers, ConstraintRows& rows) const override;
  /// Refuses a disc that is drawn flat.
  void initialize(std::span<const MarkerView> markers) override;

 private:
  const double radius_;
};

extern template std::unique_ptr<ConstraintBatch> make_constraint_batch<RollingDisc>();

}  // namespace lithe
