#include <gtest/gtest.h>

#include "engine/assembly/evaluator.h"
#include "engine/observe/recorder.h"
#include "engine/run/simulation.h"
#include "integrators/moreau_jean.h"
#include "integrators/nonsmooth_generalized_alpha.h"
#include "joints/contact/contact.h"
#include "joints/contact/shapes.h"
#include "joints/coordinate_drive.h"
#include "joints/cylindrical_joint.h"
#include "joints/forces/coordinate_motor.h"
#include "joints/forces/coordinate_spring.h"
#include "joints/forces/joint_coulomb_friction.h"
#include "joints/forces/joint_friction.h"
#include "joints/point_on_line_joint.h"
#include "joints/prismatic_joint.h"
#include "joints/screw_joint.h"
#include "joints/spherical_joint.h"
#include "tests/joints/friction_checks.h"
#include "tests/joints/mechanisms.h"
#include "tests/support/message_of.h"
#include "tests/support/pairs.h"

/// Set-valued friction in joints, by time stepping.
namespace lithe::test::joint_coulomb_friction_test {
namespace {

constexpr double kGravity = 9.81;
using Friction = JointCoulombFriction::Parameters;

std::vector<NamedMethod> methods(double h) {
  std::vector<NamedMethod> all;
  all.push_back({"Moreau-Jean", std::make_unique<MoreauJean>(MoreauJean::Parameters{.step = h})});
  all.push_back({"nonsmooth generalized-alpha",
                 std::make_unique<NonsmoothGeneralizedAlpha>(NonsmoothGeneralizedAlpha::Parameters{.step = h})});
  return all;
}

JointCoulombFriction& rub(SystemGraph& graph, const std::vector<JointCoordinate>& coordinates, const Constraint& joint,
                          Friction p) {
  p.joint = &joint;
  return add_joint_coulomb_friction(graph, "rub", coordinates, std::move(p));
}

/// A block of 2 kg on a slide that goes down by `slope` rad.
struct Block {
  using Pull = std::function<double(double time, double place, double speed)>;

  Block(double slope, const Friction& friction, const Pull& pull = nullptr, double speed = 0, double place = 0)
      : scene({0, 0, -kGravity}, [&](SystemGraph& graph) {
          const Matrix3 along = rotation_about({0, 1, 0}, kPi / 2 + slope);  // z down the slope
          auto& block = graph.add<RigidBody>(
              "block", {.mass = kMass, .position = place * along.col(2), .velocity = speed * along.col(2)});
          slide = &graph.add<PrismaticJoint>("slide", {graph.ground().marker({}, along), block.marker({}, along)});
          rubs = &rub(graph, {slide->displacement()}, *slide, friction);
          if (pull) graph.add<CoordinateMotor>("pull", {slide->displacement()}, {.effort = pull});
        }) {}
  double place() const { return read(scene, coordinate(slide->displacement(), "s")); }
  double speed() const { return read(scene, coordinate_rate(slide->displacement(), "s")); }

