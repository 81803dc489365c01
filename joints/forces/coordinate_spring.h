#pragma once

#include <optional>

#include "engine/assembly/batch.h"
#include "engine/model/adjustable.h"
#include "engine/model/force_element.h"
#include "engine/model/joint_coordinate.h"
#include "engine/model/tension_law.h"

namespace lithe {

/// Spring and damper on a joint coordinate: torsional on an angle (whole turns count), translational on a displacement.
///   σ = k (x - x₀) + c ẋ + σ₀,   V = ½ k (x - x₀)² + σ₀ (x - x₀);   or σ(x - x₀, ẋ) by a law; σ > 0 pulls x down
/// A stiffness, damping, free value or preload may be an Input.
///   graph.add<CoordinateSpring>("clock spring", {pin.angle()}, {.stiffness = 0.3});
class CoordinateSpring final : public Force</*markers=*/2, /*rows=*/1> {
 public:
  struct Parameters {
    Adjustable stiffness = 0;                // k, N/m or N m/rad
    Adjustable damping = 0;                  // c, N s/m or N m s/rad
    std::optional<Adjustable> free_value{};  // x₀, m or rad; none: as drawn
    Adjustable preload = 0;                  // σ₀, N or N m
    TensionLaw law{};                        // added to these
  };
  /// Throws SceneError for more than one coordinate, a negative stiffness or damping, and for a value that is not
  /// finite.
  CoordinateSpring(CoordinateSet coordinate, Parameters parameters);

  std::vector<MeasuredAngle> angles() const override { return coordinate_.angles(); }
  bool depends_on_time() const override {
    return parameters_.stiffness.varies() || parameters_.damping.varies() || free_value_.varies() ||
           parameters_.preload.varies();
  }
  const CoordinateSet& coordinate() const { return coordinate_; }
  const Parameters& parameters() const { return parameters_; }
  /// As drawn, where none was given.
  const Adjustable& free_value() const { return free_value_; }
  void evaluate(double time, std::span<const MarkerView> markers, ForceRows& rows) const override;
  void initialize(std::span<const MarkerView> markers) override;

 private:
  const CoordinateSet coordinate_;
  const Parameters parameters_;
  Adjustable free_value_ = 0;
};

extern template std::unique_ptr<ForceBatch> make_force_batch<CoordinateSpring>();

}  // namespace lithe
