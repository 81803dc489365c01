#pragma once

#include "engine/base/math.h"
#include "engine/motion/equations_of_motion.h"

namespace lithe {

/// Index-1 work on the equations of motion, with scratch of its own: consistent accelerations, and projection onto the
/// constraints along M⁻¹Gᵀ, the shortest way in the metric of the mass (docs/equations.md 8.3).
class Projector {
 public:
  explicit Projector(EquationsOfMotion& equations);

  struct Result {
    bool converged = false;
    int iterations = 0;
    double residual = 0;  // largest |g| at the end
  };
  /// The factor of [M Gᵀ; G 0] to work with: a new one whenever q moved, one made first, or the last one made.
  enum class Factor { fresh, first, last };
  /// Moves q onto g(q, t) = 0. For small corrections the first or the last factor will do.
  Result position(double time, VectorRef q, double tolerance, int max_iterations, Factor factor = Factor::fresh);
  /// Moves v onto G v + ∂g/∂t = 0; the state (time, q) is evaluated and its mass factorised.
  void velocity(double time, ConstVectorRef q, VectorRef v);
  /// [M Gᵀ; G 0] (v_dot, lambda) = (f, gamma) at (time, q, v). Factor::last: right after velocity() at the same (time,
  /// q). Where f knows lambda (friction), by iteration from the lambda given, or from none; where that does not
  /// converge, v_dot is left as NaN and lambda as it was given.
  void accelerations(double time, ConstVectorRef q, ConstVectorRef v, VectorRef v_dot, VectorRef lambda,
                     Factor factor = Factor::fresh);

 private:
  bool iterate_reactions(VectorRef v_dot, VectorRef lambda);

  EquationsOfMotion& equations_;
  VectorX zero_v_, zero_rows_, dv_, dl_, given_;
};

}  // namespace lithe
