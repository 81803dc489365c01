#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>

#include "engine/assembly/evaluator.h"
#include "engine/model/system_graph.h"
#include "engine/motion/integrator.h"

namespace lithe::lab {

/// A scene ready to be run once: graph, system, equations, state. Stays where it is made.
class Bench {
 public:
  template <class Draw>
  Bench(const Vector3& gravity, Draw&& draw, const AssembleOptions& options = {})
      : graph({.gravity = gravity}), system((draw(graph), assemble(graph, options))) {}
  Bench(const Bench&) = delete;

  double energy() {
    equations.evaluate(state.time, state.q, state.v, Level::velocity);
    return equations.energy().total();
  }
  /// Largest |g|, or |ġ| at Level::velocity.
  double violation(Level level) {
    VectorX out(system.layout().row_count());
    equations.evaluate(state.time, state.q, state.v, Level::velocity);
    equations.constraint(level, out);
    return out.size() > 0 ? out.cwiseAbs().maxCoeff() : 0;
  }

  /// How a run went.
  struct Course {
    bool reached = false;
    std::string why{};  // of the integrator, or "energy beyond bounds"
    double end = 0;     // s: where it stopped
    long steps = 0;
    double smallest_step = INFINITY;  // s
    double energy_error = 0;          // J, largest |E - E₀|, as it began
    double residual = 0;              // largest |g|
  };
  /// Starts the integrator and runs to `end` (s). `after` is told of every step. Stops early, not reached, where the
  /// energy error passes `energy_limit` (J) or what comes out is not finite.
  Course run(Integrator& integrator, double end, const std::function<void()>& after = {},
             double energy_limit = INFINITY) {
    integrator.start(equations, state);
    return go_on(integrator, end, after, energy_limit);
  }
  Course go_on(Integrator& integrator, double end, const std::function<void()>& after = {},
               double energy_limit = INFINITY) {
    Course course;
    const double start = energy();
    while (state.time < end) {
      const double before = state.time;
      const StepResult result = integrator.step(equations, state, end);
      course.end = state.time;
      if (!result.ok()) {
        course.why = result.why;
        return course;
      }
      ++course.steps;
      course.smallest_step = std::min(course.smallest_step, state.time - before);
      // One evaluation serves both figures.
      course.energy_error = larger(course.energy_error, std::abs(energy() - start));
      residual_.resize(system.layout().row_count());
      equations.constraint(Level::position, residual_);
      if (residual_.size() > 0) course.residual = larger(course.residual, residual_.cwiseAbs().maxCoeff());
      if (after) after();
      if (!(course.energy_error <= energy_limit) || !state.q.allFinite() || !state.v.allFinite()) {
        course.why = "energy beyond bounds";
        return course;
      }
    }
    course.reached = true;
    return course;
  }

  SystemGraph graph;
  System system;
  Evaluator equations{system};
  State state = system.initial_state();

 private:
  /// What is not finite is larger than all.
  static double larger(double a, double b) { return std::isnan(a) || std::isnan(b) ? NAN : std::max(a, b); }

  VectorX residual_;
};

}  // namespace lithe::lab