  static constexpr double kMass = 2;
  PrismaticJoint* slide = nullptr;
  JointCoulombFriction* rubs = nullptr;
  Scene scene;
};

TEST(JointCoulombFriction, KnowsItsDerivatives) {
  for (const Pair& pair : pairs()) {
    SCOPED_TRACE(pair.name);
    const Friction coarse{.coefficient = 0.4, .viscous = 0.1, .radius = 0.4, .bending_arm = 0.6, .preload = 2};
    {
      SystemGraph graph;
      auto& pin = graph.add<RevoluteJoint>("pin", pair.draw(graph, {0, 0, 0}));
      rub(graph, {pin.angle()}, pin, coarse);
      check_friction_tangent(graph);
    }
    {
      SystemGraph graph;
      auto& sleeve = graph.add<CylindricalJoint>("sleeve", pair.draw(graph, {0, 0, 0.3}));
      rub(graph, {sleeve.angle(), sleeve.displacement()}, sleeve, coarse);
      check_friction_tangent(graph);
    }
    SystemGraph graph;
    auto& ball = graph.add<SphericalJoint>("ball", pair.draw(graph, {0, 0, 0}));
    rub(graph, {}, ball, coarse);
    check_friction_tangent(graph);
  }
}

TEST(JointCoulombFriction, HoldsABlockOnASlopeForAMinuteWithoutCreep) {
  for (auto& [name, method] : methods(1e-2)) {
    SCOPED_TRACE(name);
    Block block(0.28, {.coefficient = 0.3});  // tan 0.28 = 0.2876
    block.scene.run(*method, 60);
    expect_below(name + ": creep in a minute, m", std::abs(block.place()), 1e-12);
    expect_below(name + ": speed, m/s", std::abs(block.speed()), 1e-13);
    EXPECT_NEAR(read(block.scene, reaction(*block.slide, 1), 2), Block::kMass * kGravity * std::pow(std::cos(0.28), 2),
                1e-6);
  }
}

/// A pull that rises to 0.999 of μ_s m g is held, by 1.001 of it it slides away.
TEST(JointCoulombFriction, BreaksAwayAtTheStaticForce) {
  constexpr double kMuS = 0.4, kWeight = Block::kMass * kGravity;
  for (const double share : {0.999, 1.001})
    for (auto& [name, method] : methods(2e-3)) {
      SCOPED_TRACE(name + ", " + std::to_string(share));
      Block block(0, {.coefficient = 0.3, .static_coefficient = kMuS, .stribeck_speed = 1e-2},
                  [&](double t, double, double) { return share * kMuS * kWeight * smooth_step(0, 1, 0, 5)(t).value; });
      block.scene.run(*method, 12);
      if (share < 1)
        EXPECT_LT(std::abs(block.place()), 1e-12);
      else
        EXPECT_GT(block.place(), 1);
    }
}

/// Slides by v₀² / (2 μ g), stops to round-off, and rests.
TEST(JointCoulombFriction, StopsASlidingBlock) {
  constexpr double kMu = 0.3, kSpeed = 1.5, h = 1e-3;
  for (auto& [name, method] : methods(h)) {
    SCOPED_TRACE(name);
    Block block(0, {.coefficient = kMu}, nullptr, kSpeed);
    Recorder recorder{{power(*block.rubs, "power"), kinetic_energy("energy")}};
    Simulation simulation{block.scene.system, *method};
    simulation.observe(recorder, every_step());
    simulation.run(block.scene.state, 0.4);
    EXPECT_NEAR(block.speed(), kSpeed - 0.4 * kMu * kGravity, 1e-12);
    EXPECT_NEAR(block.place(), 0.4 * (kSpeed + block.speed()) / 2, 1e-12);
    EXPECT_NEAR(recorder.table().column("power").back(), -kMu * Block::kMass * kGravity * block.speed(), 1e-9);
    simulation.run(block.scene.state, 2);
    // The last step of the slide: v h / 2 instead of v² / (2 μ g), less than μ g h² / 8 off.
    EXPECT_NEAR(block.place(), kSpeed * kSpeed / (2 * kMu * kGravity), kMu * kGravity * h * h / 8);
    EXPECT_LT(std::abs(block.speed()), 1e-14);
    const auto energy = recorder.table().column("energy");
    for (std::size_t i = 1; i < energy.size(); ++i) EXPECT_LE(energy[i], energy[i - 1] + 1e-14);
  }
}

/// C06: 1 kg on 100 N/m, a belt at 0.5 m/s, coefficients of 0.4 and 0.3.
TEST(JointCoulombFriction, HasThePeriodOfABlockOnABelt) {
  constexpr double kBelt = 0.5, kStiffness = 100, kPeriod = 0.62881071913377278895, kStart = 1.962e-2;
  for (const double h : {1e-3, 2e-4})
    for (auto& [name, method] : methods(h)) {
      SCOPED_TRACE(name);
      Scene scene({0, 0, -kGravity}, [&](SystemGraph& graph) {
        const Matrix3 along = rotation_about({0, 1, 0}, kPi / 2);
        auto& belt = graph.add<RigidBody>("belt", {.mass = 10, .velocity = {kBelt, 0, 0}});
        auto& guide = graph.add<PrismaticJoint>("guide", {graph.ground().marker({}, along), belt.marker({}, along)});
        graph.add<CoordinateDrive>("drive", {guide.displacement()}, {.motion = ramp(0, kBelt)});
        auto& block = graph.add<RigidBody>("block", {.mass = 1, .position = {kStart, 0, 0}, .velocity = {kBelt, 0, 0}});
        auto& slide = graph.add<PrismaticJoint>("slide", {belt.marker({}, along), block.marker({}, along)});
        rub(graph, {slide.displacement()}, slide,
            {.coefficient = 0.3, .static_coefficient = 0.4, .stribeck_speed = 1e-9});
        graph.add<CoordinateSpring>("spring",
                                    {displacement_between(graph.ground().marker({}, along), block.marker({}, along))},
                                    {.stiffness = kStiffness, .free_value = 0});
      });
      std::vector<double> passes;  // downwards through the middle of the slip
      double before = kStart - 0.03;
      int changes = 0;
      bool sticks = true;
      for (int i = 1; i * h < 3.5 * kPeriod; ++i) {
        scene.run(*method, i * h);
        const double now = scene.state.q[7] - 0.3 * kGravity / kStiffness;
        if (before >= 0 && now < 0) passes.push_back((i - 1 + before / (before - now)) * h);
        before = now;
        const bool rests = std::abs(scene.state.v[6] - scene.state.v[0]) < 1e-12;
        changes += rests != sticks;
        sticks = rests;
      }
      ASSERT_EQ(passes.size(), 3u);
      expect_below(name + ": period of the belt at h = " + std::to_string(h) + ", s",
                   std::abs((passes[2] - passes[0]) / 2 - kPeriod), 2.5e-5);
      EXPECT_EQ(changes, 2 * 3 + 1) << "two a cycle: no chatter";
    }
}

/// A disc with its mass off the pin: N = m l ω² r makes J ω̇ = -ρ μ m l ω², ω = ω₀ / (1 + ω₀ t ρ μ m l / J).
double spun(Integrator& method, double time) {
  constexpr double kMass = 2, kOff = 0.3, kInertia = 0.05, kMu = 0.4, kRadius = 0.05;
  RevoluteJoint* pin = nullptr;
  Scene scene({0, 0, 0}, [&](SystemGraph& graph) {
    auto& body = graph.add<RigidBody>("body", {.mass = kMass,
                                               .inertia = {1, 1, kInertia},
                                               .position = {kOff, 0, 0},
                                               .velocity = {0, 5 * kOff, 0},
                                               .angular_velocity = {0, 0, 5}});
    pin = &graph.add<RevoluteJoint>("pin", {graph.ground().marker(), body.marker({-kOff, 0, 0})});
    rub(graph, {pin->angle()}, *pin, {.coefficient = kMu, .radius = kRadius});
  });
  scene.run(method, time);
  const double rate = kRadius * kMu * kMass * kOff;
  // The force across, m l ω̇, presses too: N = m l sqrt(ω⁴ + ω̇²), ω̇ = -c ω² with c J = ρ μ m l sqrt(1 + c²).
  double c = 0;
  for (int i = 0; i < 60; ++i) c = rate * std::sqrt(1 + c * c) / (kInertia + kMass * kOff * kOff);
  return read(scene, coordinate_rate(pin->angle(), "w")) - 5 / (1 + 5 * c * time);
}

TEST(JointCoulombFriction, IsPressedByCentrifugalForcesToSecondOrder) {
  const auto coarse = methods(1e-2), fine = methods(5e-3);
  for (std::size_t i = 0; i < coarse.size(); ++i) {
    SCOPED_TRACE(coarse[i].name);
    const double first = std::abs(spun(*coarse[i].integrator, 1)), second = std::abs(spun(*fine[i].integrator, 1));
    expect_below(coarse[i].name + ": spin of an eccentric disc at h = 1e-2, rad/s", first, 1e-3);
    EXPECT_LT(second, first / 3);
  }
}

/// A sleeve that turns and slides on a level shaft: with J = m r² it slows down along a straight line of (r φ, x), by
/// μ g, and stops.
TEST(JointCoulombFriction, StopsSleevesOnTheirHelix) {
  constexpr double kMass = 2, kRadius = 0.1, kMu = 0.2, kAlong = 0.9, kAround = 1.2, kEnd = 0.5;  // 1.5 m/s
  constexpr double kShare = 1 - kMu * kGravity * kEnd / 1.5;                                      // of the speed
  for (auto& [name, method] : methods(1e-3)) {
    SCOPED_TRACE(name);
    const Matrix3 along = rotation_about({0, 1, 0}, kPi / 2);
    CylindricalJoint* sleeve = nullptr;
    Scene scene({0, 0, -kGravity}, [&](SystemGraph& graph) {
      auto& body = graph.add<RigidBody>("body", {.mass = kMass,
                                                 .inertia = {kMass * kRadius * kRadius, 0.02, 0.02},
                                                 .velocity = {kAlong, 0, 0},
                                                 .angular_velocity = {kAround / kRadius, 0, 0}});
      sleeve = &graph.add<CylindricalJoint>("sleeve", {graph.ground().marker({}, along), body.marker({}, along)});
      rub(graph, {sleeve->angle(), sleeve->displacement()}, *sleeve, {.coefficient = kMu, .radius = kRadius});
    });
    const auto rate = [&](const JointCoordinate& x) { return read(scene, coordinate_rate(x, "x")); };
    scene.run(*method, kEnd);
    EXPECT_NEAR(rate(sleeve->displacement()), kShare * kAlong, 1e-11);
    EXPECT_NEAR(kRadius * rate(sleeve->angle()), kShare * kAround, 1e-11);
    EXPECT_NEAR(read(scene, coordinate(sleeve->displacement(), "x")), kAlong * kEnd * (1 + kShare) / 2, 1e-11);
    scene.run(*method, 2);
    EXPECT_LT(std::hypot(rate(sleeve->displacement()), kRadius * rate(sleeve->angle())), 1e-13);
  }
}

/// A nut on an upright screw: m z̈ = -m g + N (cos λ + μ sin λ), J φ̈ = r N (μ cos λ - sin λ), z̈ = tan λ r φ̈. On a flat
/// one, tan λ < μ, it rests.
TEST(JointCoulombFriction, HoldsNutsOnFlatScrewsOnly) {
  constexpr double kMass = 3, kInertia = 0.01, kRadius = 0.02, kMu = 0.2;
  for (const double tan_lead : {0.999 * kMu, 0.5})
    for (auto& [name, method] : methods(1e-3)) {
      SCOPED_TRACE(name + ", lead " + std::to_string(tan_lead));
      ScrewJoint* screw = nullptr;
      Scene scene({0, 0, -kGravity}, [&](SystemGraph& graph) {
        auto& nut = graph.add<RigidBody>("nut", {.mass = kMass, .inertia = {0.01, 0.01, kInertia}});
        screw = &graph.add<ScrewJoint>("screw", {graph.ground().marker(), nut.marker()},
                                       {.lead = 2 * kPi * kRadius * tan_lead});
        rub(graph, {screw->angle(), screw->displacement()}, *screw, {.coefficient = kMu, .radius = kRadius});
      });
      scene.run(*method, 1);
      const double z = read(scene, coordinate(screw->displacement(), "z"));
      if (tan_lead < kMu) {
        EXPECT_LT(std::abs(z), 1e-13);
        continue;
      }
      const double c = 1 / std::hypot(1, tan_lead), s = tan_lead * c, up = c + kMu * s, turn = kMu * c - s;
      const double N = kMass * kGravity / (up - kMass * kRadius * kRadius * tan_lead / kInertia * turn);
      EXPECT_NEAR(z, (-kGravity + N * up / kMass) / 2, 1e-6);
    }
}

/// A ball that spins about a slanted axis, held at its centre: J ω̇ = -r μ m g along its axis, until it rests.
TEST(JointCoulombFriction, StopsBallsAboutTheirOwnAxis) {
  constexpr double kMass = 2, kInertia = 0.03, kRadius = 0.05, kMu = 0.3, kSpin = 7, kEnd = 0.4;
  const Vector3 axis = Vector3(1, 2, -2) / 3;
  for (auto& [name, method] : methods(1e-3)) {
    SCOPED_TRACE(name);
    RigidBody* body = nullptr;
    Scene scene({0, 0, -kGravity}, [&](SystemGraph& graph) {
      body = &graph.add<RigidBody>(
          "body",
          {.mass = kMass, .inertia = {kInertia, kInertia, kInertia}, .angular_velocity = Vector3(kSpin * axis)});
      auto& ball = graph.add<SphericalJoint>("ball", {graph.ground().marker(), body->marker()});
      rub(graph, {}, ball, {.coefficient = kMu, .radius = kRadius});
    });
    const auto spin = [&] { return read_vector(scene, angular_velocity(body->marker(), "w")); };
    scene.run(*method, kEnd);
    EXPECT_LT((spin() - (kSpin - kRadius * kMu * kMass * kGravity / kInertia * kEnd) * axis).norm(), 1e-10);
    scene.run(*method, 2);
    EXPECT_LT(spin().norm(), 1e-12);
  }
}

/// C07 in a joint: the tip of a leaning rod in a slot, which presses either way. The tip leads with 1 m/s. With N
/// upwards p N + b = 0, p = 1 + 3 cos² - 3 μ sin cos; with N downwards, -(1 + 3 cos² + 3 μ sin cos) |N| + b = 0. From μ
/// = 4/3 on (p <= 0) it jams: the tip stops in no time, as an impact at the tip has it.
struct PainleveRod {
  PainleveRod(double friction, double omega)
      : scene({0, 0, -kGravity}, [&](SystemGraph& graph) {
          const Vector3 arm(std::cos(kLean) / 2, 0, std::sin(kLean) / 2), turn(0, -omega, 0);
          const Matrix3 along = rotation_about({0, 1, 0}, kPi / 2);
          auto& rod = graph.add<RigidBody>("rod", {.mass = 1,
                                                   .inertia = {1, 1.0 / 12, 1},
                                                   .position = arm,
                                                   .velocity = Vector3(-1, 0, 0) + turn.cross(arm),
                                                   .angular_velocity = turn});
          slot = &graph.add<PointOnLineJoint>("slot", {graph.ground().marker({}, along), rod.marker(-arm)});
          rub(graph, {slot->displacement()}, *slot, {.coefficient = friction});
          spin = angle_between(graph.ground().marker(), rod.marker(), 1);
        }) {}
  double tip() const { return read(scene, coordinate_rate(slot->displacement(), "s")); }
  double turning() const { return -read(scene, coordinate_rate(spin, "w")); }
  double energy() { return scene.energy(); }

