#pragma once

#include <optional>

#include "engine/assembly/batch.h"
#include "engine/model/constraint.h"
#include "engine/model/motion_law.h"

namespace lithe {

/// Massless rod with a ball at each end: the markers keep their distance; five degrees of freedom are left.
///   g = ½ (d · d - L²), d = p_B - p_A, one row, L constant or L(t). Its multiplier is the rod's tension over L.
///   (docs/equations.md 7.3)
class DistanceJoint final : public Joint</*markers=*/2, /*rows=*/1> {
 public:
  struct Parameters {
    std::optional<double> length{};  // L, m; none: as drawn
    MotionLaw length_law{};          // L(t), m, instead: a rod that telescopes
  };

  /// Throws SceneError for a length that is not positive or not finite, and an input that is held between samples.
  explicit DistanceJoint(Parameters parameters);

  double length() const { return length_; }

  bool depends_on_time() const override { return static_cast<bool>(length_law_); }
  void evaluate(double time, std::span<const MarkerView> markers, ConstraintRows& rows) const override {
    if (!length_law_) return at_distance(markers[0], markers[1], length_, rows);
    const Motion L = length_law_(time);
    at_distance(markers[0], markers[1], 0, rows);
    // ½ L² and its derivatives
    rows.drive_last(0.5 * L.value * L.value, L.value * L.rate, L.rate * L.rate + L.value * L.acceleration);
  }
  /// Takes the length from the drawing if none was given; refuses markers in one place: the rod has no direction there.
  void initialize(std::span<const MarkerView> markers) override;

 private:
  const bool as_drawn_;
  double length_ = 0;
  MotionLaw length_law_;
};

extern template std::unique_ptr<ConstraintBatch> make_constraint_batch<DistanceJoint>();

}  // namespace lithe
