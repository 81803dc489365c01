#pragma once

#include <memory>

#include "engine/motion/integrator.h"

namespace lithe::lab {

/// Another integrator, made to take steps of h and h/2 in turn by its stops.
class Alternating final : public Integrator {
 public:
  Alternating(std::unique_ptr<Integrator> inner, double step) : inner_(std::move(inner)), step_(step) {}

  std::string name() const override { return inner_->name() + ", steps h, h/2"; }
  const IntegratorStatistics& statistics() const override { return inner_->statistics(); }

 protected:
  void prepare(EquationsOfMotion& equations, State& state) override {
    taken_ = 0;
    inner_->start(equations, state);
  }
  StepResult advance(EquationsOfMotion& equations, State& state, double t_stop) override {
    const double h = taken_ % 2 == 0 ? step_ : step_ / 2;
    const double stop = state.time + h > t_stop - 1e-9 * h ? t_stop : state.time + h;
    const StepResult result = inner_->step(equations, state, stop);
    if (state.time == stop) ++taken_;
    return result;
  }

 private:
  std::unique_ptr<Integrator> inner_;
  double step_;  // s
  long taken_ = 0;
};

}  // namespace lithe::lab
