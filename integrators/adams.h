#pragma once

#include <memory>
#include <string>

#include "engine/motion/integrator.h"

namespace lithe {

/// Variable-order, variable-step Adams-Moulton method of SUNDIALS (CVODE; Hindmarsh et al. 2005) with functional
/// iteration, on the index-1 form behind projection (Eich 1993; docs/equations.md 8.3):
///   ẏ = f(t, P(y)),   y = (q, v) with quaternions as four plain numbers e, ė = ½ e ∘ (0, ω).
/// P makes e/|e| and moves q and v onto g = 0 and ġ = 0 along M⁻¹Gᵀ. The drift of y off the constraints in a step is
/// removed at its end, which does not disturb the multistep method: its history consists of rates. So drift neither
/// feeds back nor grows. One factorisation per evaluation, hardly more than one evaluation per step: the choice for
/// smooth scenes that are expensive to evaluate. In stiff scenes the iteration diverges and the step collapses.
class Adams final : public Integrator {
 public:
  struct Parameters {
    Tolerance tolerance{};
    double first_step = 0;  // s; 0: guessed
    double max_step = 0;    // s; 0: none
    int max_order = 12;     // 1 to 12
  };

  /// Throws SceneError for a negative step or tolerance, or an order that there is not.
  explicit Adams(Parameters parameters);
  ~Adams() override;

  std::string name() const override { return "SUNDIALS CVODE, Adams"; }
  const IntegratorStatistics& statistics() const override { return statistics_; }
  bool approximates_accelerations() const override { return true; }

  /// q, v and v̇ by CVODE's own polynomial of the order in use, λ linear.
  void interpolate(const Layout& layout, const State& from, const State& to, double time, State& out) const override;

 protected:
  /// Also moves the state onto the constraints.
  void prepare(EquationsOfMotion& equations, State& state) override;
  StepResult advance(EquationsOfMotion& equations, State& state, double t_stop) override;
  bool keep(Archive& archive, EquationsOfMotion& equations, const State& state) override;

 private:
  struct Memory;  // all that SUNDIALS owns
  StepResult failed(int flag);
  void count();

  Parameters parameters_;
  IntegratorStatistics statistics_;
  std::unique_ptr<Memory> memory_;
};

}  // namespace lithe
