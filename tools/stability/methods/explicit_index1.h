#pragma once

#include <vector>

#include "engine/motion/integrator.h"

namespace lithe::lab {

/// Explicit Runge-Kutta of fixed step on the index-1 form [M Gᵀ; G 0] (v̇, λ) = (f, γ), with quaternions as four plain
/// numbers: what a program does that takes an ordinary solver off the shelf. How it keeps the constraints is a choice:
///   none               g̈ = 0 alone: |g| grows as t²
///   velocity           v is moved onto ġ = 0 after a step: |g| grows as t
///   position_velocity  q and v are moved onto the constraints after a step
///   baumgarte          g̈ + 2 α ġ + β² g = 0 (Baumgarte 1972): stiff for large α h
/// Projections are along M⁻¹Gᵀ. On unconstrained bodies it is plain explicit Euler or RK4. How it solves that system:
///   engine            by the engine's blocks, redundant rows left out once and for all
///   dense_lu          of the whole matrix; refuses a singular one
///   rows_once_a_step  of rows independent at the start of the step, found by pivoting; the others bear nothing
///   rows_every_stage  of rows found anew at every stage, which lie off the constraints
///   least_norm        by singular values; dependent rows share the load
///   regularised       of the matrix with -ε on the diagonal of the multipliers
class ExplicitIndex1 final : public Integrator {
 public:
  enum class Method { euler, rk4 };
  enum class Stabilisation { none, velocity, position_velocity, baumgarte };
  enum class Solver { engine, dense_lu, rows_once_a_step, rows_every_stage, least_norm, regularised };
  struct Parameters {
    double step = 0;  // s
    Method method = Method::rk4;
    Stabilisation stabilisation = Stabilisation::none;
    double alpha = 0, beta = 0;  // 1/s
    bool normalise = true;       // quaternions after every step
    Solver solver = Solver::engine;
    double cut = 1e-12;  // of pivots or singular values, relative to the largest; regularised: ε
  };
  explicit ExplicitIndex1(Parameters parameters) : parameters_(parameters) {}

  std::string name() const override { return "explicit Runge-Kutta on index 1"; }
  const IntegratorStatistics& statistics() const override { return statistics_; }

 protected:
  void prepare(EquationsOfMotion& equations, State& state) override;
  StepResult advance(EquationsOfMotion& equations, State& state, double t_stop) override;

 private:
  void rates(EquationsOfMotion& equations, double time, int stage);
  void solve(EquationsOfMotion& equations, VectorRef rv, VectorRef rl);
  void project(EquationsOfMotion& equations, double time);

  Parameters parameters_;
  IntegratorStatistics statistics_;
  MatrixX q_dot_, v_dot_;  // a column a stage
  VectorX q_, v_, lambda_, rows_, dv_, zero_v_, zero_rows_;
  std::vector<int> chosen_;  // independent rows
  bool choose_ = true;       // them anew
  std::string trouble_;      // why the accelerations could not be found
};

}  // namespace lithe::lab
