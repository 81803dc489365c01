#pragma once

#include <functional>

#include "engine/assembly/batch.h"
#include "engine/model/force_element.h"
#include "engine/model/joint_coordinate.h"

namespace lithe {

/// A motor whose effort on a joint coordinate is a function of time, coordinate and rate: a torque on an angle, a force
/// on a displacement, positive in the direction in which the coordinate grows. Newton's method uses central differences
/// of it by the coordinate and its rate.
///   graph.add<CoordinateMotor>("motor", {shaft.angle()},
///                              {[](double, double, double speed) { return 5 - 0.1 * speed; }});
class CoordinateMotor final : public Force</*markers=*/2, /*rows=*/1> {
 public:
  struct Parameters {
    std::function<double(double time, double coordinate, double rate)> effort;  // N or N m
  };
  /// Throws SceneError without a law, and for more than one coordinate.
  CoordinateMotor(CoordinateSet coordinate, Parameters parameters);

  std::vector<MeasuredAngle> angles() const override { return coordinate_.angles(); }
  const CoordinateSet& coordinate() const { return coordinate_; }
  const Parameters& parameters() const { return parameters_; }
  void evaluate(double time, std::span<const MarkerView> markers, ForceRows& rows) const override;

 private:
  const CoordinateSet coordinate_;
  const Parameters parameters_;
};

extern template std::unique_ptr<ForceBatch> make_force_batch<CoordinateMotor>();

}  // namespace lithe
