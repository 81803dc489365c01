#pragma once

#include <array>

#include "engine/assembly/batch.h"
#include "engine/model/constraint.h"

namespace lithe {

/// Three nodes of a body held by a fourth marker, on another body or on ground, where they are as drawn.
///   g = R_Hᵀ (p_i - p_H) - c_i, i = 1, 2, 3, nine rows; c_i from the drawing. (docs/equations.md 5.4, 7.3)
/// Nodes that are not in one line make a clamp; in one line, a hinge. A rigid body cannot fill nine rows, a flexible
/// one only as far as its modes strain the triangle: the dependent rows are found by assemble(), reported and handled,
/// and the rest removes those modes. Rows are in the axes of the holder, with which the triangle turns: those that
/// depend on others as drawn do so in every pose. Vlasenko & Kasper hold a flexible pendulum this way.
class ThreeNodeFixation final : public Joint</*markers=*/4, /*rows=*/9> {
 public:
  bool depends_on_time() const override { return false; }
  /// Markers: the holder, then the three nodes.
  void evaluate(double, std::span<const MarkerView> markers, ConstraintRows& rows) const override {
    const MarkerView& holder = markers[0];
    for (int i = 0; i < 3; ++i)
      for (int axis = 0; axis < 3; ++axis) {
        in_plane(holder, holder.R.col(axis), markers[i + 1], rows);
        rows.drive_last(held_[i][axis], 0, 0);
      }
  }
  /// Takes the held points from the drawing.
  void initialize(std::span<const MarkerView> markers) override;

 private:
  std::array<Vector3, 3> held_{Vector3::Zero(), Vector3::Zero(), Vector3::Zero()};  // c_i, in the axes of the holder
};

extern template std::unique_ptr<ConstraintBatch> make_constraint_batch<ThreeNodeFixation>();

}  // namespace lithe
