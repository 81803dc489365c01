#pragma once

#include "engine/assembly/batch.h"
#include "engine/model/constraint.h"
#include "engine/model/motion_law.h"

namespace lithe {

/// Prescribes the angle from x_A to x_B about the common z axis of a hinge.
///   g = n · x_B,  n = y_A cos f - x_A sin f, one row; f(t) counts over 2 pi. (docs/equations.md 7.3)
class AngleDriver final : public Joint</*markers=*/2, /*rows=*/1> {
 public:
  struct Parameters {
    MotionLaw motion;  // f(t), radians
  };
  /// Throws SceneError without a motion.
  explicit AngleDriver(Parameters parameters);
  void evaluate(double time, std::span<const MarkerView> markers, ConstraintRows& rows) const override;

 private:
  MotionLaw motion_;
};

extern template std::unique_ptr<ConstraintBatch> make_constraint_batch<AngleDriver>();

}  // namespace lithe
