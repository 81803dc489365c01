#pragma once

#include "engine/motion/integrator.h"
#include "tools/stability/methods/step_pattern.h"

namespace lithe::lab {

/// Generalized-alpha on index 3 (Chung & Hulbert 1993) without the library's safeguards: spectral radius 1 is allowed,
/// which is Newmark's trapezoidal rule (β = ¼, γ = ½); Newton's last iterate is taken, converged or not; at a change of
/// the step the acceleration-like state is carried over or reset; the start may be inconsistent; the linear systems may
/// be solved densely, with or without a cut of small singular values.
class PlainAlpha final : public Integrator {
 public:
  enum class StartAcceleration { consistent, zero };
  enum class StepChange { carry, reset };
  enum class Solver { engine, dense_lu, truncated_least_squares };
  struct Parameters {
    double step = 0;             // s
    double spectral_radius = 1;  // at infinite frequency
    Steps steps = Steps::constant;
    StartAcceleration start = StartAcceleration::consistent;
    StepChange at_step_change = StepChange::carry;
    Solver solver = Solver::engine;
    double cut = 1e-10;              // singular values, of the largest: truncated least squares
    double newton_tolerance = 1e-9;  // of accelerations and multipliers, relative to the largest and 1
    int max_newton = 25;
    bool straight_guess = false;  // Newton starts from q ⊕ h v, not from the accelerations of the step's start
  };
  explicit PlainAlpha(Parameters parameters);

  std::string name() const override { return "generalized-alpha on index 3, plain"; }
  const IntegratorStatistics& statistics() const override { return statistics_; }  // newton_failures: not converged

 protected:
  void prepare(EquationsOfMotion& equations, State& state) override;
  StepResult advance(EquationsOfMotion& equations, State& state, double t_stop) override;

 private:
  void solve(EquationsOfMotion& equations, double h, double per_d);

  Parameters parameters_;
  double am_, af_, gamma_, beta_;
  IntegratorStatistics statistics_;
  VectorX a_;  // acceleration-like state
  VectorX a_free_, q_, v_, d_, delta_, v_dot_, lambda_, rv_, rl_;
};

}  // namespace lithe::lab
