#pragma once

#include <memory>
#include <string>

#include "engine/motion/integrator.h"

/// The integrators that scenes are run with, one line each.
namespace lithe::test {

using Method = std::unique_ptr<Integrator>;

Method runge_kutta(double tolerance);
Method runge_kutta_fixed(double step);
Method runge_kutta8(double tolerance);
Method runge_kutta8_fixed(double step);
Method adams(double tolerance);
Method automatic(double tolerance);
Method ida(double tolerance);
Method index3(double step, double spectral_radius = 0.9);
Method index2(double step, double spectral_radius = 0.9);
Method rattle(double step);
Method radau(double tolerance);
Method radau_fixed(double step);
Method bdf(double tolerance, int max_order = 5);
Method bdf_fixed(double step, int order);
Method hht(double step, double alpha = -0.1);
Method linearly_implicit(double step, int order = 1);
Method energy_momentum(double step);

/// A measured figure and the bound it has to keep; LITHE_PRINT=1 shows all of them.
void expect_below(const std::string& what, double measured, double bound);

}  // namespace lithe::test
