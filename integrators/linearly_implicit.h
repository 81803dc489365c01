#pragma once

#include "engine/motion/integrator.h"

namespace lithe {

/// For real time (hardware in the loop): linearly implicit Euler in the stabilized index-2 form, no iteration, the same
/// work every step. One Newton iteration of the implicit Euler method, from q* = q ⊕ h v and v, with S = M + h D + h² K
/// there:
///   [S Gᵀ; G 0] (v̇, λ' - λ) = (f - Gᵀ λ, -ġ/h),   v' = v + h v̇,   q' = q* ⊕ h² v̇
/// and, along the same factor, a second solve that moves q' onto g = 0: |g| stays of order h⁴, without drift. Stable
/// for stiff springs, dampers and modes at any h, and first order. It damps: a motion of frequency ω loses amplitude
/// like a damping ratio of h ω/2. Order 2 extrapolates a step of h and two of h/2 (Richardson, in the chart of q) and
/// projects their ends: a damping ratio of (h ω)³/4, three factors and five evaluations a step. What one iteration
/// leaves of a curved motion meets the stiffness: a spring of stiffness k and length l errs by a force k h⁴ v̇²/(2 l),
/// where a constraint would not. What is so stiff is better a constraint; order 2 falls to 1 there, with a tenth of the
/// error. A step fails only by values that are not finite.
class LinearlyImplicit final : public Integrator {
 public:
  struct Parameters {
    double step = 0;  // s; must be given
    int order = 1;    // 1 or 2
  };

  /// Throws SceneError for a step that is not positive, or an order that there is not.
  explicit LinearlyImplicit(Parameters parameters);

  std::string name() const override;
  const IntegratorStatistics& statistics() const override { return statistics_; }

 protected:
  void prepare(EquationsOfMotion& equations, State& state) override;
  StepResult advance(EquationsOfMotion& equations, State& state, double t_stop) override;
  bool keep(Archive& archive, EquationsOfMotion& equations, const State& state) override;

 private:
  struct Point {
    VectorX q, v, v_dot, lambda;
  };
  void euler(EquationsOfMotion& equations, double time, double h, const Point& from, Point& to);
  void project(EquationsOfMotion& equations, double time, Point& at);

  Parameters parameters_;
  IntegratorStatistics statistics_;
  Point start_, half_, end_, whole_;
  VectorX d_, turned_, rv_, rl_, rl2_;
  int broken_ = -1;  // first equation that gave no finite value in this step
};

}  // namespace lithe
