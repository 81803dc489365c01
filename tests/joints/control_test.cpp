#include <gtest/gtest.h>

#include <array>

#include "bodies/integral_state.h"
#include "engine/observe/recorder.h"
#include "engine/run/simulation.h"
#include "joints/forces/bushing.h"
#include "joints/forces/coordinate_motor.h"
#include "joints/forces/coordinate_spring.h"
#include "joints/forces/coordinate_stop.h"
#include "joints/forces/pid_controller.h"
#include "joints/forces/point_force.h"
#include "joints/prismatic_joint.h"
#include "tests/joints/mechanisms.h"

/// Forces on joint coordinates, in motion, against closed forms and equations integrated by the test itself.
namespace lithe::test::control_test {
namespace {

/// Classical Runge-Kutta on y' = f(t, y).
template <std::size_t N, class F>
std::array<double, N> reference(std::array<double, N> y, double end, int steps, F&& f) {
  const double h = end / steps;
  const auto moved = [](std::array<double, N> a, double s, const std::array<double, N>& b) {
    for (std::size_t i = 0; i < N; ++i) a[i] += s * b[i];
    return a;
  };
  for (int k = 0; k < steps; ++k) {
    const double t = k * h;
    const auto a = f(t, y), b = f(t + h / 2, moved(y, h / 2, a)), c = f(t + h / 2, moved(y, h / 2, b)),
               d = f(t + h, moved(y, h, c));
    for (std::size_t i = 0; i < N; ++i) y[i] += h / 6 * (a[i] + 2 * b[i] + 2 * c[i] + d[i]);
  }
  return y;
}

/// ∫ of a recorded column over time by the trapezoid rule.
double integral(const Table& table, const char* column) {
  const std::vector<double> t = table.column("t"), y = table.column(column);
  double sum = 0;
  for (std::size_t i = 1; i < t.size(); ++i) sum += 0.5 * (t[i] - t[i - 1]) * (y[i] + y[i - 1]);
  return sum;
}

/// J ω̇ = T₀ - c ω: ω = T₀ / c (1 - exp(-c t / J)), up to the steady speed.
TEST(CoordinateMotor, RunsUpToTheSpeedWhereItsTorqueEnds) {
  const double J = 0.4, T = 6, c = 0.8;
  for (auto& [name, method] : every_method(1e-3)) {
    SCOPED_TRACE(name);
    Shaft shaft;
    CoordinateMotor* motor;
    Scene scene({0, 0, 0}, [&](SystemGraph& graph) {
      shaft = draw_shaft(graph, "shaft", J);
      motor = &graph.add<CoordinateMotor>("motor", {shaft.angle()},
                                          {[=](double, double, double speed) { return T - c * speed; }});
    });
    for (double t : {0.5, 5.0}) {
      scene.run(*method, t);
      const double gone = std::exp(-c * t / J), speed = T / c * (1 - gone);
      EXPECT_NEAR(read(scene, coordinate_rate(shaft.angle(), "speed")), speed, 1e-5);
      EXPECT_NEAR(read(scene, coordinate(shaft.angle(), "phi")), T / c * (t - J / c * (1 - gone)), 1e-5);
      EXPECT_NEAR(read(scene, power(*motor)), (T - c * speed) * speed, 1e-4);
    }
  }
}

TEST(CoordinateMotor, PowerAddsUpToTheKineticEnergy) {
  CoordinateMotor* motor;
  Scene scene({0, 0, 0}, [&](SystemGraph& graph) {
    const Shaft shaft = draw_shaft(graph, "shaft", 0.4);
    motor = &graph.add<CoordinateMotor>("motor", {shaft.angle()}, {[](double t, double phi, double speed) {
                                          return 3 * std::cos(t) - 0.1 * speed + std::sin(phi);
                                        }});
  });
  const Method method = index2(5e-4);
  Recorder recorder{{power(*motor, "power")}};
  Simulation simulation{scene.system, *method};
  simulation.observe(recorder, every_step());
  simulation.run(scene.state, 2);
  EXPECT_GT(scene.energy(), 1);
  EXPECT_NEAR(integral(recorder.table(), "power"), scene.energy(), 1e-5 * scene.energy());
}

/// A hardening spring given as a table: its points are met, energy is kept.
TEST(CoordinateSpring, FollowsATable) {
  const std::vector<double> stretch = {-0.4, -0.2, 0, 0.2, 0.4}, force = {-30, -8, 0, 8, 30};
  PrismaticJoint* slide;
  CoordinateSpring* spring;
  Scene scene({0, 0, 0}, [&](SystemGraph& graph) {
    auto& block = graph.add<RigidBody>("block", {.mass = 2, .position = {0, 0, 0.2}});
    slide = &graph.add<PrismaticJoint>("slide", {graph.ground().marker(), block.marker()});
    spring = &graph.add<CoordinateSpring>("spring", {slide->displacement()},
                                          {.free_value = 0, .law = tabulated_spring(stretch, force)});
  });
  EXPECT_NEAR(scene.state.v_dot[2], -8.0 / 2, 1e-12);
  const double start = scene.energy();
  EXPECT_NEAR(read(scene, potential_energy(*spring)), start, 1e-12);
  const Method method = runge_kutta(1e-10);
  scene.run(*method, 3);
  EXPECT_NEAR(scene.energy(), start, 1e-7);
}

/// A block meets a stop. Hunt and Crossley's law gives speeds before and after, u and w, by its own integral:
///   d u - ln(1 + d u) = -d w - ln(1 - d w), for any stiffness and exponent.
TEST(CoordinateStop, GivesBackTheSpeedThatHuntAndCrossleysIntegralSays) {
  const double m = 2, d = 0.1, u = 1.5;
  double low = 0, high = u;
  for (int k = 0; k < 80; ++k) {
    const double w = 0.5 * (low + high);
    (-d * w - std::log(1 - d * w) < d * u - std::log(1 + d * u) ? low : high) = w;
  }
  EXPECT_NEAR(low / u, 1 - 2.0 / 3 * d * u, 0.01);  // e ≈ 1 - 2/3 d v, for e near 1
  for (double side : {1.0, -1.0})
    for (double exponent : {1.0, 1.5}) {
      PrismaticJoint* slide;
      CoordinateStop* stop;
      Scene scene({0, 0, 0}, [&](SystemGraph& graph) {
        auto& block = graph.add<RigidBody>("block", {.mass = m, .velocity = {0, 0, side * u}});
        slide = &graph.add<PrismaticJoint>("slide", {graph.ground().marker(), block.marker()});
        stop = &graph.add<CoordinateStop>(
            "stop", {slide->displacement()},
            {.lower = -0.1, .upper = 0.1, .stiffness = 1e4, .exponent = exponent, .dissipation = d});
      });
      const double start = scene.energy();
      const Method method = index2(2e-5);
      Recorder recorder{{power(*stop, "power"), potential_energy(*stop, "potential")}};
      Simulation simulation{scene.system, *method};
      simulation.observe(recorder, every_step());
      simulation.run(scene.state, 0.25);
      const double after = -side * read(scene, coordinate_rate(slide->displacement(), "w"));
      EXPECT_NEAR(after, low, 2e-4 * u);
      EXPECT_EQ(read(scene, potential_energy(*stop)), 0);
      EXPECT_NEAR(integral(recorder.table(), "power"), scene.energy() - start, 1e-3);
      EXPECT_NEAR(scene.energy() - start, 0.5 * m * (after * after - u * u), 1e-9);
    }
}

TEST(CoordinateStop, EndsATurnBeyondWholeTurns) {
  Shaft shaft;
  Scene scene({0, 0, 0}, [&](SystemGraph& graph) {
    shaft = draw_shaft(graph, "shaft", 0.1, {0, 0, 0}, Matrix3::Identity(), 10);
    graph.add<CoordinateStop>("stop", {shaft.angle()}, {.upper = 15, .stiffness = 1e3, .exponent = 1});
  });
  const Method method = index2(1e-4);
  scene.run(*method, 1.4);
  EXPECT_NEAR(read(scene, coordinate(shaft.angle(), "phi")), 14, 1e-6);
  scene.run(*method, 2.5);
  EXPECT_NEAR(read(scene, coordinate_rate(shaft.angle(), "speed")), -10, 1e-2);
}

/// A servo against a constant load: the engine against the test's own integration; no error stays.
TEST(PidController, ReachesItsTargetUnderLoadAsItsOwnEquationsSay) {
  const double J = 0.5, load = -4, kp = 60, ki = 80, kd = 12;
  const MotionLaw target = smooth_step(0, 8, 0, 1);  // more than a turn
  const auto rates = [&](double t, const std::array<double, 3>& y) {
    const Motion w = target(t);
    const double e = w.value - y[0];
    return std::array<double, 3>{y[1], (kp * e + ki * y[2] + kd * (w.rate - y[1]) + load) / J, e};
  };
  for (auto& [name, method] : every_method(1e-3)) {
    SCOPED_TRACE(name);
    Shaft shaft;
    IntegralState* memory;
    Scene scene({0, 0, 0}, [&](SystemGraph& graph) {
      shaft = draw_shaft(graph, "shaft", J);
      memory = &graph.add<IntegralState>("memory");
      graph.add<PidController>("servo", {shaft.angle(), memory->coordinate()},
                               {.target = target, .proportional = kp, .integral = ki, .derivative = kd});
      graph.add<PointForce>("load", {shaft.body->marker()}, {.torque = {0, 0, load}});
    });
    scene.run(*method, 1.3);
    const auto expected = reference<3>({0, 0, 0}, 1.3, 20000, rates);
    EXPECT_NEAR(read(scene, coordinate(shaft.angle(), "phi")), expected[0], 1e-5);
    EXPECT_NEAR(read(scene, coordinate_rate(shaft.angle(), "speed")), expected[1], 2e-4);
    EXPECT_NEAR(read(scene, coordinate_rate(memory->coordinate(), "integral")), expected[2], 1e-5);
    scene.run(*method, 12);
    EXPECT_NEAR(read(scene, coordinate(shaft.angle(), "phi")), 8, 1e-5);
    EXPECT_NEAR(read(scene, coordinate_rate(memory->coordinate(), "integral")), -load / ki, 1e-5);
  }
}

/// A weak servo that its limit holds back for long: while it does, the integral waits.
TEST(PidController, DoesNotWindUpWhileItsForceIsLimited) {
  const double J = 0.5, kp = 30, ki = 20, kd = 6, limit = 2, goal = 5;
  const auto rates = [&](bool waits) {
    return [=](double, const std::array<double, 3>& y) {
      const double e = goal - y[0], wanted = kp * e + ki * y[2] - kd * y[1];
      const double given = std::clamp(wanted, -limit, limit);
      const bool beyond = waits && given != wanted && wanted * e > 0;
      return std::array<double, 3>{y[1], given / J, beyond ? 0 : e};
    };
  };
  Shaft shaft;
  Scene scene({0, 0, 0}, [&](SystemGraph& graph) {
    shaft = draw_shaft(graph, "shaft", J);
    auto& memory = graph.add<IntegralState>("memory");
    graph.add<PidController>(
        "servo", {shaft.angle(), memory.coordinate()},
        {.target = constant(goal), .proportional = kp, .integral = ki, .derivative = kd, .limit = limit});
  });
  const Method method = index2(5e-4);
  double peak = 0, peak_wound = 0;
  for (double t = 0.5; t <= 6; t += 0.5) {
    scene.run(*method, t);
    const double phi = read(scene, coordinate(shaft.angle(), "phi"));
    EXPECT_NEAR(phi, (reference<3>({0, 0, 0}, t, 20000, rates(true))[0]), 5e-3) << t;
    peak = std::max(peak, phi);
    peak_wound = std::max(peak_wound, reference<3>({0, 0, 0}, t, 20000, rates(false))[0]);
  }
  EXPECT_LT(peak, peak_wound - 0.5);
}

/// Six springs, one a freedom: a body swings at sqrt(k / m) and sqrt(k / J).
TEST(Bushing, SwingsAtItsLinearFrequencies) {
  const double m = 2, J = 0.3;
  const Vector3 k(200, 300, 400), turning(30, 40, 50);
  for (int i = 0; i < 6; ++i) {
    Bushing* bushing;
    const double omega = std::sqrt(i < 3 ? k[i] / m : turning[i - 3] / J), size = 1e-3;
    Vector6 rate = size * omega * Vector6::Unit(i);
    Scene scene({0, 0, 0}, [&](SystemGraph& graph) {
      auto& body = graph.add<RigidBody>("body", {.mass = m,
                                                 .inertia = {J, J, J},
                                                 .position = {1, 2, 3},
                                                 .velocity = Vector3(rate.head<3>()),
                                                 .angular_velocity = Vector3(rate.tail<3>())});
      bushing = &graph.add<Bushing>("bushing", {graph.ground().marker({1, 2, 3}), body.marker()},
                                    {.stiffness = Bushing::diagonal(k, turning)});
    });
    const double start = scene.energy(), quarter = kPi / 2 / omega;
    const Method method = runge_kutta(1e-11);
    scene.run(*method, quarter);  // all speed is gone
    EXPECT_NEAR(read(scene, potential_energy(*bushing)), start, 1e-6 * start);
    scene.run(*method, 3 * quarter);
    EXPECT_NEAR(read(scene, potential_energy(*bushing)), start, 1e-6 * start);
    const Vector3 turned = rotation_log(rotation_matrix(scene.state.q.segment<4>(3)));
    EXPECT_NEAR(i < 3 ? scene.state.q[i] - (i + 1) : turned[i - 3], -size, 1e-6 * size);
  }
}

}  // namespace
}  // namespace lithe::test::control_test
