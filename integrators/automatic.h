#pragma once

#include <array>
#include <memory>
#include <vector>

#include "engine/motion/integrator.h"

namespace lithe {

class ExplicitRungeKutta;
class LieBdf;
class Radau;

/// The default: needs no option but a tolerance. It switches between three methods:
///   explicit Runge-Kutta 8(5,3)   while the scene is not stiff;
///   Lie-group BDF                 stiff and damped;
///   Radau IIA of order 5          stiff at tight tolerances, or with undamped stiff modes.
/// It begins with the first. From time to time, and early if stability limits the step (the estimate of h |λ| stays
/// near the limit), the others are tried for a few steps each; the one that advances furthest in time for the same work
/// is used, and the next trials come after twice as many steps. Work is counted (evaluations, Newton iterations,
/// factorisations), not measured, so that runs repeat bit for bit. Each method runs at a tolerance that makes its error
/// similar to that of the others. If one fails, the next is tried. After LSODA (Petzold 1983), which compares the steps
/// that Adams and BDF would take.
class Automatic final : public Integrator {
 public:
  struct Parameters {
    /// Of the motion, not of a step: steps are controlled more tightly, so that over some ten periods of a motion that
    /// does not amplify errors the error stays within it.
    Tolerance tolerance{};
    double first_step = 0;  // s; 0: guessed
    double max_step = 0;    // s; 0: none
  };
  enum class Method { explicit_runge_kutta, lie_bdf, radau };

  /// Throws SceneError for a negative step or tolerance.
  explicit Automatic(Parameters parameters);
  Automatic() : Automatic(Parameters{}) {}
  ~Automatic() override;

  std::string name() const override { return "automatic"; }
  const IntegratorStatistics& statistics() const override { return statistics_; }
  bool approximates_accelerations() const override { return at_work().approximates_accelerations(); }
  Method method() const { return method_; }
  /// Number of changes to another method that were kept, since start().
  int switches() const { return switches_; }

  void interpolate(const Layout& layout, const State& from, const State& to, double time, State& out) const override;

 protected:
  void prepare(EquationsOfMotion& equations, State& state) override;
  StepResult advance(EquationsOfMotion& equations, State& state, double t_stop) override;
  bool keep(Archive& archive, EquationsOfMotion& equations, const State& state) override;
  bool delegates() const override { return true; }

 private:
  static constexpr int kMethods = 3;
  static int place(Method method) { return static_cast<int>(method); }
  Integrator& at_work() const;
  double current_step() const;
  double work() const;
  void change(Method method, EquationsOfMotion& equations, State& state);
  bool is_held_by_stability();
  void watch(EquationsOfMotion& equations, State& state);
  void settle(EquationsOfMotion& equations, State& state);

  Parameters parameters_;
  std::unique_ptr<ExplicitRungeKutta> explicit_;
  std::unique_ptr<LieBdf> bdf_;
  std::unique_ptr<Radau> radau_;
  IntegratorStatistics statistics_, before_;  // all; of methods put aside

  Method method_ = Method::explicit_runge_kutta;     // at work
  Method incumbent_ = Method::explicit_runge_kutta;  // that the trials are against
  int switches_ = 0;
  double explicit_work_ = 1;                // of an evaluation by the explicit method
  double begun_with_ = 0;                   // s, first step that the method at work was made with; 0: guessed
  bool fresh_ = true;                       // it has not made a step yet
  int steps_ = 0;                           // since it came to work
  int held_steps_ = 0, calm_steps_ = 0;     // in a row, of the explicit method
  std::vector<Method> to_try_;              // of the trials under way; their last is at work
  std::array<double, kMethods> step_{};     // s, that each went last
  std::array<double, kMethods> pace_{};     // s a unit of work, when each was seen last
  std::array<int, kMethods> wait_{};        // steps before the next trials
  double block_time_ = 0, block_work_ = 0;  // where the steps began that the pace is measured over
};

}  // namespace lithe
