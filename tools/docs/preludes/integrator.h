#pragma once

#include "engine/archive/archive.h"
#include "engine/motion/integrator.h"

/// What the pages show of an integrator is part of a class derived from this.
namespace lithe::integrator {

struct Scene : Integrator {
  struct Parameters {
    double step = 1e-3;  // s
  } parameters_;
  IntegratorStatistics statistics_;
  VectorX past_;
  std::string name() const override { return ""; }
  const IntegratorStatistics& statistics() const override { return statistics_; }
  void prepare(EquationsOfMotion&, State&) override {}
  StepResult advance(EquationsOfMotion&, State&, double) override { return {}; }
  void run() {}
};

}  // namespace lithe::integrator
