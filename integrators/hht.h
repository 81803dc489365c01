#pragma once

#include "engine/archive/archive.h"
#include "integrators/generalized_alpha.h"

namespace lithe {

/// HHT-I3, the method of Hilber, Hughes & Taylor on index 3 (Negrut, Rampalli, Ottarsson & Sajdak 2007), known by that
/// name in commercial codes: Newmark with γ = ½ - α, β = (1 - α)²/4 on the increments of the group, and
///   1/(1 + α) M a' + (Gᵀ λ - f)' - α/(1 + α) (Gᵀ λ - f) = 0,   g(q') = 0.
/// Second order; α = -1/3 damps most (spectral radius ½ at infinite frequency), α = 0 is the trapezoidal rule, whose
/// multipliers oscillate and grow. Here the force at the step's start is carried as M' v̇, which is the same while M
/// is constant; if it is not (flexible bodies), an unrotated force would cost an order. So it is the member
/// am = 0, af = -α of the generalized-alpha family and shares its treatment of starts and of changed steps
/// (stability laboratory S30).
class Hht final : public Integrator {
 public:
  struct Parameters {
    double step = 0;       // s; 0: automatic, by the tolerance
    double alpha = -0.05;  // -1/3 to 0
    Tolerance tolerance{};
    double first_step = 0;        // s, of the automatic step; 0: guessed
    double max_step = 0;          // s; 0: none
    double newton_tolerance = 0;  // largest last correction (m, rad, modal); 0: 1e-9, or by the tolerance if automatic
  };

  /// Throws SceneError for an alpha outside [-1/3, 0] or a negative step or tolerance.
  explicit Hht(Parameters parameters);

  std::string name() const override { return "HHT-I3"; }
  const IntegratorStatistics& statistics() const override { return method_.statistics(); }
  double current_step() const { return method_.current_step(); }
  bool approximates_accelerations() const override { return method_.approximates_accelerations(); }

 protected:
  void prepare(EquationsOfMotion& equations, State& state) override { method_.start(equations, state); }
  StepResult advance(EquationsOfMotion& equations, State& state, double t_stop) override {
    return method_.step(equations, state, t_stop);
  }
  bool keep(Archive& archive, EquationsOfMotion& equations, const State& state) override {
    bool kept = false;
    archive.group("alpha", [&] { kept = method_.history(archive, equations, state); });
    return kept;
  }

 private:
  GeneralizedAlpha method_;
};

}  // namespace lithe
