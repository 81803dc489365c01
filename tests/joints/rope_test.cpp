#include "joints/rope/rope.h"

#include <gtest/gtest.h>

#include "bodies/point_mass.h"
#include "bodies/rigid_body.h"
#include "engine/analysis/equilibrium.h"
#include "engine/run/simulation.h"
#include "joints/coordinate_drive.h"
#include "joints/forces/coordinate_motor.h"
#include "joints/forces/point_force.h"
#include "joints/prismatic_joint.h"
#include "joints/revolute_joint.h"
#include "joints/rope/rope_elements_internal.h"
#include "tests/support/joint_checks.h"
#include "tests/support/methods.h"

/// Ropes over pulleys without friction: geometry, virtual work and closed forms. The plane is xy, gravity along -y.
namespace lithe::test::rope_test {
namespace {

constexpr double kGravity = 9.81;
const SystemGraph::Parameters kDown{.gravity = {0, -kGravity, 0}};
const Matrix3 kUp = rotation_about({1, 0, 0}, -M_PI / 2);  // z of a slider along y

double read(const System& system, const State& state, const Sensor& sensor) {
  Snapshot now{system, state};
  return sensor.value(now);
}

State run(const System& system, Method method, double end) {
  State state = system.initial_state();
  Simulation simulation{system, *method};
  simulation.run(state, end);
  return state;
}

Sensor height_of(PointMass& mass) {
  return Sensor{"height", {"height"}, [marker = mass.marker()](Snapshot& now, std::span<double> out) {
                  out[0] = now.marker(marker).p.y();
                }};
}

// ---- geometry ----

TEST(Rope, SpansFollowExternalAndCrossingTangents) {
  const double c = 1, r1 = 0.3, r2 = 0.1;
  for (int sense : {1, -1}) {
    SystemGraph graph;
    const Rope belt = reeve(graph, "belt", {},
                            {.pulleys = {{graph.ground().marker(), r1}, {graph.ground().marker({c, 0, 0}), r2, sense}},
                             .axial_stiffness = 1e4,
                             .mass_per_length = 1});
    const double sum = sense > 0 ? r1 - r2 : r1 + r2, open = std::asin(sum / c),
                 straight = std::sqrt(c * c - sum * sum);
    for (double length : belt.drawn_lengths) EXPECT_NEAR(length, straight, 1e-14);
    EXPECT_NEAR(belt.wraps[0], M_PI + 2 * open, 1e-14);
    EXPECT_NEAR(belt.wraps[1], M_PI - sense * 2 * open, 1e-14);
    EXPECT_NEAR(belt.length, 2 * straight + r1 * belt.wraps[0] + r2 * belt.wraps[1], 1e-14);
  }
}

/// The first pulley moves to where a rope drawn there would have another length: the tension is that of the difference.
TEST(Rope, TensionIsThatOfALongerWay) {
  const double EA = 3e4;
  const auto draw = [&](SystemGraph& graph, const Vector3& place) {
    auto& block = graph.add<RigidBody>("block", {.position = place});
    return reeve(
        graph, "rope", {{graph.ground().marker({-1, -2, 0})}, {graph.ground().marker({3, -1.5, 0})}},
        {.pulleys = {{block.marker(), 0.4, -1}, {graph.ground().marker({1.5, -1, 0}), 0.2}}, .axial_stiffness = EA});
  };
  SystemGraph graph, there;
  const Rope rope = draw(graph, {0, 0, 0});
  const double stretched = draw(there, {0.2, 0.9, 0}).length;
  const System system = assemble(graph);
  State state = system.initial_state();
  state.q.head<3>() = Vector3(0.2, 0.9, 0);
  EXPECT_NEAR(read(system, state, tension(rope, 1)), EA * (stretched / rope.length - 1), 1e-8);
}

// ---- virtual work ----

RigidBody& block(SystemGraph& graph, const std::string& name, const Vector3& place) {
  return graph.add<RigidBody>(name, {.position = place});
}

TEST(Rope, ForcesAreTheLossOfItsPotential) {
  SystemGraph graph;
  auto& a = block(graph, "a", {-3, -6, 0});
  auto& b = block(graph, "b", {0, 1, 0});
  auto& c = block(graph, "c", {6, -4, 0});
  auto& d = block(graph, "d", {12, 1, 0.5});
  const Rope rope = reeve(graph, "rope", {{a.marker({0.2, 0.1, 0.1}), 0.5}, {d.marker({0.1, -0.2, 0})}},
                          {.pulleys = {{b.marker({0, 0.3, 0}), 0.7, -1}, {c.marker(), 0.4}},
                           .axial_stiffness = 40,
                           .axial_damping = 0.3,
                           .pretension = 14});
  check_force(graph, *rope.spans[0], {.tolerance = 1e-7});
}

TEST(Rope, SpanForcesAreTheLossOfItsPotential) {
  SystemGraph graph;
  auto& a = block(graph, "a", {0, 1, 0});
  auto& b = block(graph, "b", {6, -4, 0});
  auto& before = graph.add<RopeTravel>("before", {.mass = 1});
  auto& behind = graph.add<RopeTravel>("behind", {.mass = 2, .slips = true});
  const RopeSpanDrawing drawing{
      .R_A = -0.7, .R_B = 0.4, .drawn_length = 8, .rest_length = 6, .arc_A = 0.4, .arc_B = 0.7};
  const auto& span = graph.add<RopeSpan>(
      "span", {a.marker({0.1, 0.3, 0}), b.marker(), Marker{&before, 1}, Marker{&behind, 1}},
      {.section = {40, 0.3}, .drawing = drawing, .weight = {0.5, -2, 1}, .travels_A = true, .travels_B = true});
  check_force(graph, span, {.tolerance = 1e-7});
}

// ---- closed forms ----

/// Atwood: a = g (m₁ - m₂)/(m₁ + m₂); drawn with the tension of its motion it does not vibrate.
TEST(Rope, TwoLoadsOverAPulleyAccelerateByTheDifferenceOfTheirWeights) {
  const double m1 = 3, m2 = 2, r = 0.2, t = 0.6;
  SystemGraph graph{kDown};
  auto& left = graph.add<PointMass>("left", {.mass = m1, .position = {-r, -3, 0}});
  auto& right = graph.add<PointMass>("right", {.mass = m2, .position = {r, -3, 0}});
  const double force = 2 * m1 * m2 * kGravity / (m1 + m2);
  const Rope rope = reeve(graph, "rope", {{left.marker()}, {right.marker()}},
                          {.pulleys = {{graph.ground().marker(), r, -1}}, .axial_stiffness = 1e4, .pretension = force});
  const System system = assemble(graph);
  const State state = run(system, runge_kutta8(1e-12), t);
  const double a = (m1 - m2) / (m1 + m2) * kGravity;
  EXPECT_NEAR(state.q[1], -3 - 0.5 * a * t * t, 1e-10);
  EXPECT_NEAR(state.q[4], -3 + 0.5 * a * t * t, 1e-10);
  EXPECT_NEAR(read(system, state, tension(rope, 0)), force, 1e-8);
}

/// The same over a wheel that turns with a heavy rope, which runs off to its longer side:
///   (m₁ + m₂ + I/r² + μ L) ẍ = (m₁ - m₂ + 2 μ x) g
TEST(Rope, AWheelThatTurnsWithTheRopeAddsItsInertia) {
  const double m1 = 3, m2 = 2, r = 0.2, inertia = 0.08, mu = 0.3, t = 0.6;
  SystemGraph graph{kDown};
  auto& left = graph.add<PointMass>("left", {.mass = m1, .position = {-r, -3, 0}});
  auto& right = graph.add<PointMass>("right", {.mass = m2, .position = {r, -3, 0}});
  auto& wheel = graph.add<RigidBody>("wheel", {.mass = 5, .inertia = {1, 1, inertia}});
  const Marker axle = graph.ground().marker();
  auto& pin = graph.add<RevoluteJoint>("pin", {axle, wheel.marker()});
  const Rope rope = reeve(graph, "rope", {{left.marker()}, {right.marker()}},
                          {.pulleys = {{axle, r, -1, kNoSlip, pin.angle()}},
                           .axial_stiffness = 1e8,
                           .axial_damping = 1e6,
                           .mass_per_length = mu});
  const System system = assemble(graph);
  const State state = run(system, radau(1e-9), t);
  const double mass = m1 + m2 + inertia / (r * r) + mu * rope.length, rate = std::sqrt(2 * mu * kGravity / mass);
  const double x = (m1 - m2) / (2 * mu) * (std::cosh(rate * t) - 1), a = rate * rate * (x + (m1 - m2) / (2 * mu));
  EXPECT_NEAR(state.q[1], -3 - x, 2e-6);
  EXPECT_NEAR(read(system, state, coordinate(pin.angle(), "turned")), x / r, 2e-5);
  // In the middle of a span: half of its weight below.
  EXPECT_NEAR(read(system, state, tension(rope, 0)), m1 * (kGravity - a) + 0.5 * mu * kGravity * (3 + x), 1e-3);
  EXPECT_NEAR(read(system, state, tension(rope, 1)), m2 * (kGravity + a) + 0.5 * mu * kGravity * (3 - x), 1e-3);
}

/// Four parts carry a block: a quarter of its weight in each, and it rises by a quarter of what is hauled in.
TEST(Rope, ATackleOfFourPartsDividesForceAndWay) {
  const double r = 0.1, m = 80, hauled = 0.4, EA = 1e6;
  double heights[2];
  for (int k = 0; k < 2; ++k) {
    SystemGraph graph{kDown};
    auto& load = graph.add<RigidBody>("load", {.mass = m, .position = {3 * r, -2, 0}});
    graph.add<PrismaticJoint>("guide", {graph.ground().marker({3 * r, -2, 0}, kUp), load.marker({0, 0, 0}, kUp)});
    auto& ground = graph.ground();
    const Rope rope = reeve(graph, "tackle", {{ground.marker()}, {ground.marker({8 * r, -2 - hauled * k, 0})}},
                            {.pulleys = {{load.marker({-2 * r, 0, 0}), r, 1},
                                         {ground.marker({3 * r, 0, 0}), r, -1},
                                         {load.marker({2 * r, 0, 0}), r, 1},
                                         {ground.marker({7 * r, 0, 0}), r, -1}},
                             .axial_stiffness = EA,
                             .length = 10 + 4 * M_PI * r});
    const System system = assemble(graph);
    const Equilibrium rest = find_equilibrium(system, system.initial_state());
    heights[k] = rest.state.q[1];
    for (int span = 0; span < 5; ++span)
      EXPECT_NEAR(read(system, rest.state, tension(rope, span)), m * kGravity / 4, 1e-6);
  }
  EXPECT_NEAR(heights[1] - heights[0], hauled / 4, 1e-9);
}

/// A drum that turns by φ hauls in R φ of its rope, over whole turns.
TEST(Rope, ADrumHaulsInWhatItWindsUp) {
  const double radius = 0.25, turned = 7;
  SystemGraph graph{kDown};
  auto& load = graph.add<PointMass>("load", {.mass = 4, .position = {2.1, -6, 0}});
  auto& drum = graph.add<RigidBody>("drum", {});
  auto& pin = graph.add<RevoluteJoint>("pin", {graph.ground().marker(), drum.marker()});
  graph.add<CoordinateDrive>("motor", {pin.angle()}, {.motion = smooth_step(0, turned, 0, 2)});
  const Rope rope = reeve(graph, "rope", {{drum.marker(), radius, -1}, {load.marker()}},
                          {.pulleys = {{graph.ground().marker({2, 2, 0}), 0.1, -1}},
                           .axial_stiffness = 1e5,
                           .axial_damping = 5e3,
                           .pretension = 4 * kGravity});
  const Sensor height = height_of(load);
  const System system = assemble(graph);
  const State state = run(system, radau(1e-9), 6);
  EXPECT_NEAR(read(system, state, height), -6 + radius * turned, 1e-6);
  EXPECT_NEAR(read(system, state, tension(rope, 0)), 4 * kGravity, 1e-4);
}

/// A load swings under a pulley; its rope winds on and off the wheel, and its energy stays.
TEST(Rope, ASwingingLoadKeepsItsEnergy) {
  for (double mass_per_length : {0.0, 0.8}) {
    SystemGraph graph{kDown};
    auto& load = graph.add<PointMass>("load", {.mass = 2, .position = {2, -1.5, 0.2}});
    auto& weight = graph.add<PointMass>("weight", {.mass = 2.5, .position = {-1.3, -1, 0}});
    const Rope rope =
        reeve(graph, "rope", {{weight.marker()}, {load.marker()}},
              {.pulleys = {{graph.ground().marker({-1, 0, 0}), 0.3, -1}, {graph.ground().marker({1, 0, 0}), 0.2, -1}},
               .axial_stiffness = 2e3,
               .mass_per_length = mass_per_length,
               .pretension = 15});
    const System system = assemble(graph);
    const Sensor energy = total_energy("energy");
    const double before = read(system, system.initial_state(), energy);
    const State state = run(system, runge_kutta8(1e-12), 1);
    expect_below("energy of a swinging load", std::abs(read(system, state, energy) - before), 1e-8);
    EXPECT_GT((state.q - system.initial_state().q).norm(), 0.3);
  }
}

/// Thrown up, the load flies free on a slack rope and falls back into it with the speed that it left it with.
TEST(Rope, ASlackRopeCarriesNothingAndCatchesItsLoad) {
  SystemGraph graph{kDown};
  auto& load = graph.add<PointMass>("load", {.mass = 2, .position = {0.2, -3, 0}, .velocity = {0, 4, 0}});
  const Rope rope = reeve(graph, "rope", {{graph.ground().marker({-0.2, -3, 0})}, {load.marker()}},
                          {.pulleys = {{graph.ground().marker(), 0.2, -1}}, .axial_stiffness = 1e4});
  const System system = assemble(graph);
  State state = system.initial_state();
  const Method method = runge_kutta8(1e-11);
  Simulation simulation{system, *method};
  const double flight = 2 * 4 / kGravity;
  simulation.run(state, 0.9 * flight);
  const double t = state.time;
  EXPECT_EQ(read(system, state, tension(rope, 1)), 0);
  EXPECT_NEAR(state.q[1], -3 + 4 * t - 0.5 * kGravity * t * t, 1e-9);
  simulation.run(state, flight + 0.05);
  const double catching = read(system, state, tension(rope, 1));
  EXPECT_GT(catching, 100);
  // ½ k x² - m g x - ½ m v² = const from the start.
  const double energy = read(system, state, total_energy("energy"));
  EXPECT_NEAR(energy, 2 * (0.5 * 16 - kGravity * 3), 1e-7);
}

/// A rope with mass has any number of pulleys; without friction and weight all its spans carry the same at rest.
TEST(Rope, ThirteenPulleysPassOneTensionOn) {
  SystemGraph graph{{.gravity = {0, 0, 0}}};
  auto& load = graph.add<PointMass>("load", {.mass = 2, .position = {12.1, -2, 0}});
  graph.add<PointForce>("pull", {load.marker()}, {.force = {0, -20, 0}});
  std::vector<RopePulley> pulleys;
  for (int i = 0; i < 12; ++i)
    pulleys.push_back({graph.ground().marker({static_cast<double>(i), i % 2 ? 0.0 : 1.0, 0}), 0.1, i % 2 ? 1 : -1});
  pulleys.push_back({graph.ground().marker({12, 1, 0}), 0.1, -1});
  const Rope rope = reeve(graph, "rope", {{graph.ground().marker({-1, 0, 0})}, {load.marker()}},
                          {.pulleys = pulleys, .axial_stiffness = 1e5, .mass_per_length = 0.1});
  const System system = assemble(graph);
  const Equilibrium rest = find_equilibrium(system, system.initial_state());
  for (int span = 0; span < 14; ++span) EXPECT_NEAR(read(system, rest.state, tension(rope, span)), 20, 1e-6) << span;
}

// ---- bad input ----

template <class Draw>
void expect_error(Draw&& draw, const std::vector<std::string>& words) {
  SystemGraph graph;
  auto& ground = graph.ground();
  RopeParameters good{.pulleys = {{ground.marker(), 0.2, -1}, {ground.marker({1, 0, 0}), 0.3, -1}},
                      .axial_stiffness = 1e4};
  std::vector<RopeEnd> ends{{ground.marker({-1, -2, 0})}, {ground.marker({2, -2, 0})}};
  try {
    draw(graph, ends, good);
    reeve(graph, "hoist", ends, good);
    ADD_FAILURE() << "no error; expected one with '" << words.back() << "'";
  } catch (const SceneError& error) {
    EXPECT_NE(error.problem().find("'hoist'"), std::string::npos) << error.what();
    for (const std::string& word : words) EXPECT_NE(error.problem().find(word), std::string::npos) << error.what();
    EXPECT_EQ(error.where().rfind("rope_test.cpp:", 0), 0u) << error.what();
    EXPECT_FALSE(error.fix().empty()) << error.what();
  }
}

TEST(Rope, BadInputNamesThePulley) {
  using Ends = std::vector<RopeEnd>;
  const auto change = [](auto&& how) {
    return [how](SystemGraph& graph, Ends& ends, RopeParameters& p) { how(graph, ends, p); };
  };
  expect_error(change([](auto&, auto&, auto& p) { p.pulleys[1].radius = 0; }), {"radius of pulley 2"});
  expect_error(change([](auto&, auto&, auto& p) { p.pulleys[0].radius = NAN; }), {"radius of pulley 1"});
  expect_error(change([](auto&, auto&, auto& p) { p.pulleys[0].sense = 0; }), {"pulley 1", "sense"});
  expect_error(change([](auto&, auto&, auto& p) { p.pulleys[1].radius = 0.9; }), {"pulley 1", "pulley 2", "overlap"});
  expect_error(change([](auto& g, auto& ends, auto&) {
                 ends[1].marker = g.ground().marker({1.1, 0, 0});
               }),
               {"pulley 2", "the last end", "overlap"});
  expect_error(change([](auto& g, auto&, auto& p) {
                 p.pulleys[1].marker = g.ground().marker({1, 0, 0}, rotation_about({1, 0, 0}, M_PI));
               }),
               {"pulley 1", "pulley 2", "z axes"});
  expect_error(change([](auto& g, auto& ends, auto&) {
                 ends[0].marker = g.ground().marker({-1, 0, 1});
               }),
               {"pulley 1", "the first end", "plane"});
  expect_error(change([](auto&, auto& ends, auto&) { ends[0].marker = {}; }), {"the first end", "marker"});
  expect_error(change([](auto&, auto& ends, auto&) { ends.pop_back(); }), {"1 end"});
  expect_error(change([](auto&, auto&, auto& p) { p.axial_stiffness = -1; }), {"axial_stiffness"});
  expect_error(change([](auto&, auto&, auto& p) { p.axial_damping = -1; }), {"axial_damping"});
  expect_error(change([](auto&, auto&, auto& p) { p.length = 4, p.pretension = 10; }), {"length", "pretension"});
  expect_error(change([](auto&, auto&, auto& p) { p.pulleys[1].friction = 0.1; }), {"pulley 2", "friction", "mass"});
  expect_error(change([](auto&, auto&, auto& p) {
                 p.pulleys[1].friction = -0.1;
                 p.mass_per_length = 1;
               }),
               {"friction of pulley 2"});
  expect_error(change([](auto&, auto&, auto& p) { p.pulleys[1].friction = kNoSlip, p.mass_per_length = 1; }),
               {"pulley 2", "wheel"});
  expect_error(change([](auto& g, auto&, auto& p) {
                 p.pulleys[0].wheel = angle_between(g.ground().marker(), g.ground().marker());
               }),
               {"pulley 1", "wheel", "friction"});
  const auto turn = [](SystemGraph& graph, RopeParameters& p) {
    auto& wheel = graph.add<RigidBody>("wheel", {});
    auto& pin = graph.add<RevoluteJoint>("pin", {p.pulleys[0].marker, wheel.marker()});
    p.mass_per_length = 1, p.pulleys[0].friction = 0.2, p.pulleys[0].wheel = pin.angle();
  };
  expect_error(change([turn](auto& g, auto&, auto& p) { turn(g, p), p.pulleys[0].wheel = -*p.pulleys[0].wheel; }),
               {"wheel of pulley 1", "z axis"});
  expect_error(change([turn](auto& g, auto&, auto& p) { turn(g, p), p.pulleys[0].marker = p.pulleys[0].wheel->B; }),
               {"wheel of pulley 1", "z axis"});
  expect_error(change([turn](auto& g, auto&, auto& p) {
                 turn(g, p), p.pulleys[0].marker = g.template add<RigidBody>("other", {}).marker();
               }),
               {"wheel of pulley 1", "body of its marker"});
  expect_error(change([](auto&, auto& ends, auto&) { ends.clear(); }), {"closed", "mass"});
}

TEST(Rope, SensorsNameWhatIsThere) {
  SystemGraph graph;
  const Rope rope = reeve(graph, "rope", {{graph.ground().marker({-1, -1, 0})}, {graph.ground().marker({1, -1, 0})}},
                          {.pulleys = {{graph.ground().marker(), 0.1, -1}}, .axial_stiffness = 1e3});
  EXPECT_EQ(tension(rope, 1).columns()[0], "rope_tension_1");
  EXPECT_THROW(tension(rope, 2), SceneError);
  EXPECT_THROW(rope.travel(0), SceneError);
}

}  // namespace
}  // namespace lithe::test::rope_test
