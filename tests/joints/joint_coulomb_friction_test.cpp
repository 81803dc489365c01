#include <gtest/gtest.h>

#include "engine/assembly/evaluator.h"
#include "engine/observe/recorder.h"
#include "engine/run/simulation.h"
#include "joints/coordinate_drive.h"
#include "joints/cylindrical_joint.h"
#include "joints/forces/coordinate_motor.h"
#include "joints/forces/coordinate_spring.h"
#include "joints/prismatic_joint.h"
#include "joints/spherical_joint.h"
#include "tests/joints/coulomb_friction_scenes.h"
#include "tests/joints/friction_checks.h"
#include "tests/support/message_of.h"
#include "tests/support/pairs.h"

/// Set-valued friction in joints, by time stepping.
namespace lithe::test::joint_coulomb_friction_test {
namespace {

constexpr double kGravity = 9.81;
using Friction = JointCoulombFriction::Parameters;
using coulomb_friction::methods, coulomb_friction::rub;

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
  for (const double h : {1e-3, 4e-4})
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
}

}  // namespace
}  // namespace lithe::test::joint_coulomb_friction_test
