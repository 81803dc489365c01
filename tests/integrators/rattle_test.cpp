// RATTLE: order, what a symplectic and symmetric method keeps, and the step that a frequency allows.
#include "integrators/rattle.h"

#include <gtest/gtest.h>

#include "bodies/rigid_body.h"
#include "engine/assembly/evaluated.h"
#include "joints/forces/spring_damper.h"
#include "tests/integrators/conserving_scenes.h"
#include "tests/support/methods.h"

namespace lithe::test::rattle_test {
namespace {

constexpr double kPeriod = 2.36784194757623744930;  // s, of the pendulum released horizontally

TEST(Rattle, IsOfOrderTwoForThePendulum) {
  // After 5/8 of the period sin(angle/2) = k cd(K/2): cos(angle) = sqrt(2) - 1.
  const double c = M_SQRT2 - 1, s = std::sqrt(1 - c * c), speed = std::sqrt(2 * 9.81 * c);
  const auto errors = [&](int steps) {
    Scene scene = mass_chain({M_PI / 2});
    scene.run(*rattle(0.625 * kPeriod / steps), 0.625 * kPeriod);
    return Errors{(scene.position(0) - Vector3(-s, -c, 0)).norm(),
                  (scene.state.v.head<3>() - speed * Vector3(c, -s, 0)).norm(),
                  std::abs(scene.state.lambda[0] - 3 * 9.81 * c)};
  };
  expect_order_two("pendulum", errors(300), errors(600), 0.05);
}

TEST(Rattle, IsOfOrderTwoForAChainOfRevoluteJoints) {
  Scene exact = box_chain(4, true);
  exact.run(*runge_kutta(1e-13), 0.25);
  const auto errors = [&](double h) {
    Scene scene = box_chain(4, true);
    scene.run(*rattle(h), 0.25);
    return difference(scene.state, exact.state);
  };
  expect_order_two("chain", errors(2e-3), errors(1e-3), 0.1);
}

TEST(Rattle, IsOfOrderTwoForAFlexiblePendulum) {
  Scene exact = flexible_pendulum();
  exact.run(*runge_kutta(1e-12), 0.1);
  const auto errors = [&](double h) {
    Scene scene = flexible_pendulum();
    scene.run(*rattle(h), 0.1);
    return difference(scene.state, exact.state);
  };
  expect_order_two("flexible pendulum", errors(2e-4), errors(1e-4), 0.1);
}

TEST(Rattle, IsOfOrderTwoWithRollingDrivesAndFriction) {
  const std::pair<const char*, Scene (*)()> scenes[] = {{"rolling disc", rolling_disc},
                                                        {"drive and friction", driven_with_friction}};
  for (auto [name, make] : scenes) {
    Scene exact = make();
    exact.run(*runge_kutta(1e-12), 0.3);
    const auto errors = [&, draw = make](double h) {
      Scene scene = draw();
      scene.run(*rattle(h), 0.3);
      return difference(scene.state, exact.state);
    };
    expect_order_two(name, errors(2e-3), errors(1e-3), 0.1);
  }
}

TEST(Rattle, BoundsThePendulumsEnergyOverAMillionSteps) {
  Scene scene = mass_chain({M_PI / 2});
  const Method method = rattle(1e-2);
  const EnergyRecord energy = record_energy(scene, *method, 1e4, 20011);
  EXPECT_GE(method->statistics().steps, 1000000);
  expect_below("pendulum, 1e6 steps: energy off (J)", energy.deviation, 1e-2);
  expect_below("pendulum, 1e6 steps: drift of energy over the run (J)", std::abs(energy.slope), 1e-5);
  expect_below("pendulum, 1e6 steps: |g|", scene.violation(Level::position), 1e-12);
  expect_below("pendulum, 1e6 steps: |G v|", scene.violation(Level::velocity), 1e-12);
}

TEST(Rattle, LetsTheEnergyOfADoublePendulumNotDrift) {
  Scene scene = mass_chain({M_PI / 3, M_PI / 3});
  const EnergyRecord energy = record_energy(scene, *rattle(5e-3), 500, 10007);
  expect_below("double pendulum, 1e5 steps: energy off (J)", energy.deviation, 1e-2);
  expect_below("double pendulum, 1e5 steps: drift of energy over the run (J)", std::abs(energy.slope), 1e-5);
}

TEST(Rattle, LetsTheEnergyOfAFlexiblePendulumNotDrift) {
  Scene scene = flexible_pendulum();
  const EnergyRecord energy = record_energy(scene, *rattle(4e-4), 16, 8009);
  expect_below("flexible pendulum, 4e4 steps: energy off (J)", energy.deviation, 1e-5);
  expect_below("flexible pendulum, 4e4 steps: drift of energy over the run (J)", std::abs(energy.slope), 1e-7);
}

TEST(Rattle, KeepsTheHeavyTopsVerticalAngularMomentum) {
  Scene scene = heavy_top(15, 1, 0.234375, 0.46875, {0, 150, -4.61538});
  const auto vertical = [&] {
    const Vector3 p = scene.position(0), omega = scene.state.v.segment<3>(3);
    const Vector3 spin(0.234375 * omega[0], 0.46875 * omega[1], 0.234375 * omega[2]);
    return 15 * p.cross(Vector3(scene.state.v.head<3>())).z() +
           (rotation_matrix(scene.state.q.segment<4>(3)) * spin).z();
  };
  const double start = vertical();
  double off = 0;
  const Method method = rattle(1e-3);
  for (int k = 1; k <= 200; ++k) {
    scene.run(*method, 0.1 * k);
    off = std::max(off, std::abs(vertical() - start));
  }
  expect_below("heavy top, 2e4 steps: vertical angular momentum off, of 69 N m s", off / std::abs(start), 1e-11);
}

TEST(Rattle, KeepsTheMomentaOfTwoBodiesHeldTogether) {
  Scene scene = free_pair();
  const Vector6 start = momenta_of_pair(scene);
  scene.run(*rattle(5e-3), 50);
  const Vector6 off = momenta_of_pair(scene) - start;
  expect_below("pair, 1e4 steps: linear momentum off (N s)", off.head<3>().norm(), 1e-11);
  expect_below("pair, 1e4 steps: angular momentum off (N m s)", off.tail<3>().norm(), 1e-10);
}

TEST(Rattle, KeepsTheMomentaOfAFreeFlexibleBodyToRoundOff) {
  FlexibleBody* bar = nullptr;
  Scene scene(Vector3::Zero(), [&](SystemGraph& graph) { bar = &add_bar(graph, {0.3, -0.2, 0.1}, {8, 5, -6}, 1e-2); });
  const auto momenta = [&]() -> Vector6 {
    scene.equations.evaluate(scene.state.time, scene.state.q, scene.state.v, Level::velocity);
    const BodyState state = body_state(scene.equations, *bar);
    Vector6 both;
    both << bar->linear_momentum(state), bar->angular_momentum(state);
    return both;
  };
  const Vector6 start = momenta();
  const Method method = rattle(1e-4);
  const double whole = scene.energy();
  const EnergyRecord energy = record_energy(scene, *method, 1, 1009);
  const double linear = (momenta() - start).head<3>().norm() / start.head<3>().norm();
  const double angular = (momenta() - start).tail<3>().norm() / start.tail<3>().norm();
  expect_below("free bar, 1e4 steps: linear momentum off", linear, 1e-10);
  expect_below("free bar, 1e4 steps: angular momentum off", angular, 1e-10);
  expect_below("free bar, 1e4 steps: energy off", energy.deviation / whole, 1e-2);
  expect_below("free bar, 1e4 steps: drift of energy over the run", std::abs(energy.slope) / whole, 1e-5);
}

TEST(Rattle, GoesBackTheWayItCame) {
  const auto return_error = [](Scene scene, double h, double end) {
    const VectorX q = scene.state.q, v = scene.state.v;
    scene.run(*rattle(h), end);
    scene.state.v *= -1;
    const Method back = rattle(h);
    back->start(scene.equations, scene.state);
    scene.run(*back, 2 * end);
    return std::max((scene.state.q - q).norm(), (scene.state.v + v).norm());
  };
  expect_below("chain of revolute joints, 200 steps to and fro", return_error(box_chain(4, true), 2e-3, 0.4), 1e-10);
  expect_below("flexible pendulum, 250 steps to and fro", return_error(flexible_pendulum(), 4e-4, 0.1), 1e-10);
  expect_below("rolling disc, 200 steps to and fro", return_error(rolling_disc(), 2e-3, 0.4), 1e-10);
}

TEST(Rattle, NeedsAStepBelowTwoOverTheHighestFrequency) {
  // 1 kg on a spring of 100 N/m: ω = 10 rad/s.
  const auto farthest = [](double h) {
    Scene scene(Vector3::Zero(), [](SystemGraph& graph) {
      auto& mass = graph.add<RigidBody>("mass", {.mass = 1, .inertia = {1, 1, 1}, .position = {2, 0, 0}});
      graph.add<SpringDamper>("spring", {graph.ground().marker(), mass.marker()},
                              {.stiffness = 100, .natural_length = 1.9});
    });
    const Method method = rattle(h);
    double worst = 0;
    for (int k = 1; k <= 200; ++k) {
      scene.run(*method, k * h);
      worst = std::max(worst, std::abs(scene.position(0).x() - 1.9));
    }
    return worst;
  };
  expect_below("spring, h ω = 1.9: amplitude (m)", farthest(0.19), 0.5);
  EXPECT_GT(farthest(0.205), 10) << "h ω = 2.05 has to grow";
}

}  // namespace
}  // namespace lithe::test::rattle_test
