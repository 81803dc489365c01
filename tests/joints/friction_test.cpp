#include <gtest/gtest.h>

#include <array>

#include "engine/analysis/kinematics.h"
#include "engine/observe/recorder.h"
#include "engine/run/simulation.h"
#include "joints/contact/contact.h"
#include "joints/coordinate_drive.h"
#include "joints/fixed_joint.h"
#include "joints/forces/joint_friction.h"
#include "joints/forces/point_force.h"
#include "joints/prismatic_joint.h"
#include "tests/joints/coulomb_friction_scenes.h"
#include "tests/joints/friction_checks.h"
#include "tests/joints/mechanisms.h"
#include "tests/support/joint_checks.h"
#include "tests/support/pairs.h"

/// Friction that a joint's own reaction drives.
namespace lithe::test::friction_test {
namespace {

constexpr double kGravity = 9.81;

TEST(JointFriction, TakesPowerAndKnowsItsDerivatives) {
  for (const Pair& pair : pairs()) {
    SCOPED_TRACE(pair.name);
    {
      SystemGraph graph;
      auto& pin = graph.add<RevoluteJoint>("pin", pair.draw(graph, {0, 0, 0}));
      auto& rub = graph.add<JointFriction>("rub", {pin.angle()}, coarse_friction(pin));
      check_friction(graph, rub, 1e-7);
    }
    SystemGraph graph;
    auto& slide = graph.add<PrismaticJoint>("slide", pair.draw(graph, {0, 0, 0.3}));
    auto& rub = graph.add<JointFriction>(
        "rub", {slide.displacement()},
        {.joint = &slide, .coefficient = 0.3, .creep_speed = 3, .radius = 0.5, .bending_arm = 0.3});
    check_friction(graph, rub, 1e-7);
  }
}

/// A block shot up or down a slope slows by g (μ cos α ± sin α).
TEST(JointFriction, SlowsABlockOnASlopeByItsOwnWeight) {
  const double mu = 0.3, slope = 0.2, end = 0.3;
  for (double v0 : {2.0, -2.0})
    for (auto& [name, method] : every_method(1e-3)) {
      SCOPED_TRACE(name);
      PrismaticJoint* slide;
      JointFriction* rub;
      const Matrix3 along = rotation_about({0, 1, 0}, kPi / 2 + slope);  // z down the slope
      Scene scene({0, 0, -kGravity}, [&](SystemGraph& graph) {
        auto& block = graph.add<RigidBody>("block", {.mass = 3, .velocity = v0 * along.col(2)});
        slide = &graph.add<PrismaticJoint>("slide", {graph.ground().marker({}, along), block.marker({}, along)});
        rub = &graph.add<JointFriction>("rub", {slide->displacement()}, {.joint = slide, .coefficient = mu});
      });
      const double start = scene.energy();
      scene.run(*method, end);
      const double a = kGravity * std::sin(slope) - std::copysign(mu, v0) * kGravity * std::cos(slope);
      const double gone = v0 * end + 0.5 * a * end * end;
      EXPECT_NEAR(read(scene, coordinate(slide->displacement(), "s")), gone, 1e-7);
      EXPECT_NEAR(read(scene, coordinate_rate(slide->displacement(), "s")), v0 + a * end, 1e-7);
      EXPECT_NEAR(read(scene, power(*rub)), -mu * 3 * kGravity * std::cos(slope) * std::abs(v0 + a * end), 1e-6);
      EXPECT_NEAR(scene.energy() - start, -mu * 3 * kGravity * std::cos(slope) * std::abs(gone), 1e-6);
    }
}

/// A slide that a drive lifts: its press is m (g + z̈), and so is its friction.
TEST(JointFriction, GrowsWithTheAccelerationThatPresses) {
  const double mu = 0.25, m = 2;
  for (auto& [name, method] : every_method(5e-4)) {
    SCOPED_TRACE(name);
    PrismaticJoint* slide;
    const Matrix3 along_x = rotation_about({0, 1, 0}, kPi / 2);
    Scene scene({0, 0, -kGravity}, [&](SystemGraph& graph) {
      auto& lift = graph.add<RigidBody>("lift", {});
      auto& rail = graph.add<PrismaticJoint>("rail", {graph.ground().marker(), lift.marker()});
      graph.add<CoordinateDrive>("drive", {rail.displacement()}, {.motion = smooth_step(0, 0.5, 0, 1)});
      auto& block = graph.add<RigidBody>("block", {.mass = m, .velocity = {4, 0, 0}});
      slide = &graph.add<PrismaticJoint>("slide", {lift.marker({}, along_x), block.marker({}, along_x)});
      graph.add<JointFriction>("rub", {slide->displacement()}, {.joint = slide, .coefficient = mu});
    });
    scene.run(*method, 0.6);
    const double lifted = smooth_step(0, 0.5, 0, 1)(0.6).rate;  // ∫ z̈ dt
    EXPECT_NEAR(read(scene, coordinate_rate(slide->displacement(), "s")), 4 - mu * (kGravity * 0.6 + lifted), 2e-6);
  }
}

/// The plane pendulum with a dry bearing, whose reaction holds φ̈ itself, by a Runge-Kutta of the test's own:
///   (J + m l²) φ̈ = -m g l sin φ - r μ(r φ̇) N,   N² = (m (l φ̈ + g sin φ))² + (m (l φ̇² + g cos φ))².
struct DryPendulum {
  static constexpr double m = 1.5, l = 0.6, J = 0.1, mu = 0.4, r = 0.05, creep = 0.02;

