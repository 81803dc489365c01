#pragma once

#include <functional>

#include "engine/base/math.h"
#include "integrators/runge_kutta_tableau.h"

/// Classical methods on ẏ = f(t, y), y a plain vector: for scenes in minimal coordinates, outside the engine, and for
/// what other programs do.
namespace lithe::lab {

using Rates = std::function<VectorX(double time, const VectorX& y)>;

inline VectorX euler_step(const Rates& f, double t, const VectorX& y, double h) { return y + h * f(t, y); }

/// The classical method of order 4.
inline VectorX rk4_step(const Rates& f, double t, const VectorX& y, double h) {
  const VectorX k1 = f(t, y), k2 = f(t + h / 2, y + h / 2 * k1), k3 = f(t + h / 2, y + h / 2 * k2),
                k4 = f(t + h, y + h * k3);
  return y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
}

/// Implicit midpoint by functional iteration, which converges where h times the rates' slopes is below 2.
VectorX midpoint_step(const Rates& f, double t, const VectorX& y, double h);

/// How an adaptive run went.
struct AdaptiveRun {
  VectorX y;
  long evaluations = 0;
  double smallest_step = INFINITY;  // s
  bool reached = false;             // false: the step fell below the spacing of numbers, or the evaluations ran out
};

/// An explicit pair as scipy.integrate.solve_ivp steps it (SciPy 1.x: RK45, DOP853): first step after Hairer, Nørsett &
/// Wanner II.4, safety 0.9, factors of 0.2 to 10, no growth after a rejection, root mean square over the components.
AdaptiveRun run_as_scipy(const RungeKuttaTableau& tableau, const Rates& f, double begin, double end, VectorX y,
                         double relative, double absolute, long max_evaluations = 10'000'000);

}  // namespace lithe::lab
