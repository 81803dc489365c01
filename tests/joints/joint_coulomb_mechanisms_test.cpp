#include <gtest/gtest.h>

#include "joints/cylindrical_joint.h"
#include "joints/forces/joint_friction.h"
#include "joints/point_on_line_joint.h"
#include "joints/prismatic_joint.h"
#include "joints/screw_joint.h"
#include "joints/spherical_joint.h"
#include "joints/universal_joint.h"
#include "tests/joints/coulomb_friction_scenes.h"

/// Set-valued friction in pins, sleeves, screws, balls and mechanisms.
namespace lithe::test::joint_coulomb_mechanisms_test {
namespace {

constexpr double kGravity = 9.81;
using coulomb_friction::methods, coulomb_friction::rub;

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

TEST(JointCoulombMechanisms, IsPressedByCentrifugalForcesToSecondOrder) {
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
TEST(JointCoulombMechanisms, StopsSleevesOnTheirHelix) {
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
TEST(JointCoulombMechanisms, HoldsNutsOnFlatScrewsOnly) {
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
TEST(JointCoulombMechanisms, StopsBallsAboutTheirOwnAxis) {
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

/// A body on both pins of a universal joint; its centre `off` from the joint.
struct Cross {
  static constexpr double kMass = 2, kInertia = 0.03, kRadius = 0.05, kMu = 0.3;

  Cross(const Vector3& off, const Vector3& spin)
      : scene({0, 0, -kGravity}, [&](SystemGraph& graph) {
          auto& body = graph.add<RigidBody>("body", {.mass = kMass,
                                                     .inertia = {kInertia, kInertia, kInertia},
                                                     .position = off,
                                                     .velocity = spin.cross(off),
                                                     .angular_velocity = spin});
          cross = &graph.add<UniversalJoint>("cross", {graph.ground().marker(), body.marker(-off)});
          for (const auto& [name, pin] :
               {std::pair("first", cross->first_angle()), std::pair("second", cross->second_angle())})
            add_joint_coulomb_friction(graph, name, {pin}, {.joint = cross, .coefficient = kMu, .radius = kRadius});
        }) {}
  double turned(int pin) const { return read(scene, coordinate(at(pin), "x")); }
  double rate(int pin) const { return read(scene, coordinate_rate(at(pin), "w")); }
  JointCoordinate at(int pin) const { return pin == 0 ? cross->first_angle() : cross->second_angle(); }

  UniversalJoint* cross = nullptr;
  Scene scene;
};

/// Turning about one arm, level all the while, J ω̇ = -r μ m g; the other pin sticks.
TEST(JointCoulombMechanisms, StopsEitherPinOfAUniversalJoint) {
  constexpr double kSpin = 5, kEnd = 0.3,
                   kSlow = Cross::kRadius * Cross::kMu * Cross::kMass * kGravity / Cross::kInertia;
  for (const int pin : {0, 1})
    for (auto& [name, method] : methods(1e-3)) {
      SCOPED_TRACE(name + ", pin " + std::to_string(pin));
      Cross scene(Vector3::Zero(), kSpin * Vector3::Unit(pin));
      scene.scene.run(*method, kEnd);
      EXPECT_NEAR(scene.rate(pin), kSpin - kSlow * kEnd, 1e-10);
      EXPECT_NEAR(scene.turned(pin), kEnd * (kSpin - kSlow * kEnd / 2), 1e-10);
      scene.scene.run(*method, 2);
      EXPECT_LT(std::abs(scene.rate(pin)), 1e-12);
      EXPECT_LT(std::abs(scene.turned(1 - pin)), 1e-12);
    }
}

/// The weight off both arms is held up to m g l = r μ m g at either; beyond, that pin gives way.
TEST(JointCoulombMechanisms, PinsOfAUniversalJointBreakAwayOneByOne) {
  const double holds = Cross::kMu * Cross::kRadius;
  for (const double first : {0.99, 1.01})
    for (const double second : {0.99, 1.01})
      for (auto& [name, method] : methods(1e-2)) {
        SCOPED_TRACE(name + ", " + std::to_string(first) + " and " + std::to_string(second));
        Cross scene(holds * Vector3(second, first, 0), Vector3::Zero());
        scene.scene.run(*method, 1);
        for (const int pin : {0, 1}) {
          if ((pin == 0 ? first : second) > 1)
            EXPECT_GT(std::abs(scene.turned(pin)), 1e-2);
          else
            EXPECT_LT(std::abs(scene.turned(pin)), 1e-12);
        }
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

TEST(JointCoulombMechanisms, LetsPainlevesRodSlideOrJam) {
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
TEST(JointCoulombMechanisms, HoldsASliderOnAnArmThatTurns) {
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
TEST(JointCoulombMechanisms, RunsACrankAndSliderAsRegularisedFrictionDoes) {
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

}  // namespace
}  // namespace lithe::test::joint_coulomb_mechanisms_test