  static double acceleration(double phi, double rate) {
    double a = 0;
    for (int k = 0; k < 60; ++k) {
      const double N =
          std::hypot(m * (l * a + kGravity * std::sin(phi)), m * (l * rate * rate + kGravity * std::cos(phi)));
      a = (-m * kGravity * l * std::sin(phi) - r * mu * std::tanh(r * rate / creep) * N) / (J + m * l * l);
    }
    return a;
  }
  static std::array<double, 2> after(double end, double phi) {
    const int steps = 20000;
    const double h = end / steps;
    double w = 0;
    for (int i = 0; i < steps; ++i) {
      const double a1 = acceleration(phi, w), w2 = w + h / 2 * a1;
      const double a2 = acceleration(phi + h / 2 * w, w2), w3 = w + h / 2 * a2;
      const double a3 = acceleration(phi + h / 2 * w2, w3), w4 = w + h * a3;
      const double a4 = acceleration(phi + h * w3, w4);
      phi += h / 6 * (w + 2 * w2 + 2 * w3 + w4);
      w += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
    }
    return {phi, w};
  }
};

TEST(JointFriction, DampsAPendulumByItsBearingsReactionWithEveryIntegratorAlike) {
  const double start = 1.2, end = 2;
  const auto [phi, rate] = DryPendulum::after(end, start);
  EXPECT_GT(std::abs(std::cos(phi) - std::cos(start)), 1e-3);
  for (auto& [name, method] : every_method(2e-4, 1e-9)) {
    SCOPED_TRACE(name);
    RevoluteJoint* pin;
    Scene scene({0, -kGravity, 0}, [&](SystemGraph& graph) {
      using P = DryPendulum;
      const Matrix3 A = rotation_about({0, 0, 1}, start);
      auto& rod = graph.add<RigidBody>(
          "rod", {.mass = P::m, .inertia = {P::J, P::J, P::J}, .position = A * Vector3(0, -P::l, 0), .orientation = A});
      pin = &graph.add<RevoluteJoint>("pin", {graph.ground().marker(), rod.marker({0, P::l, 0})});
      graph.add<JointFriction>("rub", {pin->angle()},
                               {.joint = pin, .coefficient = P::mu, .creep_speed = 3 * P::creep, .radius = P::r});
    });
    scene.run(*method, end);
    EXPECT_NEAR(read(scene, coordinate(pin->angle(), "phi")), phi, 1e-6);
    EXPECT_NEAR(read(scene, coordinate_rate(pin->angle(), "phi")), rate, 3e-6);
  }
}

/// Over half a swing dry friction takes the same angle each time, 2 M / (m g l), not the same share.
TEST(JointFriction, TakesEqualAnglesOffEverySmallSwing) {
  const double m = 1, l = 1, mu = 0.2, r = 0.01, start = 0.05;
  RevoluteJoint* pin;
  Scene scene({0, -kGravity, 0}, [&](SystemGraph& graph) {
    const Matrix3 A = rotation_about({0, 0, 1}, start);
    auto& rod = graph.add<RigidBody>(
        "rod", {.mass = m, .inertia = {1e-3, 1e-3, 1e-3}, .position = A * Vector3(0, -l, 0), .orientation = A});
    pin = &graph.add<RevoluteJoint>("pin", {graph.ground().marker(), rod.marker({0, l, 0})});
    graph.add<JointFriction>("rub", {pin->angle()},
                             {.joint = pin, .coefficient = mu, .creep_speed = 3e-6, .radius = r});
  });
  const Method method = runge_kutta(1e-8);
  double last = start;
  const double half = kPi * std::sqrt((l * l * m + 1e-3) / (m * kGravity * l));
  for (int swing = 1; swing <= 4; ++swing) {
    scene.run(*method, swing * half);
    const double now = std::abs(read(scene, coordinate(pin->angle(), "phi")));
    EXPECT_NEAR(last - now, 2 * mu * r, 0.02 * 2 * mu * r) << swing;
    last = now;
  }
}

/// A driven shaft, pressed by a preload: the drive shows μ(s).
TEST(JointFriction, DropsFromStillToDynamicAndGrowsWithViscosity) {
  const double still = 0.5, dynamic = 0.2, r = 0.1, N = 40, viscous = 0.03;
  const std::vector<std::pair<double, double>> curve = {
      {1e-4, 0.5 * std::tanh(0.1)},         // creep, 3 s / v_c = 0.1
      {0.01, 0.2 + 0.3 * std::exp(-0.01)},  // nearly still
      {0.1, 0.2 + 0.3 * std::exp(-1.0)},    // at Stribeck's speed
      {0.5, 0.2 + 0.3 * std::exp(-25.0)},   // sliding
      {-0.1, -(0.2 + 0.3 * std::exp(-1.0))},
  };
  for (const auto& [speed, mu] : curve) {
    CoordinateDrive* drive;
    Scene scene({0, 0, 0}, [&, s = speed](SystemGraph& graph) {
      const Shaft shaft = draw_shaft(graph, "shaft", 1);
      drive = &graph.add<CoordinateDrive>("drive", {shaft.angle()}, {.motion = ramp(0, s / r)});
      graph.add<JointFriction>("rub", {shaft.angle()},
                               {.joint = shaft.pin,
                                .coefficient = dynamic,
                                .static_coefficient = still,
                                .stribeck_speed = 0.1,
                                .creep_speed = 3e-3,
                                .viscous = viscous,
                                .radius = r,
                                .preload = N});
    });
    // the shaft rests on its bearing without a load: N is the preload alone
    const Method method = index2(1e-2);
    scene.run(*method, 0.1);
    EXPECT_NEAR(read(scene, drive_force(*drive)), r * mu * N + viscous * speed / r, 1e-4) << speed;
  }
}

/// A thrust along the axis and a moment across it press a bearing too: N = |F_axial| + |T_lateral| / l.
TEST(JointFriction, IsPressedByThrustAndBending) {
  const double mu = 0.2, r = 0.1, arm = 0.4;
  CoordinateDrive* drive;
  Scene scene({0, 0, 0}, [&](SystemGraph& graph) {
    const Shaft shaft = draw_shaft(graph, "shaft", 1);
    drive = &graph.add<CoordinateDrive>("drive", {shaft.angle()}, {.motion = ramp(0, 10)});
    graph.add<JointFriction>("rub", {shaft.angle()},
                             {.joint = shaft.pin, .coefficient = mu, .radius = r, .bending_arm = arm});
    graph.add<PointForce>("load", {shaft.body->marker()}, {.force = {0, 0, 30}, .torque = {0, 8, 0}});
  });
  const Method method = index2(1e-2);
  scene.run(*method, 0.1);
  EXPECT_NEAR(read(scene, drive_force(*drive)), r * mu * (30 + 8 / arm), 1e-6);
}

TEST(JointFriction, PowerAddsUpToTheEnergyLost) {
  JointFriction* rub;
  Scene scene({0, -kGravity, 0}, [&](SystemGraph& graph) {
    auto& rod = graph.add<RigidBody>("rod", {.mass = 2, .inertia = {0.1, 0.1, 0.1}, .position = {0.5, 0, 0}});
    auto& pin = graph.add<RevoluteJoint>("pin", {graph.ground().marker(), rod.marker({-0.5, 0, 0})});
    rub = &graph.add<JointFriction>("rub", {pin.angle()},
                                    {.joint = &pin, .coefficient = 0.3, .creep_speed = 0.03, .radius = 0.1});
  });
  const double start = scene.energy();
  const Method method = index2(5e-4);
  Recorder recorder{{power(*rub, "power")}};
  Simulation simulation{scene.system, *method};
  simulation.observe(recorder, every_step());
  simulation.run(scene.state, 1);
  const auto t = recorder.table().column("t");
  const auto P = recorder.table().column("power");
  double work = 0;
  for (std::size_t i = 1; i < t.size(); ++i) work += 0.5 * (t[i] - t[i - 1]) * (P[i] + P[i - 1]);
  EXPECT_LT(work, -0.1);
  EXPECT_NEAR(work, scene.energy() - start, 1e-5);
}

/// A shaft turns in two equal bearings, loaded in the middle: its rows are dependent, and each bearing carries half.
/// One of them rubs, with half the weight, whichever it is, and whatever rows a method leaves out: ω̇ = -μ r (m g / 2) /
/// J.
TEST(JointFriction, FeelsReactionsOfLeastNormWhereRowsRepeat) {
  constexpr double kMass = 4, kInertia = 0.02, kRadius = 0.03, kMu = 0.25, kSpeed = 30, kEnd = 0.2;
  const double slowed = kSpeed - kMu * kRadius * kMass * kGravity / 2 / kInertia * kEnd;
  const Matrix3 along_x = rotation_about({0, 1, 0}, kPi / 2);
  for (int rubs : {0, 1})
    for (auto& [name, method] : every_method(1e-3)) {
      SCOPED_TRACE(name + ", bearing " + std::to_string(rubs));
      Scene scene({0, 0, -kGravity}, [&](SystemGraph& graph) {
        auto& shaft = graph.add<RigidBody>(
            "shaft", {.mass = kMass, .inertia = {kInertia, 0.3, 0.3}, .angular_velocity = {kSpeed, 0, 0}});
        for (int i : {0, 1}) {
          const Vector3 at(i == 0 ? -0.5 : 0.5, 0, 0);
          auto& bearing = graph.add<RevoluteJoint>("bearing " + std::to_string(i),
                                                   {graph.ground().marker(at, along_x), shaft.marker(at, along_x)});
          if (i == rubs)
            graph.add<JointFriction>("rub", {bearing.angle()},
                                     {.joint = &bearing, .coefficient = kMu, .creep_speed = 3e-3, .radius = kRadius});
        }
      });
      EXPECT_EQ(scene.system.redundant_rows().size(), 5u);
      ASSERT_NO_FATAL_FAILURE(scene.run(*method, kEnd));
      EXPECT_NEAR(scene.state.v[3], slowed, 1e-6 * kSpeed);  // without friction, or with all the weight: 5 % off
    }
}

/// A carriage that falls along a post, drawn down by a force beside its weight, and lands; a load slides on it. Pressed
/// by its weight the load loses μ (a - g) t, by the landing, which turns the reaction round, μ (1 + e) v, or all that
/// it has: Moreau-Jean's factor took the landing's part with the wrong sign, and generalized-alpha felt none of it.
TEST(JointFriction, IsPressedByImpulsesOfContact) {
  constexpr double kMass = 2, kCarriage = 3, kPull = 30, kGap = 0.05, kBounce = 0.4, kMu = 0.2;
  const double a = kGravity + kPull / (kCarriage + kMass), v = std::sqrt(2 * a * kGap), end = v / a + 0.01;
  const double taken = kMu * ((a - kGravity) * end + (1 + kBounce) * v);
  for (const double slide : {3.0, 0.2})
    for (const double h : {1e-3, 2.5e-4})
      for (auto& [name, method] : coulomb_friction::methods(h)) {
        SCOPED_TRACE(name + ", sliding at " + std::to_string(slide) + ", h = " + std::to_string(h));
        Scene scene({0, 0, -kGravity}, [&, slide = slide](SystemGraph& graph) {
          auto& carriage =
              graph.add<RigidBody>("carriage", {.mass = kCarriage, .inertia = {1, 1, 1}, .position = {0, 0, 1}});
          auto& load = graph.add<RigidBody>(
              "load", {.mass = kMass, .inertia = {1, 1, 1}, .position = {0, 0, 1}, .velocity = {slide, 0, 0}});
          graph.add<PrismaticJoint>("post", {graph.ground().marker({0, 0, 1}), carriage.marker()});
          const Matrix3 along = rotation_about({0, 1, 0}, kPi / 2);
          auto& guide = graph.add<PrismaticJoint>("guide", {carriage.marker({}, along), load.marker({}, along)});
          graph.add<PointForce>("pull", {carriage.marker()}, {.force = {0, 0, -kPull}});
          graph.add<JointFriction>("rub", {guide.displacement()},
                                   {.joint = &guide, .coefficient = kMu, .creep_speed = 3e-3});
          graph.add<Contact>("floor",
                             std::vector<Collider>{{graph.ground().marker(), shape::half_space()},
                                                   {carriage.marker(), shape::sphere(1 - kGap)}},
                             Contact::Parameters{.law = RigidSurfaces{.restitution = kBounce}});
        });
        scene.run(*method, end);
        EXPECT_NEAR(scene.state.v[2], kBounce * v - a * 0.01, 1e-9) << "it has bounced";
        if (slide > 1) {
          // Of the step with the impact both loads, which are opposite, count together.
          EXPECT_NEAR(slide - scene.state.v[6], taken, 2 * kMu * (a - kGravity) * h);
        } else {
          EXPECT_GE(scene.state.v[6], 0) << "what friction stops does not turn back";
          EXPECT_LT(scene.state.v[6], 1e-3) << "below the creep speed";
        }
      }
}

/// A rod in a sleeve that tumbles on rigid ground, its pin rubbing by its reaction: both methods of time stepping go to
/// one answer with shorter steps.
TEST(JointFriction, GoesToOneAnswerByBothMethodsOfTimeStepping) {
  double last = 0;
  for (const double h : {1e-3, 2.5e-4, 6.25e-5}) {
    double energies[2] = {};
    int k = 0;
    for (auto& [name, method] : coulomb_friction::methods(h)) {
      Scene scene({0, 0, -kGravity}, [&](SystemGraph& graph) {
        const Matrix3 axes = rotation_about({1, 2, 3}, 0.5);
        const Vector3 spin(3, -5, 2), apart(0, 0, 0.4), velocity(1, 0, -1);
        auto& sleeve = graph.add<RigidBody>("sleeve", {.mass = 1,
                                                       .inertia = {0.01, 0.02, 0.03},
                                                       .position = {0, 0, 1},
                                                       .orientation = axes,
                                                       .velocity = velocity,
                                                       .angular_velocity = spin});
        auto& rod = graph.add<RigidBody>("rod", {.mass = 1,
                                                 .inertia = {0.02, 0.01, 0.01},
                                                 .position = Vector3::UnitZ() + axes * apart,
                                                 .orientation = axes,
                                                 .velocity = velocity + axes * (spin.cross(apart) + Vector3(0, 0, 2)),
                                                 .angular_velocity = spin});
        auto& slide = graph.add<PrismaticJoint>("slide", {sleeve.marker(), rod.marker()});
        graph.add<JointFriction>("rub", {slide.displacement()},
                                 {.joint = &slide, .coefficient = 0.3, .creep_speed = 0.01, .radius = 0.05});
        graph.add<Contact>(
            "floor",
            std::vector<Collider>{{graph.ground().marker(), shape::half_space(), 0, groups({1})},
                                  {sleeve.marker({0.1, 0, 0}), shape::sphere(0.1), 1, groups({0})},
                                  {rod.marker({0, 0.1, 0}), shape::sphere(0.1), 1, groups({0})}},
            Contact::Parameters{.law = RigidSurfaces{.restitution = 0.5}, .friction = {.coefficient = 0.3}});
      });
      scene.run(*method, 0.6);
      energies[k++] = scene.energy();
    }
    const double apart = std::abs(energies[0] - energies[1]);
    expect_below("energies apart at h = " + std::to_string(h) + ", J", apart, 2e-3 * h);
    if (last > 0) {
      EXPECT_LT(apart, 0.2 * last) << h;
    }
    last = apart;
  }
}

}  // namespace
}  // namespace lithe::test::friction_test
