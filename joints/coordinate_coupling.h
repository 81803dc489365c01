#pragma once

#include <optional>

#include "engine/assembly/batch.h"
#include "engine/model/constraint.h"
#include "engine/model/joint_coordinate.h"

namespace lithe {

/// Ties joint coordinates linearly: gears, belts, differentials, mirrored slides.
///   g = Σ_i c_i x_i - offset, one row; angles with their turns.
///   graph.add<CoordinateCoupling>("belt", {motor.angle(), fan.angle()}, {.factors = {1, -2.5}});
/// Its forces act along the coordinates: between angles pure torques, as of belts that do not load their shafts. For
/// gears that load their bearings use a GearPair.
class CoordinateCoupling final : public Constraint {
 public:
  static constexpr int kRows = 1;
  struct Parameters {
    std::vector<double> factors;     // c_i, one a coordinate
    std::optional<double> offset{};  // value of Σ c_i x_i; none: as drawn
  };
  /// Throws SceneError for factors that do not fit the coordinates, and for more than four coordinates.
  CoordinateCoupling(CoordinateSet coordinates, Parameters parameters);

  int marker_count() const override { return 2 * coordinates_.count(); }
  int row_count() const override { return 1; }
  std::vector<MeasuredAngle> angles() const override { return coordinates_.angles(); }
  bool depends_on_time() const override { return false; }
  void evaluate(double time, std::span<const MarkerView> markers, ConstraintRows& rows) const override;
  void initialize(std::span<const MarkerView> markers) override;

 private:
  const CoordinateSet coordinates_;
  const Parameters parameters_;
  double offset_ = 0;
};

extern template std::unique_ptr<ConstraintBatch> make_constraint_batch<CoordinateCoupling>();

}  // namespace lithe
