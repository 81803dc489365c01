#pragma once

#include "engine/assembly/batch.h"
#include "engine/model/constraint.h"
#include "engine/model/motion_law.h"

namespace lithe {

/// Prescribes the displacement along the z axis of marker A.
///   g = z_A · (p_B - p_A) - f(t), one row. (docs/equations.md 7.3)
class TranslationalDriver final : public Joint</*markers=*/2, /*rows=*/1> {
 public:
  struct Parameters {
    MotionLaw motion;  // f(t), metres
  };
  /// Throws SceneError without a motion.
  explicit TranslationalDriver(Parameters parameters);
  void evaluate(double time, std::span<const MarkerView> markers, ConstraintRows& rows) const override;

 private:
  MotionLaw motion_;
};

extern template std::unique_ptr<ConstraintBatch> make_constraint_batch<TranslationalDriver>();

}  // namespace lithe
