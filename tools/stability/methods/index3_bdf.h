#pragma once

#include "engine/motion/integrator.h"
#include "tools/stability/methods/step_pattern.h"

namespace lithe::lab {

/// BDF of order 1 or 2 straight on the index-3 equations in their first-order form, by dense Newton:
///   ḋ = v',   M v̇' + Gᵀ λ' = f',   g(q') = 0,   q' = q ⊕ d
/// for systems without redundant rows. The multipliers of order 1 lose all accuracy at changes of the step; the Newton
/// matrix has condition h⁻³ unless its rows and columns are scaled by powers of h (Petzold & Lötstedt 1986). Order 2
/// needs constant steps and takes its first step from start_with().
class Index3Bdf final : public Integrator {
 public:
  struct Parameters {
    double step = 0;  // s
    int order = 1;
    Steps steps = Steps::constant;
    bool scaled = true;  // the Newton matrix
  };
  explicit Index3Bdf(Parameters parameters) : parameters_(parameters) {}

  /// Order 2: the state a step before the one that it is started with; to be called before start().
  void start_with(const State& before) { before_ = before; }
  /// Of the last Newton matrix as it was solved.
  double last_condition() const;

  std::string name() const override { return "BDF on index 3"; }
  const IntegratorStatistics& statistics() const override { return statistics_; }

 protected:
  void prepare(EquationsOfMotion& equations, State& state) override;
  StepResult advance(EquationsOfMotion& equations, State& state, double t_stop) override;

 private:
  void form(EquationsOfMotion& equations, double h, double share);

  Parameters parameters_;
  IntegratorStatistics statistics_;
  State before_;
  VectorX d_before_, v_before_;  // the increment and the velocities of the step before
  VectorX d_, q_, v_, v_dot_, lambda_, rhs_, row_scale_, column_scale_;
  MatrixX matrix_;
};

}  // namespace lithe::lab
