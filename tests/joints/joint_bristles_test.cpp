#include <gtest/gtest.h>

#include "engine/assembly/evaluator.h"
#include "engine/observe/recorder.h"
#include "engine/run/simulation.h"
#include "integrators/moreau_jean.h"
#include "integrators/nonsmooth_generalized_alpha.h"
#include "joints/contact/contact.h"
#include "joints/coordinate_drive.h"
#include "joints/cylindrical_joint.h"
#include "joints/forces/coordinate_motor.h"
#include "joints/forces/coordinate_spring.h"
#include "joints/forces/first_order_states.h"
#include "joints/forces/joint_bristles.h"
#include "joints/forces/point_force.h"
#include "joints/prismatic_joint.h"
#include "joints/spherical_joint.h"
#include "tests/joints/coulomb_friction_scenes.h"
#include "tests/joints/friction_checks.h"
#include "tests/joints/mechanisms.h"
#include "tests/support/joint_checks.h"
#include "tests/support/pairs.h"

/// Friction that sticks, in joints: bristles whose deflections are states.
namespace lithe::test::joint_bristles_test {
namespace {

constexpr double kGravity = 9.81;

FirstOrderStates& draw_states(SystemGraph& graph, const VectorX& start = JointBristles::start()) {
  return graph.add<FirstOrderStates>("bristles", {.start = start});
}

/// Coarse and slow bristles, so that differences see all of the law.
JointBristles::Parameters coarse(const Constraint& joint) {
  return {.joint = &joint,
          .coefficient = 0.4,
          .static_coefficient = 0.5,
          .stribeck_speed = 2,
          .breakaway_deflection = 2,
          .damping_time = 0.5,
          .elastic_share = 0.3,
          .load_time = 0.5,
          .viscous = 0.1,
          .radius = 0.4,
          .bending_arm = 0.6,
          .preload = 2};
}

TEST(JointBristles, KnowTheirDerivatives) {
  for (const Pair& pair : pairs()) {
    SCOPED_TRACE(pair.name);
    {
      SystemGraph graph;
      auto& pin = graph.add<RevoluteJoint>("pin", pair.draw(graph, {0, 0, 0}));
      add_joint_bristles(graph, "rub", {pin.angle()}, draw_states(graph), coarse(pin));
      check_friction_tangent(graph);
    }
    {
      SystemGraph graph;
      auto& sleeve = graph.add<CylindricalJoint>("sleeve", pair.draw(graph, {0, 0, 0.3}));
      add_joint_bristles(graph, "rub", {sleeve.angle(), sleeve.displacement()}, draw_states(graph), coarse(sleeve));
      check_friction_tangent(graph);
    }
    SystemGraph graph;
    auto& ball = graph.add<SphericalJoint>("ball", pair.draw(graph, {0, 0, 0}));
    add_ball_bristles(graph, "rub", draw_states(graph), coarse(ball));
    check_friction_tangent(graph);
  }
}

/// A block of 2 kg on a slide that goes down by `slope` rad; `pull` along it, N; its bristles bent by z.
struct BlockOnASlope {
  using Pull = std::function<double(double time, double place, double speed)>;

  BlockOnASlope(double slope, const JointBristles::Parameters& given, double z = 0, const Pull& pull = nullptr,
                double speed = 0)
      : scene({0, 0, -kGravity}, [&](SystemGraph& graph) {
          const Matrix3 along = rotation_about({0, 1, 0}, kPi / 2 + slope);  // z down the slope
          auto& block = graph.add<RigidBody>("block", {.mass = kMass, .velocity = speed * along.col(2)});
          slide = &graph.add<PrismaticJoint>("slide", {graph.ground().marker({}, along), block.marker({}, along)});
          JointBristles::Parameters p = given;
          p.joint = slide;
          auto& states = draw_states(graph, JointBristles::start(kMass * kGravity * std::cos(slope), {z, 0, 0}));
          rub = &add_joint_bristles(graph, "rub", {slide->displacement()}, states, p);
          if (pull) graph.add<CoordinateMotor>("pull", {slide->displacement()}, {.effort = pull});
        }) {}
  double place() const { return read(scene, coordinate(slide->displacement(), "s")); }
  double speed() const { return read(scene, coordinate_rate(slide->displacement(), "s")); }

