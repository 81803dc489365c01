// DOP853: its coefficients, its order on the constraints, its dense output, its estimate of stiffness.
#include <gtest/gtest.h>

#include <vector>

#include "bodies/rigid_body.h"
#include "integrators/explicit_runge_kutta.h"
#include "integrators/runge_kutta_tableau.h"
#include "joints/forces/bushing.h"
#include "tests/integrators/smooth_scenes.h"

namespace lithe::test::runge_kutta_test {
namespace {

using Tableau = RungeKuttaTableau;

/// A rooted tree: an elementary differential of y' = f(y) (Hairer, Nørsett & Wanner I, II.2).
struct Tree {
  int order;
  double density;              // γ
  std::vector<double> stages;  // Φ of each stage: Π over the branches of Σ_j a_ij Φ_j(branch)
};

/// All trees up to an order, with their stage sums for a tableau.
std::vector<Tree> trees(const Tableau& tableau, int up_to) {
  const std::size_t count = tableau.a.size();
  std::vector<Tree> all{{1, 1, std::vector<double>(count, 1.0)}};
  for (int order = 2; order <= up_to; ++order) {
    const std::size_t smaller = all.size();
    // Every multiset of smaller trees that together have order - 1 vertices, on a new root.
    const auto grow = [&](const auto& self, std::size_t first, int left, const Tree& root) -> void {
      if (left == 0) all.push_back({order, root.density * order, root.stages});
      for (std::size_t k = first; k < smaller; ++k) {
        if (all[k].order > left) continue;
        Tree next{0, root.density * all[k].density, root.stages};
        for (std::size_t i = 0; i < count; ++i) {
          double sum = 0;
          for (std::size_t j = 0; j < i; ++j) sum += tableau.a[i][j] * all[k].stages[j];
          next.stages[i] *= sum;
        }
        self(self, k, left - all[k].order, next);
      }
    };
    grow(grow, 0, order - 1, {0, 1, std::vector<double>(count, 1.0)});
  }
  return all;
}

/// Largest |Σ b_i Φ_i - θ^order / γ| over the trees of the orders given.
double condition(const std::vector<Tree>& all, const Tableau::Row& b, int from, int to, double theta = 1) {
  double worst = 0;
  for (const Tree& tree : all) {
    if (tree.order < from || tree.order > to) continue;
    double sum = 0;
    for (std::size_t i = 0; i < tree.stages.size(); ++i) sum += b[i] * tree.stages[i];
    worst = std::max(worst, std::abs(sum - std::pow(theta, tree.order) / tree.density));
  }
  return worst;
}

Tableau::Row less(const Tableau::Row& a, const Tableau::Row& b) {
  Tableau::Row c;
  for (std::size_t i = 0; i < c.size(); ++i) c[i] = a[i] - b[i];
  return c;
}

TEST(RungeKuttaTableau, MeetsEveryOrderConditionOfItsOrderAndNoMore) {
  for (const Tableau* tableau : {&dormand_prince5(), &dormand_prince8()}) {
    const std::string name(tableau->name);
    const auto all = trees(*tableau, tableau->order + 1);
    EXPECT_EQ(all.size(), tableau->order == 5 ? 37u : 486u);  // of all orders up to 6, 9 (Cayley)
    for (std::size_t i = 0; i < tableau->a.size(); ++i) {
      double sum = 0;
      for (double a : tableau->a[i]) sum += a;
      EXPECT_NEAR(sum, tableau->time[i], 1e-14) << name << ", row " << i;
    }
    const Tableau::Row& weights = tableau->a[tableau->stages - 1];
    expect_below(name + ", conditions up to its order", condition(all, weights, 1, tableau->order), 1e-14);
    EXPECT_GT(condition(all, weights, tableau->order + 1, tableau->order + 1), 1e-6) << name;

    // The embedded methods: orders 4; 5 and 3.
    const int lower = tableau->order == 5 ? 4 : 5;
    const Tableau::Row embedded = less(weights, tableau->error);
    expect_below(name + ", conditions of the embedded method", condition(all, embedded, 1, lower), 1e-14);
    EXPECT_GT(condition(all, embedded, lower + 1, lower + 1), 1e-6) << name;
  }
  const Tableau& eight = dormand_prince8();
  const auto all = trees(eight, 4);
  const Tableau::Row third = less(eight.a[12], eight.second_error);
  expect_below("8(5,3), conditions of the second embedded method", condition(all, third, 1, 3), 1e-14);
  EXPECT_GT(condition(all, third, 4, 4), 1e-6);
}

TEST(RungeKuttaTableau, DenseOutputMeetsTheConditionsOfOrderSevenInsideTheStep) {
  const Tableau& tableau = dormand_prince8();
  const auto all = trees(tableau, 8);
  const Tableau::Row& b = tableau.a[12];
  for (double x : {0.1, 0.37, 0.5, 0.81}) {
    // Weights at x of the nested polynomial F₀ x + F₁ x x' + F₂ x² x' + …, x' = 1 - x.
    Tableau::Row weights{};
    double basis = 1;
    for (std::size_t k = 0; k < 7; ++k) {
      basis *= k % 2 == 0 ? x : 1 - x;
      for (std::size_t i = 0; i < 16; ++i) {
        const double first = i == 0, last = i == 12;
        const double F = k == 0   ? b[i]
                         : k == 1 ? first - b[i]
                         : k == 2 ? 2 * b[i] - first - last
                                  : tableau.dense[k - 3][i];
        weights[i] += basis * F;
      }
    }
    expect_below("dense output at " + std::to_string(x), condition(all, weights, 1, 7, x), 1e-13);
    EXPECT_GT(condition(all, weights, 8, 8, x), 1e-9);
  }
}

TEST(RungeKutta8, IsOfOrderEightInPositionsVelocitiesAndMultipliers) {
  const double steps[] = {0.1, 0.04, 0.02, 0.0125, 2e-3};  // s, of the coarse runs
  for (int i = 0; i < 5; ++i) {
    const SmoothScene& smooth = kSmoothScenes[i];
    const auto exact = five_states(smooth, runge_kutta8(1e-14));
    const RunErrors coarse = run_difference(five_states(smooth, runge_kutta8_fixed(steps[i])), exact);
    const RunErrors fine = run_difference(five_states(smooth, runge_kutta8_fixed(steps[i] / 2)), exact);
    const std::string name = "RK8, " + std::string(smooth.name);
    expect_below(name + ", order of q short of 8 by", 8 - std::log2(coarse.q / fine.q), 0.6);
    expect_below(name + ", order of v short of 8 by", 8 - std::log2(coarse.v / fine.v), 0.6);
    expect_below(name + ", order of λ short of 8 by", 8 - std::log2(coarse.lambda / fine.lambda), 0.6);
    expect_below(name + ", error of q at the fine step", fine.q, 1e-8);
  }
}

TEST(RungeKutta8, MeetsTheTolerance) {
  for (const SmoothScene& smooth : kSmoothScenes) {
    const auto exact = five_states(smooth, runge_kutta(1e-14));  // by the other method
    for (double tolerance : {1e-4, 1e-6, 1e-8, 1e-10, 1e-12}) {
      const RunErrors errors = run_difference(five_states(smooth, runge_kutta8(tolerance)), exact);
      expect_below("RK8, " + std::string(smooth.name) + ", tolerance " + std::to_string(std::log10(tolerance)),
                   errors.q / tolerance, 10);
    }
  }
}

/// Largest errors of the dense output at three places in each of some steps.
struct DenseErrors : RunErrors {
  double v_dot;
};
DenseErrors dense_errors(const SmoothScene& smooth, double step) {
  Scene scene = smooth.make(), exact = smooth.make();
  Method method = runge_kutta8_fixed(step), reference = runge_kutta8(1e-14);
  method->start(scene.equations, scene.state);
  DenseErrors worst{};
  State from, at;
  while (scene.state.time < smooth.end / 3) {
    from = scene.state;
    EXPECT_TRUE(method->step(scene.equations, scene.state, smooth.end).ok());
    for (double x : {0.31, 0.5, 0.77}) {
      method->interpolate(scene.system.layout(), from, scene.state, from.time + x * step, at);
      exact.run(*reference, from.time + x * step);
      if (at.lambda.size() == 0) at.lambda = exact.state.lambda;  // forward dynamics: without multipliers within a step
      const RunErrors here = run_difference(at, exact.state);
      worst.q = std::max(worst.q, here.q);
      worst.v = std::max(worst.v, here.v);
      worst.lambda = std::max(worst.lambda, here.lambda);
      worst.v_dot = std::max(worst.v_dot, (at.v_dot - exact.state.v_dot).norm() / exact.state.v_dot.norm());
    }
  }
  return worst;
}

TEST(RungeKutta8, DenseOutputIsOfOrderSevenAndOfFiveInTheMultipliers) {
  const double steps[] = {0.1, 0.04, 0.02, 0.02, 2e-3};
  for (int i = 0; i < 5; ++i) {
    const DenseErrors coarse = dense_errors(kSmoothScenes[i], steps[i]);
    const DenseErrors fine = dense_errors(kSmoothScenes[i], steps[i] / 2);
    const std::string name = "RK8, dense output, " + std::string(kSmoothScenes[i].name);
    expect_below(name + ", order of q short of 8 by", 8 - std::log2(coarse.q / fine.q), 1);
    expect_below(name + ", order of v short of 8 by", 8 - std::log2(coarse.v / fine.v), 1);
    expect_below(name + ", order of v̇ short of 7 by", 7 - std::log2(coarse.v_dot / fine.v_dot), 1);
    if (fine.lambda > 0)
      expect_below(name + ", order of λ short of 5 by", 5 - std::log2(coarse.lambda / fine.lambda), 1.2);
    expect_below(name + ", error of q", fine.q, 1e-7);
  }
}

TEST(RungeKutta8, DenseOutputMeetsBothEndsAndLeavesTheRunAsItIs) {
  for (const SmoothScene& smooth : kSmoothScenes) {
    Scene plain = smooth.make(), asked = smooth.make();
    Method first = runge_kutta8(1e-7), second = runge_kutta8(1e-7);
    first->start(plain.equations, plain.state);
    second->start(asked.equations, asked.state);
    State from, at;
    for (int i = 0; i < 5; ++i) {
      from = asked.state;
      ASSERT_TRUE(first->step(plain.equations, plain.state, smooth.end).ok());
      ASSERT_TRUE(second->step(asked.equations, asked.state, smooth.end).ok());
      EXPECT_EQ(plain.state.q, asked.state.q) << smooth.name;
      for (const State* end : {&from, &asked.state}) {
        second->interpolate(asked.system.layout(), from, asked.state, end->time, at);
        EXPECT_LT((at.q - end->q).norm(), 1e-13) << smooth.name;
        EXPECT_LT((at.v - end->v).norm(), 1e-12) << smooth.name;
        EXPECT_LT((at.v_dot - end->v_dot).norm(), 1e-9 * (1 + end->v_dot.norm())) << smooth.name;
        if (at.lambda.size() > 0) {
          EXPECT_LT((at.lambda - end->lambda).norm(), 1e-12 * end->lambda.norm()) << smooth.name;
        }
      }
    }
  }
}

/// A mass of 2 kg on a spring and damper along x, drawn out.
Scene spring(double omega, double damping_ratio) {
  return Scene({0, 0, -9.81}, [&](SystemGraph& graph) {
    auto& mass = graph.add<RigidBody>("mass", {.mass = 2, .inertia = {1, 1, 1}, .velocity = {1, 0, 0}});
    graph.add<Bushing>("spring", {graph.ground().marker(), mass.marker()},
                       {.stiffness = Bushing::diagonal({2 * omega * omega, 0, 0}, {0, 0, 0}),
                        .damping = Bushing::diagonal({4 * damping_ratio * omega, 0, 0}, {0, 0, 0})});
  });
}

TEST(Stiffness, IsTheStepTimesTheFastestFrequency) {
  for (auto method : {ExplicitRungeKutta::Method::dormand_prince5, ExplicitRungeKutta::Method::dormand_prince8}) {
    // An oscillator, and a damper so strong that its mode decays by c/m = 2 ζ ω.
    for (double ratio : {0.0, 20.0}) {
      const double omega = 100, fastest = ratio == 0 ? omega : omega * (ratio + std::sqrt(ratio * ratio - 1));
      Scene scene = spring(omega, ratio);
      ExplicitRungeKutta integrator({.method = method, .step = 1 / fastest});
      scene.run(integrator, 1 / fastest);
      EXPECT_NEAR(integrator.stiffness(), 1, 0.02) << integrator.name() << ", damping ratio " << ratio;
    }
  }
}

TEST(Stiffness, HoldsTheStepsOfAnAutomaticRunNearTheLimit) {
  for (auto method : {ExplicitRungeKutta::Method::dormand_prince5, ExplicitRungeKutta::Method::dormand_prince8}) {
    Scene scene = spring(1000, 20);  // decays within 25 µs, then falls freely
    ExplicitRungeKutta integrator({.method = method, .tolerance = {1e-4, 1e-4}});
    integrator.start(scene.equations, scene.state);
    double begin = 0, told = 0;
    for (int i = 0; i < 400; ++i) {
      ASSERT_TRUE(integrator.step(scene.equations, scene.state, 100).ok());
      if (i == 100) begin = scene.state.time;
      if (i > 100) told += integrator.stiffness() / 299;
    }
    const double mean = (scene.state.time - begin) / 299, fastest = 1000 * (20 + std::sqrt(399));
    expect_below(integrator.name() + ", mean step by the limit, off 1 by",
                 std::abs(mean * fastest / integrator.stability_limit() - 1), 0.2);
    expect_below(integrator.name() + ", mean stiffness told, off that by", std::abs(told / (mean * fastest) - 1), 0.2);
  }
}

TEST(Stiffness, IsSmallWhereTheToleranceRules) {
  Scene scene = box_chain(4, true);
  ExplicitRungeKutta integrator({.method = ExplicitRungeKutta::Method::dormand_prince8, .tolerance = {1e-10, 1e-10}});
  integrator.start(scene.equations, scene.state);
  while (scene.state.time < 0.5) {
    ASSERT_TRUE(integrator.step(scene.equations, scene.state, 0.5).ok());
    EXPECT_LT(integrator.stiffness(), 0.5 * integrator.stability_limit());
  }
}

TEST(RungeKutta8, TellsWhichVelocityLimitsTheStep) {
  Scene scene = spring(100, 0);
  Method method = runge_kutta8(1e-8);
  scene.run(*method, 0.1);
  const std::string name = scene.system.layout().velocity_name(method->statistics().limiting);
  EXPECT_EQ(name, "mass: p_x");
}

TEST(RungeKutta8, KeepsEnergyAndConstraintsForAHundredSeconds) {
  Scene scene = mass_chain({M_PI / 3, M_PI / 3});
  const double start = scene.energy();
  Method method = runge_kutta8_fixed(0.02);
  double violation = 0;
  for (int second = 1; second <= 100; ++second) {
    scene.run(*method, second);
    violation = std::max({violation, scene.violation(Level::position), scene.violation(Level::velocity)});
  }
  expect_below("RK8, |g| and |G v| over 5000 steps", violation, 1e-13);
  expect_below("RK8, energy after 5000 steps (J)", std::abs(scene.energy() - start), 1e-5);
}

}  // namespace
}  // namespace lithe::test::runge_kutta_test
