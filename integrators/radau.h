#pragma once

#include <optional>

#include "engine/motion/integrator.h"
#include "engine/motion/projection.h"
#include "engine/motion/step_derivative.h"
#include "integrators/radau_stages.h"

namespace lithe {

/// Radau IIA with three stages, order 5, L-stable (Hairer & Wanner II, IV.8: RADAU5), on the stabilized index-2 form
/// and the Lie group (radau_stages.h). For stiff and damped scenes at any accuracy: the step follows the motion, not
/// the highest frequency; what it leaves unresolved it damps.
///
/// A step costs three evaluations an iteration of Newton, one real and one complex block factorisation. It ends with
/// consistent accelerations, which bring v̇ and λ from the stages' order 3 to order 5 for one mass factorisation more;
/// with them the common dense output is of order 5 too, against 3 of the collocation polynomial.
class Radau final : public Integrator, public DifferentiableSteps {
 public:
  struct Parameters {
    double step = 0;  // s; 0: automatic, by the tolerance
    /// Of the automatic step. The estimate is of order 3, the result of order 5: the estimate is held below the
    /// tolerance to the power 2/3, times 0.1, so that the error of the result goes with the tolerance (RADAU5).
    Tolerance tolerance{};
    double first_step = 0;        // s, of the automatic step; 0: guessed
    double max_step = 0;          // s; 0: none
    double newton_tolerance = 0;  // largest last correction (m, rad, modal; velocities times the step);
                                  // 0: 1e-9, or 0.003 of the tolerance if automatic
  };

  /// Throws SceneError for a negative step or tolerance.
  explicit Radau(Parameters parameters);

  std::string name() const override { return "Radau IIA, order 5"; }
  const IntegratorStatistics& statistics() const override { return statistics_; }
  double current_step() const { return h_; }
  std::unique_ptr<RepeatedStep> repeated_step(EquationsOfMotion& equations) const override;
  std::unique_ptr<StepAdjoint> step_adjoint() const override;
  std::shared_ptr<const StepRecord> step_record() const override { return stages_.record(); }

 protected:
  void prepare(EquationsOfMotion& equations, State& state) override;
  StepResult advance(EquationsOfMotion& equations, State& state, double t_stop) override;
  bool keep(Archive& archive, EquationsOfMotion& equations, const State& state) override;
  bool chooses_steps() const override { return parameters_.step == 0; }

 private:
  double first_step(const Layout& layout, const State& state);
  double natural_step(double left) const;
  double error(EquationsOfMotion& equations, const State& start, double h, bool filter);
  void finish(EquationsOfMotion& equations, State& state, double time);
  double next_step(double h, double ratio, bool repeated);
  std::string describe(const Layout& layout, bool converged, double h) const;

  Parameters parameters_;
  Tolerance estimate_;  // what the error estimate is held to
  RadauStages stages_;
  IntegratorStatistics statistics_;
  EquationsOfMotion* equations_ = nullptr;  // those that projector_ works on
  std::optional<Projector> projector_;

  double h_ = 0;                                // the step wished for
  double h_accepted_ = 0, ratio_accepted_ = 0;  // of the last step taken; 0: none
  VectorX q_, v_, v_dot_, lambda_, d_error_, v_error_, d_size_, v_size_;
};

}  // namespace lithe
