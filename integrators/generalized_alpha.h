#pragma once

#include <optional>

#include "engine/motion/integrator.h"
#include "engine/motion/projection.h"
#include "engine/motion/step_derivative.h"

namespace lithe {

/// Of a step whose length differs from that of the step before: what the method carried until then.
struct AlphaRecord final : StepRecord {
  VectorX a;        // acceleration-like state
  double h_offset;  // s, the step that its offset from v̇ belongs to

  std::size_t bytes() const override {
    return sizeof(AlphaRecord) + sizeof(double) * static_cast<std::size_t>(a.size());
  }
};

/// Lie-group generalized-alpha for constrained mechanical systems (Chung & Hulbert 1993; Arnold, Brüls & Cardona 2007,
/// 2012; docs/equations.md 8.1, 8.2). Second order, unconditionally stable, damps modes by the spectral radius.
///   (1 - am) a' + am a = (1 - af) v̇' + af v̇
///   d = h v + h² ((½ - β) a + β a'),   q' = q ⊕ d,   v' = v + h ((1 - γ) a + γ a')
/// Two forms: index 3 solves g(q') = 0; stabilized index 2 (Gear, Gupta & Leimkuhler 1985) solves g(q') = 0 and
/// G v' + ∂g/∂t = 0, at the price of a second back-substitution: multipliers without start transient, |G v| to
/// round-off.
class GeneralizedAlpha : public Integrator, public DifferentiableSteps {
 public:
  enum class Form { index3, stabilized_index2 };
  struct Parameters {
    double step = 0;               // s; 0: automatic, by the tolerance
    double spectral_radius = 0.8;  // at infinite frequency, 0 <= rho < 1
    Form form = Form::index3;
    Tolerance tolerance{};        // of the automatic step
    double first_step = 0;        // s, of the automatic step; 0: guessed
    double max_step = 0;          // s; 0: none
    double newton_tolerance = 0;  // largest last correction (m, rad, modal); 0: 1e-9, or by the tolerance if automatic
    bool correct_start = true;    // index 3: start values without transient of the multipliers
  };

  /// Members of the family that are not given by a spectral radius (Hht).
  struct Coefficients {
    double am, af;
  };

  /// Throws SceneError for a spectral radius outside [0, 1) or a negative step or tolerance.
  explicit GeneralizedAlpha(Parameters parameters);
  GeneralizedAlpha(Parameters parameters, Coefficients coefficients);

  std::string name() const override;
  const IntegratorStatistics& statistics() const override { return statistics_; }
  bool approximates_accelerations() const override { return true; }  // as well as Newton has solved, times 1/h²
  double current_step() const { return h_; }
  /// Of fixed steps, index 3.
  std::unique_ptr<StepDerivative> step_derivative() const override;
  std::shared_ptr<const StepRecord> step_record() const override;
  std::unique_ptr<RepeatedStep> repeated_step(EquationsOfMotion& equations) const override;

 protected:
  void prepare(EquationsOfMotion& equations, State& state) override;
  StepResult advance(EquationsOfMotion& equations, State& state, double t_stop) override;
  bool keep(Archive& archive, EquationsOfMotion& equations, const State& state) override;
  bool chooses_steps() const override { return parameters_.step == 0; }
  /// Consistent accelerations and a history that begins here; like prepare(), but keeps the statistics. `drift`: that
  /// of the motion which goes on, null where nothing is known of it.
  void restart(EquationsOfMotion& equations, State& state, const VectorX* drift = nullptr);
  /// How far the acceleration-like state is from v̇, for each second of step: (am - af) v̈ on smooth motion.
  void drift(const State& state, VectorX& of) const { of = (a_ - state.v_dot) / h_offset_; }
  const Parameters& parameters() const { return parameters_; }
  double beta() const { return beta_; }
  double gamma() const { return gamma_; }

 private:
  friend class GeneralizedAlphaDerivative;
  friend class RepeatedAlpha;
  enum class Newton { converged, slow, failed };
  void begin(EquationsOfMotion& equations, State& state, double h);
  double first_step(const State& state) const;
  double natural_step(const State& state, double t_stop) const;
  void change_step(EquationsOfMotion& equations, State& state, double h);
  void shift_velocity(EquationsOfMotion& equations, State& state, double h_squared);
  void predict(EquationsOfMotion& equations, const State& state, double h, bool steady);
  Newton take(EquationsOfMotion& equations, const State& state, double time, double h);
  double correct(EquationsOfMotion& equations, const VectorX& q_start, double of_v, double of_v_dot);
  double correct(const Layout& layout, int first, int last, const VectorX& q_start, double of_v, double of_v_dot);
  void take_over(EquationsOfMotion& equations, const State& state);
  Newton solve(EquationsOfMotion& equations, const State& start, double time, double h);
  double error(const Layout& layout, const State& start, double h);

  Parameters parameters_;
  double am_, af_, gamma_, beta_;
  IntegratorStatistics statistics_;

  double h_ = 0;                        // the step wished for
  double h_offset_ = 0;                 // the step that a_ and the offset of v from ġ = 0 belong to
  double h_last_ = 0;                   // length of the step before
  bool has_last_ = false;               // v_dot_last_ holds its start
  bool corrected_ = false;              // begin() has seen the jerk
  int steady_left_ = 0;                 // steps that begin with a steady prediction
  VectorX a_;                           // acceleration-like state
  VectorX a_before_;                    // the same, and its h_offset_, before a step of another length
  double offset_before_ = 0;            // 0: the last step was as long as the one before
  VectorX q_, v_, v_dot_, lambda_, d_;  // of the step being taken
  std::optional<Projector> projector_;
  VectorX v_dot_last_, jerk_, delta_, change_, rl_, rl2_, rv_, magnitudes_;
};

}  // namespace lithe
