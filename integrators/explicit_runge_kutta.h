#pragma once

#include <memory>
#include <string>

#include "engine/motion/integrator.h"
#include "engine/motion/step_derivative.h"
#include "integrators/runge_kutta_step.h"

namespace lithe {

/// Explicit Runge-Kutta of Dormand & Prince, order 5 with an error estimate of order 4, or order 8 with estimates of
/// orders 5 and 3 (DOP853; Hairer, Nørsett & Wanner I, II.5), on the index-1 form, in the chart of the step's start
/// (Munthe-Kaas): with q = q_n ⊕ d,
///   ḋ = Jr⁻¹(d) v,   [M Gᵀ; G 0] (v̇, λ) = (f, γ).
/// Every step ends with q and v projected onto g = 0 and ġ = 0 along M⁻¹Gᵀ; its last stage is evaluated there, so it
/// gives λ at the end and begins the next step. For smooth and soft scenes: the highest frequency ω bounds the step,
/// h |λ| < stability_limit().
class ExplicitRungeKutta final : public Integrator, public DifferentiableSteps {
 public:
  enum class Method { dormand_prince5, dormand_prince8 };
  struct Parameters {
    Method method = Method::dormand_prince5;
    double step = 0;        // s; 0: automatic, by the tolerance
    Tolerance tolerance{};  // of the automatic step
    double first_step = 0;  // s, of the automatic step; 0: guessed
    double max_step = 0;    // s; 0: none
  };

  /// Throws SceneError for a negative step or tolerance.
  explicit ExplicitRungeKutta(Parameters parameters);

  std::string name() const override;
  const IntegratorStatistics& statistics() const override { return statistics_; }
  double current_step() const { return h_; }
  std::unique_ptr<RepeatedStep> repeated_step(EquationsOfMotion& equations) const override;
  std::unique_ptr<StepAdjoint> step_adjoint() const override;

  /// Estimate of h |λ| of the fastest motion within the last step taken, from its last two stages (Hairer & Wanner II,
  /// IV.2); 0 if they give none. The scene is stiff for this method if the value stays near stability_limit().
  double stiffness() const { return stiffness_; }
  double stability_limit() const { return tableau_->stability_limit; }

  /// Order 8: its own polynomial of degree 7 (q, v), λ of degree 4; the first call after a step evaluates three more
  /// stages, counted with the next step.
  void interpolate(const Layout& layout, const State& from, const State& to, double time, State& out) const override;

 protected:
  void prepare(EquationsOfMotion& equations, State& state) override;
  StepResult advance(EquationsOfMotion& equations, State& state, double t_stop) override;
  bool keep(Archive& archive, EquationsOfMotion& equations, const State& state) override;
  bool chooses_steps() const override { return parameters_.step == 0; }

 private:
  double natural_step(double left) const;
  double next_step(double h, double ratio, int tries) const;
  std::string describe(const Layout& layout, RungeKuttaStep::Outcome outcome, double h) const;

  Parameters parameters_;
  const RungeKuttaTableau* tableau_;
  IntegratorStatistics statistics_;

  double h_ = 0;           // step proposed by the error control
  double ratio_last_ = 0;  // error over allowance of the last step taken
  double stiffness_ = 0;
  std::unique_ptr<RungeKuttaStep> step_;  // of the equations met last; its scratch serves interpolate() too
};

}  // namespace lithe
