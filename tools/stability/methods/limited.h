#pragma once

#include <memory>

#include "engine/motion/integrator.h"
#include "engine/study/study_run.h"

namespace lithe::lab {

/// Another integrator that fails once the thread has used so much CPU time, and says so in `expired`.
class Limited final : public Integrator {
 public:
  /// Up to `end` of thread_seconds().
  Limited(std::unique_ptr<Integrator> inner, double end, bool& expired)
      : inner_(std::move(inner)), end_(end), expired_(expired) {}

  std::string name() const override { return inner_->name(); }
  const IntegratorStatistics& statistics() const override { return inner_->statistics(); }
  bool handles_rigid_contacts() const override { return inner_->handles_rigid_contacts(); }
  bool approximates_accelerations() const override { return inner_->approximates_accelerations(); }
  bool follows_equations() const override { return inner_->follows_equations(); }
  void interpolate(const Layout& layout, const State& from, const State& to, double time, State& out) const override {
    inner_->interpolate(layout, from, to, time, out);
  }

 protected:
  void prepare(EquationsOfMotion& equations, State& state) override { inner_->start(equations, state); }
  StepResult advance(EquationsOfMotion& equations, State& state, double t_stop) override {
    if (thread_seconds() < end_) return inner_->step(equations, state, t_stop, multipliers());
    expired_ = true;
    return {StepResult::Outcome::failed, "its time is up"};
  }
  bool delegates() const override { return true; }

 private:
  std::unique_ptr<Integrator> inner_;
  double end_;  // s
  bool& expired_;
};

}  // namespace lithe::lab
