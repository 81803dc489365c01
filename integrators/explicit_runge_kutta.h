#pragma once

#include <optional>

#include "engine/integrator.h"
#include "engine/projection.h"

namespace lithe {

/// Explicit Runge-Kutta of Dormand & Prince, order 5 with an error estimate of order 4 (Hairer, Nørsett & Wanner I,
/// II.5), on the index-1 form, in the chart of the step's start (Munthe-Kaas): with q = q_n ⊕ d,
///   ḋ = Jr⁻¹(d) v,   [M Gᵀ; G 0] (v̇, λ) = (f, γ).
/// Every step ends with q and v projected onto g = 0 and ġ = 0 along M⁻¹Gᵀ; its last stage is evaluated there, so it
/// gives λ at the end and begins the next step. For smooth and soft scenes: the highest frequency ω bounds the step,
/// h < 3.3/ω.
class ExplicitRungeKutta final : public Integrator {
 public:
  struct Parameters {
    double step = 0;        // s; 0: automatic, by the tolerance
    Tolerance tolerance{};  // of the automatic step
    double first_step = 0;  // s, of the automatic step; 0: guessed
    double max_step = 0;    // s; 0: none
  };

  /// Throws SceneError for a negative step or tolerance.
  explicit ExplicitRungeKutta(Parameters parameters);

  std::string name() const override { return "explicit Runge-Kutta 5(4)"; }
  const IntegratorStatistics& statistics() const override { return statistics_; }
  double current_step() const { return h_; }

 protected:
  void prepare(EquationsOfMotion& equations, State& state) override;
  StepResult advance(EquationsOfMotion& equations, State& state, double t_stop) override;

 private:
  static constexpr int kStages = 7;
  enum class Attempt { taken, no_number, off_constraints };

  double first_step(const Layout& layout, const State& state);
  double natural_step(double left) const;
  Attempt attempt(const Layout& layout, const State& start, double h, double time);
  void stage(const Layout& layout, const State& start, double h, int i);
  void accelerate(double time, int i, Projector::Factor factor = Projector::Factor::fresh);
  double error(const Layout& layout, const State& start, double h);
  std::string describe(const Layout& layout, Attempt attempt, double h) const;

  Parameters parameters_;
  IntegratorStatistics statistics_;

  double h_ = 0;                            // the step wished for
  double ratio_last_ = 0;                   // error over allowance of the last step taken
  EquationsOfMotion* equations_ = nullptr;  // those that projector_ works on
  std::optional<Projector> projector_;
  MatrixX d_dot_, v_dot_;       // a column a stage
  VectorX q_, d_, v_, lambda_;  // of the stage being computed
  VectorX d_error_, v_error_, d_size_, v_size_;
};

}  // namespace lithe
