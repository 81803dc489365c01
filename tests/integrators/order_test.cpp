// Orders of convergence, measured.
#include <gtest/gtest.h>

#include "integrators/generalized_alpha.h"
#include "tests/integrators/pendulum_errors.h"

namespace lithe::test::order_test {
namespace {

TEST(GeneralizedAlphaOrder, IsTwoInPositionVelocityAndMultiplier) {
  for (auto make : {index3, index2})
    for (double rho : {0.0, 0.5, 0.8, 0.9}) {
      const auto errors = [&](double h) { return pendulum_errors(make(h, rho), [&](int i) { return i * h; }); };
      const std::string name = make(1, rho)->name() + ", rho " + std::to_string(rho).substr(0, 3);
      const Errors fine = errors(2.5e-3);
      expect_order(name, order(errors(5e-3), fine), 2, 0.15);
      expect_below(name + ", error of λ at 2.5 ms (N/m)", fine.lambda, rho < 0.5 ? 2e-2 : 5e-3);
    }
}

TEST(GeneralizedAlphaOrder, StaysTwoWhenStepsAlternate) {
  // Stability laboratory S30: carried over unchanged, the acceleration-like state spoils λ to 17 N/m at 0.01 s.
  for (auto make : {index3, index2}) {
    const auto errors = [&](double h) {
      return pendulum_errors(make(h, 0.8), [&](int i) { return (i / 2) * 1.5 * h + (i % 2) * h; });
    };
    const Errors coarse = errors(5e-3), fine = errors(2.5e-3);
    expect_order(make(1, 0.8)->name() + ", steps h, h/2", order(coarse, fine), 2, 0.35);
    expect_below("error of λ at alternating steps of 5 ms and 2.5 ms (N/m)", coarse.lambda, 2e-2);
  }
}

TEST(GeneralizedAlphaOrder, BearsASliverOfAStep) {
  for (auto make : {index3, index2}) {
    const double h = 5e-3;
    const Errors errors = pendulum_errors(make(h, 0.8), [&](int i) { return (i / 2) * h + (i % 2) * 1e-3 * h; });
    expect_below(make(1, 0.8)->name() + ", slivers of 5 µs between steps of 5 ms, q (m)", errors.q, 2e-3);
    expect_below(make(1, 0.8)->name() + ", slivers of 5 µs between steps of 5 ms, λ (N/m)", errors.lambda, 0.3);
  }
}

/// Error of λ after four steps of a pendulum that starts in full swing.
double start_transient(double h, bool correct_start) {
  Scene scene = mass_chain({M_PI / 4}), exact = mass_chain({M_PI / 4});
  scene.state.v.head<3>() = exact.state.v.head<3>() = Vector3(3, 3, 0);
  GeneralizedAlpha method(
      {.step = h, .spectral_radius = 0.8, .newton_tolerance = 1e-12, .correct_start = correct_start});
  scene.run(method, 4 * h);
  exact.run(*runge_kutta(1e-12), 4 * h);
  return std::abs(scene.state.lambda[0] - exact.state.lambda[0]);
}

TEST(GeneralizedAlphaOrder, NeedsTheCorrectedStartForTheFirstMultipliers) {
  // With exact v₀ and a₀ = v̇₀ the multiplier keeps a transient of first order (docs/equations.md 8.1).
  const double plain = start_transient(2e-3, false) / start_transient(1e-3, false);
  const double corrected = start_transient(2e-3, true) / start_transient(1e-3, true);
  expect_below("order of λ after four steps, plain start, off 1 by", std::abs(std::log2(plain) - 1), 0.15);
  expect_below("order of λ after four steps, corrected start, off 2 by", std::abs(std::log2(corrected) - 2), 0.3);
  expect_below("transient of λ at 1 ms, corrected over plain",
               start_transient(1e-3, true) / start_transient(1e-3, false), 0.1);
}

/// Error of a chain of revolute joints after 0.25 s, against a run at a tolerance of 1e-13.
double chain_error(Method method) {
  static const VectorX exact = [] {
    Scene scene = box_chain(4, true);
    scene.run(*runge_kutta(1e-13), 0.25);
    return scene.state.q;
  }();
  Scene scene = box_chain(4, true);
  scene.run(*method, 0.25);
  return (scene.state.q - exact).norm();
}

TEST(ExplicitRungeKuttaOrder, IsFiveOnTheConstraints) {
  const auto errors = [&](double h) { return pendulum_errors(runge_kutta_fixed(h), [&](int i) { return i * h; }); };
  expect_order("explicit Runge-Kutta, pendulum", order(errors(1e-2), errors(5e-3)), 5, 0.35);
  const double coarse = chain_error(runge_kutta_fixed(5e-3)), fine = chain_error(runge_kutta_fixed(2.5e-3));
  expect_below("explicit Runge-Kutta, chain, order off by", std::abs(std::log2(coarse / fine) - 5), 0.5);
  expect_below("explicit Runge-Kutta, chain, error at 2.5 ms", fine, 1e-7);
}

TEST(ExplicitRungeKuttaOrder, IsFiveForAFreeBodyInTheChart) {
  const auto error = [](double h) {
    const Vector3 inertia(1, 2, 3), omega(0.4, 1, 0.3);
    Scene exact = free_body(inertia, omega), scene = free_body(inertia, omega);
    exact.run(*runge_kutta(1e-14), 2);
    scene.run(*runge_kutta_fixed(h), 2);
    return (exact.state.q - scene.state.q).norm();
  };
  expect_below("explicit Runge-Kutta, free body, order off by", std::abs(std::log2(error(0.1) / error(0.05)) - 5), 0.4);
}

}  // namespace
}  // namespace lithe::test::order_test
