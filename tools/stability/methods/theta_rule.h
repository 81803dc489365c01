#pragma once

#include "engine/motion/integrator.h"

namespace lithe::lab {

/// Implicit one-stage rules of fixed step for bodies without constraints: θ = 1 implicit Euler, θ = ½ implicit
/// midpoint.
///   v' = v + h v̇,   d = h (v + θ h v̇),   M v̇ = f at (q ⊕ θ d, v + θ h v̇),   q' = q ⊕ d
class ThetaRule final : public Integrator {
 public:
  struct Parameters {
    double step = 0;  // s
    double theta = 0.5;
  };
  explicit ThetaRule(Parameters parameters) : parameters_(parameters) {}

  std::string name() const override { return parameters_.theta == 1 ? "implicit Euler" : "implicit midpoint"; }
  const IntegratorStatistics& statistics() const override { return statistics_; }  // newton_failures: not converged

 protected:
  void prepare(EquationsOfMotion& equations, State& state) override;
  StepResult advance(EquationsOfMotion& equations, State& state, double t_stop) override;

 private:
  Parameters parameters_;
  IntegratorStatistics statistics_;
  VectorX q_, v_, d_, v_dot_, rv_, none_;
};

}  // namespace lithe::lab