  static constexpr double kMass = 2;
  PrismaticJoint* slide = nullptr;
  JointBristles* rub = nullptr;
  Scene scene;
};

std::vector<NamedMethod> methods(double tolerance = 1e-6, double h = 2e-3) {
  std::vector<NamedMethod> all;
  all.push_back({"Automatic", automatic(tolerance)});
  all.push_back({"Radau", radau(tolerance)});
  all.push_back({"BDF", bdf(tolerance)});
  all.push_back({"IDA", ida(tolerance)});
  all.push_back({"generalized-alpha", index3(h)});
  all.push_back({"generalized-alpha, index 2", index2(h)});
  all.push_back({"nonsmooth generalized-alpha",
                 std::make_unique<NonsmoothGeneralizedAlpha>(NonsmoothGeneralizedAlpha::Parameters{.step = h})});
  return all;
}

/// Hung in its bristles as the slope asks, z = tan / μ_s; and from straight bristles, once it has settled.
TEST(JointBristles, HoldABlockOnASlopeForAMinuteWithoutCreep) {
  constexpr double kMu = 0.3, kDelta = 1e-5;
  for (const double slope : {0.28, 0.1}) {  // tan 0.28 = 0.2876
    const double hung = std::tan(slope) / kMu;
    for (auto& [name, method] : methods(1e-7, 1e-2)) {
      SCOPED_TRACE(name);
      BlockOnASlope block(slope, {.coefficient = kMu, .breakaway_deflection = kDelta}, hung);
      block.scene.run(*method, 60);
      expect_below(name + ": creep in a minute, m", std::abs(block.place()), 1e-9);
    }
  }
  for (auto& [name, method] : methods(1e-9)) {
    SCOPED_TRACE(name);
    BlockOnASlope block(0.1, {.coefficient = kMu, .breakaway_deflection = kDelta});
    block.scene.run(*method, 1);
    const double settled = block.place();
    EXPECT_NEAR(settled, std::tan(0.1) / kMu * kDelta, 2e-8) << "m g sin = μ m g cos z";
    block.scene.run(*method, 21);
    expect_below(name + ": creep in 20 s after it has settled, m", std::abs(block.place() - settled), 1e-9);
  }
}

/// A pull that rises smoothly to a little less than μ_s m g is held, by a little more it slides away: in t seconds by
/// ½ (pull - μ_k m g) / m t², once it has.
TEST(JointBristles, BreakAwayAtTheStaticForce) {
  constexpr double kMuS = 0.4, kMuK = 0.3, kLittle = 1e-3, kWeight = BlockOnASlope::kMass * kGravity;
  for (const double share : {1 - kLittle, 1 + kLittle})
    for (auto& [name, method] : methods()) {
      SCOPED_TRACE(name + ", " + std::to_string(share));
      BlockOnASlope block(
          0, {.coefficient = kMuK, .static_coefficient = kMuS, .stribeck_speed = 1e-2, .breakaway_deflection = 1e-7}, 0,
          [&](double t, double, double) { return share * kMuS * kWeight * smooth_step(0, 1, 0, 5)(t).value; });
      block.scene.run(*method, 10.5);
      if (share < 1) {
        EXPECT_LT(std::abs(block.place()), 1e-4);
        EXPECT_LT(std::abs(block.speed()), 1e-7) << "left by the method; sliding, it gains 0.1 m/s and more a second";
      } else {
        EXPECT_GT(block.place(), 10);
      }
    }
}

/// It slides as Coulomb has it, v₀² / (2 μ g), stops, and rests; its bristles' energy and what they took are what it
/// had.
TEST(JointBristles, StopASlidingBlockAndAccountForItsEnergy) {
  constexpr double kMu = 0.3, kSpeed = 1.5, kDelta = 1e-6;
  BlockOnASlope block(0, {.coefficient = kMu, .breakaway_deflection = kDelta}, 0, nullptr, kSpeed);
  const double start = block.scene.energy();
  const Method method = radau(1e-9);
  Recorder recorder{{power(*block.rub, "power"), potential_energy(*block.rub, "stored"), total_energy("energy")}};
  Simulation simulation{block.scene.system, *method};
  simulation.observe(recorder, every_step());
  simulation.run(block.scene.state, 1);
  EXPECT_NEAR(block.place(), kSpeed * kSpeed / (2 * kMu * kGravity), 2 * kDelta);
  EXPECT_NEAR(block.speed(), 0, 1e-9);
  const auto t = recorder.table().column("t"), P = recorder.table().column("power"),
             stored = recorder.table().column("stored"), energy = recorder.table().column("energy");
  double work = 0;
  for (std::size_t i = 1; i < t.size(); ++i) work += 0.5 * (t[i] - t[i - 1]) * (P[i] + P[i - 1]);
  EXPECT_NEAR(work, -start, 1e-3 * start);
  for (std::size_t i = 1; i < t.size(); ++i) EXPECT_LE(energy[i], energy[i - 1] + 1e-9 * start) << t[i];
  EXPECT_NEAR(energy.back(), stored.back(), 1e-12);
  const double most = *std::max_element(stored.begin(), stored.end());
  EXPECT_NEAR(most, kMu * BlockOnASlope::kMass * kGravity * kDelta / 2, 0.01 * most);
}

/// Explicit methods too, at steps that the bristles ask for.
TEST(JointBristles, StopASlidingBlockByAnExplicitMethod) {
  constexpr double kMu = 0.3, kSpeed = 0.3;
  BlockOnASlope block(0, {.coefficient = kMu}, 0, nullptr, kSpeed);
  const Method method = runge_kutta(1e-7);
  block.scene.run(*method, 0.3);
  EXPECT_NEAR(block.place(), kSpeed * kSpeed / (2 * kMu * kGravity), 2e-5);
  EXPECT_NEAR(block.speed(), 0, 1e-6);
}

/// A load that goes to and fro below the elastic share leaves it where it was: LuGre's bristles would let it drift.
TEST(JointBristles, DoNotDriftUnderALoadThatGoesToAndFro) {
  constexpr double kMu = 0.3, kWeight = BlockOnASlope::kMass * kGravity;
  for (auto& [name, method] : methods(1e-8)) {
    SCOPED_TRACE(name);
    BlockOnASlope block(0, {.coefficient = kMu}, 0, [&](double t, double, double) {
      return kMu * kWeight * (0.5 * smooth_step(0, 1, 0, 0.5)(t).value + 0.3 * std::sin(2 * kPi * 5 * t));
    });
    block.scene.run(*method, 1);
    const double first = block.place();
    block.scene.run(*method, 7);
    EXPECT_NEAR(block.place(), first, 2e-7);  // LuGre's: some 2e-4
  }
}

/// The pendulum stops where its weight is within what its pin holds, m g l sin φ < r μ m g, and stays.
TEST(JointBristles, HoldAPendulumBesideItsLowestPlace) {
  constexpr double kMu = 0.4, kRadius = 0.05, kLength = 0.3, kAngle = 0.06;  // sin φ < 0.0667
  for (const double start : {kAngle, 0.4})
    for (auto& [name, method] : methods(1e-8, 5e-3)) {
      SCOPED_TRACE(name + " from " + std::to_string(start));
      RevoluteJoint* pin = nullptr;
      Scene scene({0, -kGravity, 0}, [&, start](SystemGraph& graph) {
        const Matrix3 A = rotation_about({0, 0, 1}, start);
        auto& rod = graph.add<RigidBody>(
            "rod", {.mass = 2, .inertia = {0.1, 0.1, 0.1}, .position = A * Vector3(0, -kLength, 0), .orientation = A});
        pin = &graph.add<RevoluteJoint>("pin", {graph.ground().marker(), rod.marker({0, kLength, 0})});
        add_joint_bristles(graph, "rub", {pin->angle()}, draw_states(graph),
                           {.joint = pin, .coefficient = kMu, .radius = kRadius});
      });
      scene.run(*method, 10);
      const double rests = read(scene, coordinate(pin->angle(), "phi"));
      scene.run(*method, 20);
      EXPECT_NEAR(read(scene, coordinate(pin->angle(), "phi")), rests, 1e-8);
      EXPECT_LT(std::abs(std::sin(rests)), kMu * kRadius / kLength);
      if (start == kAngle) {
        EXPECT_NEAR(rests, kAngle, 2e-3);
      }
    }
}

/// Bristles between two flexible bodies, whose modes Newton's matrix leaves out: they converge, and hold.
TEST(JointBristles, HoldBetweenFlexibleBodies) {
  for (const Pair& pair : pairs()) {
    SCOPED_TRACE(pair.name);
    PrismaticJoint* slide = nullptr;
    Scene scene({0, 0, 0}, [&](SystemGraph& graph) {
      const std::vector<Marker> ends = pair.draw(graph, {0, 0, 0.3});
      slide = &graph.add<PrismaticJoint>("slide", ends);
      add_joint_bristles(graph, "rub", {slide->displacement()}, draw_states(graph, JointBristles::start(20)),
                         {.joint = slide, .coefficient = 0.5, .preload = 20});
      graph.add<CoordinateMotor>("pull", {slide->displacement()}, {.effort = [](double t, double, double) {
                                   return 8 * smooth_step(0, 1, 0, 0.1)(t).value;
                                 }});
    });
    const Method method = radau(1e-6);
    scene.run(*method, 0.2);
    EXPECT_NEAR(read(scene, coordinate(slide->displacement(), "x")), 0.3, 2e-5);
  }
}

/// Stick-slip on a belt as it is published (benchmark C06): a block on a spring, a belt that moves at 0.5 m/s.
TEST(JointBristles, StickAndSlipOnABeltAsCoulombHasIt) {
  constexpr double kStiffness = 100, kBelt = 0.5, kPeriod = 0.62881071913377278895;
  PrismaticJoint* rail = nullptr;
  Scene scene({0, 0, -kGravity}, [&](SystemGraph& graph) {
    const Matrix3 along = rotation_about({0, 1, 0}, kPi / 2);
    auto& belt = graph.add<RigidBody>("belt", {});
    auto& block = graph.add<RigidBody>("block", {.mass = 1, .position = {0.01962, 0, 0}, .velocity = {kBelt, 0, 0}});
    auto& drum = graph.add<PrismaticJoint>("drum", {graph.ground().marker({}, along), belt.marker({}, along)});
    graph.add<CoordinateDrive>("drive", {drum.displacement()}, {.motion = ramp(0, kBelt)});
    rail = &graph.add<PrismaticJoint>("rail", {belt.marker({}, along), block.marker({}, along)});
    auto& states = draw_states(graph, JointBristles::start(kGravity, {-0.5, 0, 0}));  // k x = μ_s m g (-z)
    add_joint_bristles(graph, "rub", {rail->displacement()}, states,
                       {.joint = rail,
                        .coefficient = 0.3,
                        .static_coefficient = 0.4,
                        .stribeck_speed = 3e-5,
                        .breakaway_deflection = 3e-9,
                        .damping_time = 1e-4});
    graph.add<CoordinateSpring>("spring",
                                {displacement_between(graph.ground().marker({}, along), block.marker({}, along))},
                                {.stiffness = kStiffness});
  });
  const Method method = radau(1e-7);
  Simulation simulation{scene.system, *method};
  const auto rail_speed = coordinate_rate(rail->displacement(), "u");
  simulation.on({.name = "turns", .function = watch(rail_speed), .level = -0.5 * kBelt});
  simulation.run(scene.state, 5 * kPeriod + 0.1);
  std::vector<double> turns;  // of a slide, twice a cycle
  for (const EventRecord& event : simulation.events()) turns.push_back(event.time);
  ASSERT_EQ(turns.size(), 10u) << "it slides once a cycle";
  for (std::size_t i = 2; i < turns.size(); ++i) EXPECT_NEAR(turns[i] - turns[i - 2], kPeriod, 1e-4) << i;
}

/// Deflections beyond those of sliding, which steps that do not resolve δ leave: the force stays within 1.1 μ_s of the
/// load, goes on smoothly, and is what the energy stored changes by.
TEST(BristleLaw, IsBoundedAndConservativeBeyondBreakaway) {
  constexpr double kMu = 0.3, kDelta = 1e-3, kStep = 1e-6;
  const BristleLaw law({{kMu, kMu, 0.1}, kDelta, 0, 0.9});
  const Vector3 direction = Vector3(1, -2, 0.5).normalized(), still = Vector3::Zero();
  const auto force = [&](double bent) { return law.at(still, bent * direction).force.dot(direction); };
  for (const double bent : {0.2, 0.9, 0.999999, 1.000001, 1.05, 1.5, 3.0, 100.0}) {
    EXPECT_LE(force(bent), 1.1 * kMu * (1 + 1e-12)) << bent;
    const double slope =
        (law.energy((bent + kStep) * direction) - law.energy((bent - kStep) * direction)) / (2 * kStep * kDelta);
    EXPECT_NEAR(slope, force(bent), 1e-6 * kMu) << bent;
  }
  EXPECT_NEAR(force(1 + kStep) - force(1), force(1) - force(1 - kStep), 1e-4 * kMu * kStep) << "no kink at δ";
}

/// A carriage that falls along a post, drawn down by a force beside its weight, and lands; a load slides on it. Before,
/// the carriage takes the load along, N₀ = m (a - g) downwards; the landing presses by J = m (1 + e) v upwards, the
/// other way round. So n follows N₀ and J in closed form, and friction takes μ ∫ n dt. Linearised about N₀, n went to
/// -J / τ_n.
TEST(JointBristles, FollowImpulsesOfContactThatTurnTheReactionRound) {
  constexpr double kMass = 2, kPull = 30, kGap = 0.05, kBounce = 0.4, kMu = 0.2, kLoadTime = 5e-3, kSlide = 3;
  const double a = kGravity + kPull / (3 + kMass), v = std::sqrt(2 * a * kGap), landing = v / a;
  const double N0 = kMass * (a - kGravity), J = kMass * (1 + kBounce) * v, end = landing + 2 * kLoadTime;
  const double before = N0 * (1 - std::exp(-landing / kLoadTime)), after = before + J / kLoadTime;
  const double n = N0 + (after - N0) * std::exp(-2.0), taken = kMu * (N0 * end + J - kLoadTime * n) / kMass;
  for (const bool alpha : {false, true}) {
    double last = 0;
    for (const double h : {4e-4, 1e-4, 2.5e-5}) {
      SCOPED_TRACE((alpha ? "alpha, h = " : "Moreau-Jean, h = ") + std::to_string(h));
      Scene scene({0, 0, -kGravity}, [&](SystemGraph& graph) {
        auto& carriage = graph.add<RigidBody>("carriage", {.mass = 3, .inertia = {1, 1, 1}, .position = {0, 0, 1}});
        auto& load = graph.add<RigidBody>(
            "load", {.mass = kMass, .inertia = {1, 1, 1}, .position = {0, 0, 1}, .velocity = {kSlide, 0, 0}});
        graph.add<PrismaticJoint>("post", {graph.ground().marker({0, 0, 1}), carriage.marker()});
        const Matrix3 along = rotation_about({0, 1, 0}, M_PI / 2);
        auto& slide = graph.add<PrismaticJoint>("slide", {carriage.marker({}, along), load.marker({}, along)});
        graph.add<PointForce>("pull", {carriage.marker()}, {.force = {0, 0, -kPull}});
        add_joint_bristles(graph, "rub", {slide.displacement()}, draw_states(graph, JointBristles::start(0, {1, 0, 0})),
                           {.joint = &slide, .coefficient = kMu, .breakaway_deflection = 5e-3, .load_time = kLoadTime});
        graph.add<Contact>("floor",
                           std::vector<Collider>{{graph.ground().marker(), shape::half_space()},
                                                 {carriage.marker(), shape::sphere(1 - kGap)}},
                           Contact::Parameters{.law = RigidSurfaces{.restitution = kBounce}});
      });
      std::unique_ptr<Integrator> method;
      if (alpha)
        method = std::make_unique<NonsmoothGeneralizedAlpha>(NonsmoothGeneralizedAlpha::Parameters{.step = h});
      else
        method = std::make_unique<MoreauJean>(MoreauJean::Parameters{.step = h});
      scene.run(*method, end);
      ASSERT_NE(scene.system.layout().velocity_name(18).find("frame 1: p_x"), std::string::npos);
      const double error = std::abs(1e3 * scene.state.v[18] - n) / n;
      EXPECT_LT(error, 1.2 * h / kLoadTime);
      if (last > 0) EXPECT_LT(error, 0.5 * last);
      EXPECT_NEAR(kSlide - scene.state.v[6], taken, 1.5 * h / kLoadTime * taken);
      last = error;
    }
  }
}

/// A carriage that falls along a post which rubs by Coulomb's set-valued law, F = μ N₀; a load on it is pressed by
/// m F / M, M the mass of both, and without friction by nothing. Moreau-Jean let bristles miss that.
TEST(JointBristles, FollowTheFrictionOfOtherJoints) {
  constexpr double kMass = 2, kCarriage = 3, kPreload = 100, kMu = 0.1, kLoadTime = 5e-3, kEnd = 0.02;
  const double N = kMass * kMu * kPreload / (kCarriage + kMass), n = N * (1 - std::exp(-kEnd / kLoadTime));
  for (auto& [name, method] : coulomb_friction::methods(1e-4)) {
    SCOPED_TRACE(name);
    Scene scene({0, 0, -kGravity}, [&](SystemGraph& graph) {
      auto& carriage = graph.add<RigidBody>("carriage", {.mass = kCarriage, .inertia = {1, 1, 1}});
      auto& load = graph.add<RigidBody>("load", {.mass = kMass, .inertia = {1, 1, 1}, .velocity = {1, 0, 0}});
      auto& post = graph.add<PrismaticJoint>("post", {graph.ground().marker(), carriage.marker()});
      const Matrix3 along = rotation_about({0, 1, 0}, M_PI / 2);
      auto& slide = graph.add<PrismaticJoint>("slide", {carriage.marker({}, along), load.marker({}, along)});
      add_joint_bristles(graph, "rub", {slide.displacement()}, draw_states(graph, JointBristles::start(0, {1, 0, 0})),
                         {.joint = &slide, .coefficient = 1e-8, .breakaway_deflection = 5e-3, .load_time = kLoadTime});
      add_joint_coulomb_friction(graph, "guide", {post.displacement()},
                                 {.joint = &post, .coefficient = kMu, .preload = kPreload});
    });
    scene.run(*method, kEnd);
    ASSERT_NE(scene.system.layout().velocity_name(18).find("frame 1: p_x"), std::string::npos);
    EXPECT_NEAR(scene.state.v[2], -(kGravity - kMu * kPreload / (kCarriage + kMass)) * kEnd, 1e-9);
    EXPECT_NEAR(1e3 * scene.state.v[18], n, 0.01 * n);
  }
}

/// A rod in a sleeve that tumbles on rigid ground. Impacts press the joint a thousand times harder for a step, in which
/// it slides by up to a hundred δ: midpoint steps leave z at ±h s / δ and the load below zero by turns. With forces in
/// proportion to both the bristles drove the bodies, to 1e26 m/s.
TEST(JointBristles, TakeEnergyFromBodiesThatImpactsPress) {
  constexpr double kSpeed = 2;
  for (const auto& [h, delta, time] :
       {std::tuple(1e-3, 1e-5, 1e-4), std::tuple(1e-3, 6e-4, 6e-3), std::tuple(2.5e-4, 6e-4, 6e-3)})
    for (int k = 0; k < 8; ++k) {
      SCOPED_TRACE(std::to_string(k) + ", h = " + std::to_string(h) + ", delta = " + std::to_string(delta));
      JointBristles* rub = nullptr;
      Scene scene({0, 0, -kGravity}, [&, delta = delta, time = time](SystemGraph& graph) {
        const Matrix3 axes = rotation_about({1, 2, 3}, 0.5 * k);
        const Vector3 spin(3, -5, 2), apart(0, 0, 0.4), velocity(1, 0, -1);
        auto& sleeve = graph.add<RigidBody>("sleeve", {.mass = 1,
                                                       .inertia = {0.01, 0.02, 0.03},
                                                       .position = {0, 0, 1},
                                                       .orientation = axes,
                                                       .velocity = velocity,
                                                       .angular_velocity = spin});
        auto& rod =
            graph.add<RigidBody>("rod", {.mass = 1,
                                         .inertia = {0.02, 0.01, 0.01},
                                         .position = Vector3::UnitZ() + axes * apart,
                                         .orientation = axes,
                                         .velocity = velocity + axes * (spin.cross(apart) + kSpeed * Vector3::UnitZ()),
                                         .angular_velocity = spin});
        auto& slide = graph.add<PrismaticJoint>("slide", {sleeve.marker(), rod.marker()});
        rub = &add_joint_bristles(graph, "rub", {slide.displacement()}, draw_states(graph),
                                  {.joint = &slide,
                                   .coefficient = 0.3,
                                   .breakaway_deflection = delta,
                                   .damping_time = time,
                                   .load_time = time,
                                   .radius = 0.05});
        graph.add<Contact>(
            "floor",
            std::vector<Collider>{{graph.ground().marker(), shape::half_space(), 0, groups({1})},
                                  {sleeve.marker({0.1, 0, 0}), shape::sphere(0.1), 1, groups({0})},
                                  {rod.marker({0, 0.1, 0}), shape::sphere(0.1), 1, groups({0})}},
            Contact::Parameters{.law = RigidSurfaces{.restitution = 0.5}, .friction = {.coefficient = 0.3}});
      });
      MoreauJean method({.step = h});
      Recorder recorder{{total_energy("all"), potential_energy(*rub, "stored")}};
      Simulation simulation{scene.system, method};
      simulation.observe(recorder, every_step());
      simulation.run(scene.state, 1.5);
      const auto all = recorder.table().column("all"), stored = recorder.table().column("stored");
      double lowest = all[0], rise = 0, most = 0;
      for (std::size_t i = 0; i < all.size(); ++i) {
        const double of_bodies = all[i] - stored[i];
        EXPECT_LE(of_bodies, all[0] * (1 + 1e-3)) << "step " << i;
        lowest = std::min(lowest, of_bodies);
        rise = std::max(rise, of_bodies - lowest), most = std::max(most, stored[i]);
      }
      EXPECT_LT(all.back(), 0.3 * all[0]);
      // Where steps resolve δ and τ_n nothing comes back but what bristles store.
      if (h < 1e-3) expect_below("rise, of what bristles stored", rise / most, 2);
    }
}

}  // namespace
}  // namespace lithe::test::joint_bristles_test
