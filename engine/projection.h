#pragma once

#include "engine/equations_of_motion.h"
#include "engine/math.h"

namespace lithe {

/// Index-1 work on the equations of motion, with scratch of its own: consistent accelerations, and projection onto the
/// constraints along M⁻¹Gᵀ, the shortest way in the metric of the mass (EQUATIONS.md 8.3).
class Projector {
 public:
  explicit Projector(EquationsOfMotion& equations);

  struct Result {
    bool converged = false;
    int iterations = 0;
    double residual = 0;  // largest |g| at the end
  };
  /// Moves q onto g(q, t) = 0. `reuse`: keep the mass factor of the first iteration (for small corrections).
  Result position(double time, VectorRef q, double tolerance, int max_iterations, bool reuse = false);
  /// Moves v onto G v + ∂g/∂t = 0; the state (time, q) is evaluated and its mass factorised.
  void velocity(double time, ConstVectorRef q, VectorRef v);
  /// [M Gᵀ; G 0] (v_dot, lambda) = (f, gamma) at (time, q, v).
  void accelerations(double time, ConstVectorRef q, ConstVectorRef v, VectorRef v_dot, VectorRef lambda);

 private:
  EquationsOfMotion& equations_;
  VectorX zero_v_, zero_rows_, dv_, dl_;
};

}  // namespace lithe
