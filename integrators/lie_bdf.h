#pragma once

#include <memory>

#include "engine/motion/integrator.h"
#include "engine/motion/kept_factor.h"
#include "engine/motion/step_derivative.h"
#include "integrators/bdf_history.h"

namespace lithe {

/// What a step was taken from: the newest points of the past, in the chart of the state at base_time.
struct BdfRecord final : StepRecord {
  struct Step {
    State to;  // of several steps; else left empty
    double base_time;
    VectorX d;                  // of the step's end
    std::vector<double> times;  // of the points, newest first
    MatrixX past_d;             // a column each
  };
  std::vector<Step> steps;  // several: the first of fixed steps are made of those of the automatic method
  double oldest;            // s: no later step takes an earlier state
  std::size_t bytes() const override;
};

/// BDF of variable order and step on the Lie group, in the stabilized index-2 form (Gear, Gupta & Leimkuhler 1985; on
/// groups: Wieloch & Arnold 2021, here in a chart of the past, which needs no commutators). With q = base ⊕ d and p'
/// the derivative at the step's end of the polynomial through it and the last k points, as they lie in time,
///   Jr⁻¹(d) v = p_d' + ζ,   M p_v' + Gᵀ λ = f,   g = 0,   G v + ∂g/∂t = 0,
/// with ζ along S⁻¹Gᵀ for the tangent S of the step. Newton by the structured factor of the engine, kept over steps
/// while it converges well; where it does not, made anew each step. Order and step by the error that the predictor
/// shows (Brenan, Campbell & Petzold 1996, 5.2); multipliers are not tested. For stiff scenes with damping, at
/// tolerances of 1e-4 and finer; orders above 2 are not A-stable: where stiff modes go undamped, 2 is the better
/// max_order.
/// A step is kept so short that bodies turn less than some two radians over the polynomial's points.
class LieBdf final : public Integrator, public DifferentiableSteps {
 public:
  struct Parameters {
    double step = 0;  // s; 0: automatic. Fixed steps are of max_order, on a start made automatically by the tolerance
    Tolerance tolerance{};
    double first_step = 0;           // s, of the automatic step; 0: guessed
    double max_step = 0;             // s; 0: none
    int max_order = 5;               // 1 to 5
    double newton_tolerance = 0.02;  // of what a step may err by
  };

  /// Throws SceneError for a negative step or tolerance, or an order that there is not.
  explicit LieBdf(Parameters parameters);

  std::string name() const override { return "Lie-group BDF, stabilized index 2"; }
  const IntegratorStatistics& statistics() const override { return statistics_; }
  bool approximates_accelerations() const override { return true; }
  double current_step() const { return h_; }
  int current_order() const { return order_; }
  std::unique_ptr<StepDerivative> step_derivative() const override;
  std::shared_ptr<const StepRecord> step_record() const override;

 protected:
  void prepare(EquationsOfMotion& equations, State& state) override;
  StepResult advance(EquationsOfMotion& equations, State& state, double t_stop) override;
  bool keep(Archive& archive, EquationsOfMotion& equations, const State& state) override;
  bool chooses_steps() const override { return automatic(); }
  void lose_factor() override { factor_weight_ = 0; }

 private:
  friend class LieBdfDerivative;
  enum class Newton { converged, slow, no_number };
  static constexpr double kLargestTurn = 2.2;  // rad, of a body over the points of a polynomial

  /// The largest rotation of a body in velocities, rad/s, or in an increment, rad.
  static double fastest_turning(const Layout& layout, ConstVectorRef of);
  bool automatic() const { return parameters_.step == 0; }
  double first_step(EquationsOfMotion& equations, const State& state);
  void begin(const Layout& layout, const State& state);
  double natural_step(double left) const;
  StepResult start_step(EquationsOfMotion& equations, State& state, double t_stop);
  void fit_history(const Layout& layout, double h);
  void predict(const Layout& layout, double time);
  void derive_velocities(const Layout& layout);
  Newton solve(EquationsOfMotion& equations, const State& start, double time);
  Newton iterate(EquationsOfMotion& equations, const State& start, double time, bool fresh);
  double error(double time, int order);
  void accept(State& state, double time);
  void plan(const Layout& layout, double time, double h, double ratio);
  void shrink(const Layout& layout, double ratio, double time, double& h, int failures);
  std::string describe(const Layout& layout, Newton newton, double h) const;
  BdfRecord::Step last_step() const;

  Parameters parameters_;
  IntegratorStatistics statistics_;
  std::unique_ptr<LieBdf> starter_;  // of fixed steps

  double h_ = 0;              // the step wished for
  int order_ = 1;             // of the next step
  int steps_at_order_ = 0;    // since it changed
  bool raising_ = true;       // at the start, order and step grow from step to step
  bool failed_ = false;       // a step, since order and length were last weighed
  double factor_weight_ = 0;  // w_0 of the factor at hand; 0: none
  KeptFactor factor_;
  double convergence_rate_ = 0.5;  // of Newton with it
  double fresh_rate_ = 0.5;        // of Newton with factors made where they are used, as measured last
  int made_anew_ = 0;              // steps for which a factor of another step is not tried
  int useless_ = 0;                // times that one was, one after the other

  // Of the step taken last, for its derivative.
  double begun_ = 0;                      // s, where the past begins
  int last_order_ = 0;                    // 0: none taken
  std::vector<BdfRecord::Step> started_;  // the automatic method's within a fixed step; else none

  BdfHistory history_;
  BdfHistory::Weights weights_{}, error_weights_{};
  VectorX q_, d_, v_, v_dot_, lambda_;  // of the step being taken
  VectorX past_d_rate_, past_v_rate_;   // p' less w_0 times the new point
  VectorX shift_;                       // ζ / w_0, moves positions onto g = 0
  VectorX rate_, increment_, rv_, correction_, rl_, rl2_;
  VectorX d_error_, v_error_, d_size_, v_size_;
};

}  // namespace lithe
