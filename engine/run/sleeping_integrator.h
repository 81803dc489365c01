#pragma once

#include <memory>

#include "engine/motion/integrator.h"

namespace lithe {

/// An integrator that sleeps while its scene rests: it moves time alone, evaluates nothing, and leaves q and v as they
/// are, bit for bit. For scenes in which nothing depends on time (depends_on_time(), engine/model/islands.h): there v =
/// 0 and v_dot = 0 last for ever, so that only a changed state can wake it, by start().
///
/// At rest is what v = 0 exactly and one implicit step of a length h that outlasts the sleep,
///   (M/h² + D/h + K) δ + Gᵀ y = f,   G δ = -g,
/// moves by no more than round-off: of the size 1e-10 |x| + 1e-11. The matrix tells noise in stiff springs, whose
/// accelerations may be large, from a slow fall; h grows as the sleep goes on: a push that short times hide in
/// round-off is felt late. A body balanced on its tip as drawn keeps its balance.
class SleepingIntegrator final : public Integrator {
 public:
  explicit SleepingIntegrator(std::unique_ptr<Integrator> method) : method_(std::move(method)) {}

  bool asleep() const { return asleep_; }
  /// Asleep, until then it need not be asked: nothing but the time would change.
  bool sleeps_until(double time) const { return asleep_ && time <= until_; }
  std::string name() const override { return method_->name(); }
  /// Of the method; zero while it has slept since start().
  const IntegratorStatistics& statistics() const override { return asleep_ ? none_ : method_->statistics(); }
  bool approximates_accelerations() const override { return !asleep_ && method_->approximates_accelerations(); }
  bool follows_equations() const override { return !asleep_ && method_->follows_equations(); }
  void interpolate(const Layout& layout, const State& from, const State& to, double time, State& out) const override;

 protected:
  void prepare(EquationsOfMotion& equations, State& state) override;
  StepResult advance(EquationsOfMotion& equations, State& state, double t_stop) override;
  bool keep(Archive& archive, EquationsOfMotion& equations, const State& state) override;
  bool delegates() const override { return true; }

 private:
  void doze(EquationsOfMotion& equations, State& state, double length);

  std::unique_ptr<Integrator> method_;
  bool asleep_ = false;
  double since_ = 0, until_ = 0;  // s: asleep, and sure of its rest
  const IntegratorStatistics none_{};
};

}  // namespace lithe
