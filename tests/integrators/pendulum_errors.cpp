#include "tests/integrators/pendulum_errors.h"

#include <algorithm>
#include <cmath>

namespace lithe::test {

double pendulum_angle(double t) {
  constexpr double k = M_SQRT1_2;
  double a[8] = {1}, c[8] = {k}, b = k;
  int n = 0;
  for (; std::abs(c[n]) > 1e-17 && n < 7; ++n) {
    a[n + 1] = (a[n] + b) / 2, c[n + 1] = (a[n] - b) / 2;
    b = std::sqrt(a[n] * b);
  }
  double phi = std::ldexp(a[n] * (kPendulumPeriod / 4 - t) * std::sqrt(9.81), n);
  for (; n > 0; --n) phi = (std::asin(c[n] / a[n] * std::sin(phi)) + phi) / 2;
  return 2 * std::asin(k * std::sin(phi));
}

Errors order(const Errors& coarse, const Errors& fine) {
  return {std::log2(coarse.q / fine.q), std::log2(coarse.v / fine.v), std::log2(coarse.lambda / fine.lambda)};
}

Errors pendulum_errors(Method method, const std::function<double(int)>& step_end) {
  Scene scene = mass_chain({M_PI / 2});
  Errors worst;
  for (int i = 1; scene.state.time < 1.5 - 1e-9; ++i) {
    scene.run(*method, step_end(i));
    const double angle = pendulum_angle(scene.state.time), speed = -std::sqrt(2 * 9.81 * std::cos(angle));
    const Vector3 p(std::sin(angle), -std::cos(angle), 0), along(std::cos(angle), std::sin(angle), 0);
    const double direction = scene.state.time < kPendulumPeriod / 2 ? 1 : -1;
    worst.q = std::max(worst.q, (scene.position(0) - p).norm());
    worst.v = std::max(worst.v, (scene.state.v.head<3>() - direction * speed * along).norm());
    worst.lambda = std::max(worst.lambda, std::abs(scene.state.lambda[0] - 3 * 9.81 * std::cos(angle)));
  }
  return worst;
}

void expect_order(const std::string& what, const Errors& measured, double expected, double tolerance) {
  expect_below(what + ", order of q off by", std::abs(measured.q - expected), tolerance);
  expect_below(what + ", order of v off by", std::abs(measured.v - expected), tolerance);
  expect_below(what + ", order of λ off by", std::abs(measured.lambda - expected), tolerance);
}

}  // namespace lithe::test
