#pragma once

#include <limits>

#include "engine/assembly/batch.h"
#include "engine/model/force_element.h"
#include "engine/model/joint_coordinate.h"
#include "engine/model/motion_law.h"

namespace lithe {

/// PID controller that pushes a joint coordinate x towards a target w(t); the integral of the error is the rate of an
/// IntegralState's coordinate.
///   F = k_p e + k_i ∫e dt + k_d ė,   e = w - x
///   auto& memory = graph.add<IntegralState>("memory");
///   graph.add<PidController>("servo", {elbow.angle(), memory.coordinate()}, {.target = ..., .proportional = 80});
/// At the force limit the integral is held as long as it would increase the force further (no wind-up).
class PidController final : public Force</*markers=*/4, /*rows=*/1> {
 public:
  struct Parameters {
    MotionLaw target;                                        // w(t), m or rad; angles count their turns
    double proportional = 0;                                 // k_p, N/m or N m/rad
    double integral = 0;                                     // k_i, N/(m s) or N m/(rad s)
    double derivative = 0;                                   // k_d, N s/m or N m s/rad
    double limit = std::numeric_limits<double>::infinity();  // of |F|, N or N m
  };
  /// Throws SceneError without a target, without the two coordinates, and for gains that are negative or not finite.
  PidController(CoordinateSet coordinates, Parameters parameters);

  std::vector<MeasuredAngle> angles() const override { return coordinates_.angles(); }
  void evaluate(double time, std::span<const MarkerView> markers, ForceRows& rows) const override;

 private:
  const CoordinateSet coordinates_;
  const Parameters parameters_;
};

extern template std::unique_ptr<ForceBatch> make_force_batch<PidController>();

}  // namespace lithe
