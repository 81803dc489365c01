#pragma once

#include <string>

#include "engine/equations_of_motion.h"
#include "engine/state.h"

namespace lithe {

/// The one tolerance convention: a component x of the chart increment or of v may err by absolute + relative |x| a step
/// (rotations: |x| = 1 rad); the root mean square of error over allowance is kept below 1.
struct Tolerance {
  double relative = 1e-6;
  double absolute = 1e-8;
};

/// What an integrator has done since start().
struct IntegratorStatistics {
  long steps = 0, rejected = 0, newton_iterations = 0, factorizations = 0, evaluations = 0;
};

/// How a step ended. On failure the state holds the last good time and `why` says what stopped it.
struct StepResult {
  enum class Outcome { reached, failed } outcome = Outcome::reached;
  std::string why;
  bool ok() const { return outcome == Outcome::reached; }
};

/// Advances a state of the equations of motion. Keeps its own history; a changed state needs start().
class Integrator {
 public:
  virtual ~Integrator() = default;
  virtual std::string name() const = 0;
  /// Forgets the past and makes state.v_dot, state.lambda consistent with (time, q, v).
  virtual void start(EquationsOfMotion& equations, State& state) = 0;
  /// One step, never past t_stop; t_stop is hit exactly. Trouble inside (no convergence) is met with smaller steps
  /// first.
  virtual StepResult step(EquationsOfMotion& equations, State& state, double t_stop) = 0;
  virtual const IntegratorStatistics& statistics() const = 0;
};

/// A step for messages: "2.4e-07 s".
std::string step_text(double h);

/// Root mean square of error over allowance (Tolerance), for an error in the chart or in v with component magnitudes
/// |x|.
double error_ratio(ConstVectorRef error, ConstVectorRef magnitudes, const Tolerance& tolerance);

}  // namespace lithe
