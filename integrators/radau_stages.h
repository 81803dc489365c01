#pragma once

#include "engine/motion/integrator.h"
#include "engine/motion/kept_factor.h"
#include "engine/motion/step_derivative.h"

namespace lithe {

/// What the stages of one step came to, a column each.
struct RadauRecord final : StepRecord {
  MatrixX d, v, v_dot, lambda;
  std::size_t bytes() const override {
    return sizeof(RadauRecord) + sizeof(double) * static_cast<std::size_t>(3 * d.size() + lambda.size());
  }
};

/// The three stages of one step of Radau IIA (Hairer & Wanner II, IV.5) in the stabilized index-2 form (Gear, Gupta &
/// Leimkuhler 1985), in the chart of the step's start, q_i = q_n ⊕ d_i:
///   v_i = v_n + h Σ a_ij v̇_j,   d_i = h Σ a_ij Jr⁻¹(d_j) v_j + c_i,
///   M v̇_i + Gᵀλ_i = f,   G v_i + ∂g/∂t = 0,   g(q_i) = 0.
/// The corrections c_i, as small as the error, take the part of the second multipliers: c_i = B γ_i with B along S⁻¹Gᵀ,
/// one and the same for all stages and iterations of a step, or the order falls to 3.
///
/// Simplified Newton (IV.8): the eigenvectors T of A⁻¹ part the stages into one real and one complex system with
/// S = s²M + sD + K at s = γ/h and s = (α + iβ)/h, tangents of the middle stage. Velocities are solved for in both,
/// with G w = -ġ; positions then alone along the real factor, with G c = what is left of -g.
class RadauStages {
 public:
  static constexpr int kMaxNewton = 12;

  RadauStages();
  /// Sizes all scratch and has the complex factor allocated, at the state evaluated last.
  void prepare(EquationsOfMotion& equations, const State& state);
  /// Start values: the last step's polynomial goes on, or constant accelerations if there is none.
  void predict(const Layout& layout, const State& start, double h);
  /// How far corrections must shrink: largest (m, rad, modal; velocities times h), or 0: a share of the tolerance.
  struct Target {
    Tolerance tolerance;
    double largest;
  };
  /// False: no convergence. The stages hold at what Newton left; `time` is the end of the step.
  bool solve(EquationsOfMotion& equations, const State& start, double time, double h, const Target& target,
             IntegratorStatistics& statistics);
  /// The step is taken: its polynomial starts the next, its complex factor may serve again.
  void accept(const State& start, double h);
  /// Solves a step that has been solved before, here or nearby, to round-off, from the accelerations and multipliers of
  /// its record. Positions are corrected along rows of the solution itself. False: no convergence.
  bool solve_again(EquationsOfMotion& equations, const State& start, double time, double h, const RadauRecord& record);
  std::shared_ptr<const RadauRecord> record() const;
  void history(Archive& archive, EquationsOfMotion& equations);

  /// Error of an embedded formula of order 3 at the step's end, in the chart and of v, damped by the real factor (IV.8,
  /// equation 8.20; 8.21 if `again`, with the result of the call before).
  void estimate(EquationsOfMotion& equations, const State& start, double h, bool again, VectorX& d_error,
                VectorX& v_error);

  // ---- the step's end: the last stage ----
  auto increment() const { return d_.col(2); }
  auto velocity() const { return v_.col(2); }
  auto acceleration() const { return v_dot_.col(2); }
  auto multipliers() const { return lambda_.col(2); }

  int iterations() const { return iterations_; }
  /// The largest ratio of a correction to the one before, in the last step solved; 0 if one iteration was enough.
  double worst_rate() const { return worst_rate_; }
  /// Whether Newton went so fast that the complex factor should be kept: the next step then had better be as long.
  bool worth_keeping() const { return rate_ <= kKeep; }
  /// Index of the velocity whose correction was the largest, or the first that was not finite.
  int worst() const;

 private:
  friend class RadauAdjoint;
  static constexpr double kKeep = 0.02;  // rate of Newton up to which the complex factor serves the next step
  using Stages = Eigen::Matrix<double, Eigen::Dynamic, 3>;

  void evaluate(EquationsOfMotion& equations, const State& start, double time, double h);
  void factorize(EquationsOfMotion& equations, const State& start, double h, bool with_complex);
  void correct(EquationsOfMotion& equations, double h);
  void advance_kinematics(const Layout& layout, double h);
  void begin_again(const Layout& layout, double h);
  bool iterate_to_round_off(EquationsOfMotion& equations, const State& start, double time, double h, bool one_factor);
  double size(double h, const Target& target) const;
  bool at_round_off(double h, double gap, double size, const Target& target) const;
  double gap(const EquationsOfMotion& equations) const;

  // The method: A, A⁻¹ = T diag(γ, [α -β; β α]) T⁻¹, times of the stages, weights of the error estimate.
  Matrix3 A_, A_inverse_, T_, T_inverse_;
  Vector3 c_, error_weights_;
  double gamma_;
  std::complex<double> alpha_;

  Stages d_, v_, v_dot_, lambda_, correction_;    // the stages; correction_: c_i
  Stages rv_, g_, g_dot_, dv_, dl_, dd_, rates_;  // residuals, corrections
  Stages last_v_, last_lambda_;                   // of the step before, v_i - v_n
  VectorX q_, x_, y_, d_size_, v_size_, pull_;
  ComplexVectorX xc_, yc_;
  double last_h_ = 0;     // length of the step before; 0: none
  double complex_h_ = 0;  // step that the complex factor was made for; 0: none worth keeping
  KeptFactor complex_factor_;
  double rate_ = 1, worst_rate_ = 0;  // of Newton, in the last step solved: last ratio of corrections, largest
  double allowance_ = 1e-3;           // rate / (1 - rate) as it is taken for the first iteration
  int iterations_ = 0;
};

}  // namespace lithe