  inline static const double kLean = std::atan(2.0);
  PointOnLineJoint* slot = nullptr;
  JointCoordinate spin;
  Scene scene;
};

TEST(JointCoulombFriction, LetsPainlevesRodSlideOrJam) {
  constexpr double h = 1e-5, sin_cos = 0.4, cos_2 = 0.2;
  for (const double mu : {0.5, 1.2, 1.4, 1.8})
    for (const double omega : {0.0, 8.0})
      for (auto& [name, method] : methods(h)) {
        SCOPED_TRACE(name + ", friction " + std::to_string(mu) + ", omega " + std::to_string(omega));
        PainleveRod rod(mu, omega);
        const double energy = rod.energy();
        rod.scene.run(*method, h);
        EXPECT_LT(rod.energy(), energy + 1e-9);
        if (mu > 4.0 / 3) {
          EXPECT_LT(std::abs(rod.tip()), 1e-11) << "jams";
          // Angular momentum about the tip, of a mass in its middle that moved with -1 m/s: (1/12 + 1/4) Δω = sin / 2.
          EXPECT_NEAR(rod.turning() - omega, 1.5 * std::sin(PainleveRod::kLean), 1e-3);
          continue;
        }
        const double b = omega * omega / 2 * std::sin(PainleveRod::kLean) - kGravity, up = 1 + 3 * cos_2,
                     N = b < 0 ? -b / (up - 3 * mu * sin_cos) : b / (up + 3 * mu * sin_cos);
        // At the tip: ẍ = (1 + 3 sin²) μ N + 3 sin cos N_up + ω²/2 cos. (N_up: with its sign.)
        const double tip = (1 + 3 * (1 - cos_2)) * mu * N - 3 * sin_cos * (b < 0 ? N : -N) +
                           omega * omega / 2 * std::cos(PainleveRod::kLean);
        EXPECT_NEAR((rod.tip() + 1) / h, tip, 2e-3 * std::abs(tip) + 1e-2);
      }
}

/// A slider on an arm that turns at 3 rad/s is held against m r ω² by its slot, m g, and stays where it is.
TEST(JointCoulombFriction, HoldsASliderOnAnArmThatTurns) {
  for (auto& [name, method] : methods(1e-3)) {
    SCOPED_TRACE(name);
    PrismaticJoint* slide = nullptr;
    Scene scene({0, 0, -kGravity}, [&](SystemGraph& graph) {
      const Matrix3 along = rotation_about({0, 1, 0}, kPi / 2);
      auto& arm = graph.add<RigidBody>("arm", {.mass = 5, .angular_velocity = {0, 0, 3}});
      graph.add<RevoluteJoint>("hub", {graph.ground().marker(), arm.marker()});
      auto& block = graph.add<RigidBody>(
          "block", {.mass = 1, .position = {0.5, 0, 0}, .velocity = {0, 1.5, 0}, .angular_velocity = {0, 0, 3}});
      slide = &graph.add<PrismaticJoint>("slide", {arm.marker({}, along), block.marker({}, along)});
      // r ω² = 4.5 m/s²; kinetic friction alone would not hold it
      rub(graph, {slide->displacement()}, *slide,
          {.coefficient = 0.3, .static_coefficient = 0.5, .stribeck_speed = 1e-9});
    });
    scene.run(*method, 10);
    expect_below(name + ": creep of a slider on an arm that turns, in 10 s, m",
                 std::abs(read(scene, coordinate(slide->displacement(), "s")) - 0.5), 1e-9);
  }
}

/// A crank and slider out of plane pins that repeat rows, friction in all joints, against regularised friction by
/// Radau, while it runs.
TEST(JointCoulombFriction, RunsACrankAndSliderAsRegularisedFrictionDoes) {
  enum class Law { set_valued, regularised };
  struct Crank {
    explicit Crank(Law law)
        : scene({0, 0, -kGravity}, [&](SystemGraph& graph) {
            const Matrix3 pins = rotation_about({1, 0, 0}, kPi / 2), along = rotation_about({0, 1, 0}, kPi / 2);
            auto& crank =
                graph.add<RigidBody>("crank", {.mass = 1, .inertia = {0.1, 0.1, 0.1}, .angular_velocity = {0, -15, 0}});
            auto& rod = graph.add<RigidBody>("rod", {.mass = 0.5,
                                                     .inertia = {0.001, 0.01, 0.01},
                                                     .position = {0.35, 0, 0},
                                                     .velocity = {0, 0, 0.75},
                                                     .angular_velocity = {0, 15 * 0.1 / 0.5 * 1.0, 0}});
            auto& slider = graph.add<RigidBody>("slider", {.mass = 0.7, .position = {0.6, 0, 0}});
            main = &graph.add<RevoluteJoint>("main", {graph.ground().marker({}, pins), crank.marker({}, pins)});
            auto& big =
                graph.add<RevoluteJoint>("big", {crank.marker({0.1, 0, 0}, pins), rod.marker({-0.25, 0, 0}, pins)});
            auto& small = graph.add<RevoluteJoint>("small", {rod.marker({0.25, 0, 0}, pins), slider.marker({}, pins)});
            auto& slide =
                graph.add<PrismaticJoint>("slide", {graph.ground().marker({}, along), slider.marker({}, along)});
            const auto add = [&](const std::string& name, const Constraint& joint, const JointCoordinate& x, double r) {
              if (law == Law::set_valued)
                add_joint_coulomb_friction(graph, name, {x}, {.joint = &joint, .coefficient = 0.2, .radius = r});
              else
                graph.add<JointFriction>(name, {x},
                                         {.joint = &joint, .coefficient = 0.2, .creep_speed = 1e-5, .radius = r});
            };
            add("rub main", *main, main->angle(), 0.02);
            add("rub big", big, big.angle(), 0.02);
            add("rub small", small, small.angle(), 0.02);
            add("rub slide", slide, slide.displacement(), 0);
          }) {}
    double speed() const { return read(scene, coordinate_rate(main->angle(), "w")); }
    RevoluteJoint* main = nullptr;
    Scene scene;
  };
  Crank regularised(Law::regularised);
  const double start = regularised.speed();
  const Method reference = radau(1e-8);
  regularised.scene.run(*reference, 0.3);
  ASSERT_GT(std::abs(start - regularised.speed()), 0.5) << "friction counts";
  for (auto& [name, method] : methods(2e-4)) {
    Crank crank(Law::set_valued);
    crank.scene.run(*method, 0.3);
    expect_below(name + ": speed of a crank with friction, rad/s", std::abs(crank.speed() - regularised.speed()), 5e-3);
  }
}

/// What acted in the last step is in the state: a run resumed from a checkpoint continues with the same bits.
TEST(JointCoulombFriction, IsResumedBitForBit) {
  const std::string path = testing::TempDir() + "joint_coulomb_friction.checkpoint";
  const auto first = methods(1e-3), again = methods(1e-3);
  for (std::size_t i = 0; i < first.size(); ++i) {
    SCOPED_TRACE(first[i].name);
    const auto pull = [](double t, double, double) { return 12 * std::sin(20 * t); };  // sticks and slides
    const Friction friction{.coefficient = 0.3, .static_coefficient = 0.4};
    Block block(0, friction, pull), copy(0, friction, pull);
    Simulation simulation{block.scene.system, *first[i].integrator}, resumed{copy.scene.system, *again[i].integrator};
    simulation.run(block.scene.state, 0.3);
    simulation.save(block.scene.state, path);
    State state = resumed.resume(path);
    simulation.run(block.scene.state, 0.7);
    resumed.run(state, 0.7);
    EXPECT_GT(std::abs(block.place()), 1e-4);
    EXPECT_TRUE(same(state, block.scene.state));
  }
}

TEST(JointCoulombFriction, BadInputNamesWhatIsWrong) {
  SystemGraph graph;
  auto& body = graph.add<RigidBody>("body", {});
  auto& slide = graph.add<PrismaticJoint>("slide", {graph.ground().marker(), body.marker()});
  const auto says = [&](const Friction& p, const std::string& word) {
    expect_says(
        message_of<SceneError>([&] { add_joint_coulomb_friction(graph, "bad " + word, {slide.displacement()}, p); }),
        {"'bad", word});
  };
  says({}, "joint");
  says({.joint = &slide, .coefficient = -1}, "coefficient");
  says({.joint = &slide, .coefficient = 0.3, .static_coefficient = 0.2}, "static_coefficient");
  says({.joint = &slide, .coefficient = 0.3, .stribeck_speed = 0}, "stribeck_speed");
  says({.joint = &slide, .coefficient = 0.3, .viscous = -1}, "viscous");

  Block block(0.1, {.coefficient = 0.3});
  Method method = radau(1e-6);
  expect_says(message_of<SceneError>([&] { block.scene.run(*method, 1); }), {"set-valued", "JointBristles"});

  Scene both({0, 0, -kGravity}, [&](SystemGraph& drawn) {
    auto& cube = drawn.add<RigidBody>("cube", {});
    auto& guide = drawn.add<PrismaticJoint>("guide", {drawn.ground().marker(), cube.marker()});
    rub(drawn, {guide.displacement()}, guide, {.coefficient = 0.3});
    drawn.add<Contact>("floor",
                       std::vector<Collider>{{drawn.ground().marker(), shape::half_space()},
                                             {cube.marker({0, 0, 1}), shape::sphere(0.1)}},
                       Contact::Parameters{.law = RigidSurfaces{}});
  });
  for (auto& [name, stepper] : methods(1e-3))
    expect_says(message_of<SceneError>([&] { both.run(*stepper, 1); }), {"contacts of rigid surfaces"});
}

}  // namespace
}  // namespace lithe::test::joint_coulomb_friction_test
