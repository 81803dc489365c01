// Scenes as drawn and simplified, moved side by side: what vanished is read off the whole at expanded states.
#include "engine/simplify/simplification.h"

#include <gtest/gtest.h>

#include "bodies/flexible/flexible_body.h"
#include "bodies/rigid_body.h"
#include "engine/observe/sensors.h"
#include "engine/run/simulation.h"
#include "joints/coordinate_coupling.h"
#include "joints/coordinate_drive.h"
#include "joints/distance_joint.h"
#include "joints/fixed_joint.h"
#include "joints/forces/coordinate_stop.h"
#include "joints/forces/joint_friction.h"
#include "joints/forces/spring_damper.h"
#include "joints/gear_pair.h"
#include "joints/planar_joint.h"
#include "joints/prismatic_joint.h"
#include "joints/revolute_joint.h"
#include "joints/spherical_joint.h"
#include "tests/bodies/bar_model.h"
#include "tests/bodies/fe_models.h"
#include "tests/support/methods.h"

namespace lithe::test::simplification_test {
namespace {

using Draw = std::function<std::vector<Sensor>(SystemGraph&)>;
using MakeMethod = std::function<Method()>;

struct Comparison {
  std::vector<double> differences;  // of each sensor, over its largest value in the run
  double violation = 0;             // largest |g| of the whole at expanded states
  double round_trip = 0;            // of an expanded state reduced and expanded again
  int whole_velocities = 0, velocities = 0, whole_rows = 0, rows = 0, dependent_rows = 0;
  std::string report;
  bool says(const std::string& line) const { return report.find(line) != std::string::npos; }
};

Comparison compare(const Draw& draw, const MakeMethod& method, double end, const SimplificationOptions& options = {}) {
  SystemGraph graph{{.gravity = {0.3, 0.5, -9.81}}};
  const std::vector<Sensor> sensors = draw(graph);
  Simplification simple(graph, options);
  const System system = assemble(simple.graph());
  const Method whole_method = method(), small_method = method();
  Simulation whole_run(simple.whole(), *whole_method), small_run(system, *small_method);
  State whole = simple.whole().initial_state(), small = simple.start(), expanded;

  Comparison found;
  std::vector<double> largest(sensors.size(), 0.0), off = largest;
  constexpr int kTimes = 10;
  for (int k = 0; k <= kTimes; ++k) {
    whole_run.run(whole, k * end / kTimes);
    small_run.run(small, k * end / kTimes);
    simple.expand(small, expanded);
    State drawn = whole;
    drawn.lambda.resize(0);  // found from the motion in both: those of index-3 steps lag behind it
    if (expanded.lambda.size() > 0) drawn.lambda = whole.lambda;
    Snapshot a{simple.whole(), drawn}, b{simple.whole(), expanded};
    found.violation = std::max(found.violation, constraint_residual().value(b));
    State again;
    simple.expand(simple.reduce(expanded), again);
    for (const VectorX& gap :
         {VectorX(again.q - expanded.q), VectorX(again.v - expanded.v), VectorX(again.v_dot - expanded.v_dot),
          VectorX(again.quarter_turns - expanded.quarter_turns)})
      if (gap.size() > 0) found.round_trip = std::max(found.round_trip, gap.cwiseAbs().maxCoeff());
    for (std::size_t s = 0; s < sensors.size(); ++s)
      for (int c = 0; c < static_cast<int>(sensors[s].columns().size()); ++c) {
        const double x = sensors[s].value(a, c), y = sensors[s].value(b, c);
        largest[s] = std::max(largest[s], std::abs(x));
        off[s] = std::isfinite(x - y) ? std::max(off[s], std::abs(x - y)) : 1e300;
      }
  }
  for (std::size_t s = 0; s < sensors.size(); ++s) found.differences.push_back(off[s] / largest[s]);
  found.whole_velocities = simple.whole().layout().v_count(), found.velocities = system.layout().v_count();
  found.whole_rows = simple.whole().layout().row_count(), found.rows = system.layout().row_count();
  found.dependent_rows = static_cast<int>(system.redundant_rows().size());
  found.report = simple.report();
  return found;
}

double largest(const Comparison& found) {
  return *std::max_element(found.differences.begin(), found.differences.end());
}
/// The whole scene and the smaller one differ by less, and the whole's joints hold.
void expect_alike(const std::string& what, const Comparison& found, double bound) {
  expect_below(what, largest(found), bound);
  expect_below(what + ": joints of the whole", found.violation, 1e-9);
  expect_below(what + ": reduced and expanded", found.round_trip, 1e-11);
}

Method tight() { return runge_kutta(1e-11); }

/// z of a marker with these axes lies along y of the world.
const Matrix3 kAcross = rotation_about({1, 0, 0}, -M_PI / 2);
const Matrix3 kAlong = rotation_about({0, 1, 0}, M_PI / 2);  // along x

RigidBody::Parameters piece(double mass, const Vector3& inertia, const Vector3& position,
                            const Matrix3& orientation = Matrix3::Identity()) {
  return {.mass = mass, .inertia = inertia, .position = position, .orientation = orientation};
}
/// A marker of the body at a place and with axes of the world as drawn.
Marker at(RigidBody& body, const Vector3& place, const Matrix3& axes = Matrix3::Identity()) {
  const auto& p = body.parameters();
  return body.marker(p.orientation.transpose() * (place - p.position), p.orientation.transpose() * axes);
}

// ---- welds ----

/// A pendulum whose second link is three welded pieces, one of them off the axis and turned.
std::vector<Sensor> draw_welded_pendulum(SystemGraph& graph) {
  auto& upper = graph.add<RigidBody>("upper", piece(1.2, {0.01, 0.1, 0.1}, {0.5, 0, 0}));
  auto& arm = graph.add<RigidBody>("arm", piece(0.8, {0.008, 0.07, 0.07}, {1.4, 0, 0}));
  auto& motor =
      graph.add<RigidBody>("motor", piece(0.5, {0.002, 0.003, 0.004}, {1.5, 0.2, 0.1}, rotation_about({1, 2, 3}, 0.7)));
  auto& tool = graph.add<RigidBody>("tool", piece(0.3, {0.001, 0.002, 0.0015}, {1.9, 0.1, -0.1}));
  auto& pin = graph.add<SphericalJoint>("pin", {graph.ground().marker(), at(upper, {0, 0, 0})});
  graph.add<SphericalJoint>("ball", {at(upper, {1, 0, 0}), at(arm, {1, 0, 0})});
  auto& bolt = graph.add<FixedJoint>("bolt", {at(arm, {1.45, 0.1, 0.05}), at(motor, {1.45, 0.1, 0.05})});
  auto& weld = graph.add<FixedJoint>("weld", {at(arm, {1.8, 0, 0}), at(tool, {1.8, 0, 0})});
  const Marker tip = at(tool, {2, 0.1, -0.1});
  auto& rope = graph.add<SpringDamper>("rope", {graph.ground().marker({2, 0.3, 1}), tip},
                                       {.stiffness = 30, .damping = 0.2, .natural_length = 1});
  graph.add<SpringDamper>("band", {at(motor, {1.5, 0.3, 0.1}), at(tool, {1.9, 0.2, 0})},
                          {.stiffness = 50, .natural_length = 0.2});  // within the welded pieces
  return {position(tip),
          acceleration(tip),
          coordinates(motor),
          generalized_velocities(tool),
          angular_acceleration(motor.marker()),
          joint_reaction(bolt),
          joint_reaction(weld),
          joint_reaction(pin),
          applied_force(rope, 1),
          total_energy(),
          kinetic_energy(tool),
          potential_energy(motor)};
}

TEST(Simplification, PiecesWeldedTogetherMoveAsOneBodyWithTheReactionsBetweenThem) {
  const Comparison found = compare(draw_welded_pendulum, tight, 1);
  EXPECT_EQ(found.whole_velocities, 24);
  EXPECT_EQ(found.velocities, 12);
  EXPECT_EQ(found.rows, 6);
  EXPECT_TRUE(found.says("'motor' and 'tool' are one body with 'arm': welded by 'bolt' and 'weld'.")) << found.report;
  expect_alike("explicit", found, 1e-9);
}

TEST(Simplification, AWeldedBodyStepsAboutItsOwnCentreOfMass) {
  // Finite steps of pieces and of their sum differ by the step's own error, of second order.
  const double coarse = largest(compare(
                   draw_welded_pendulum, [] { return index3(2e-3); }, 0.5)),
               fine = largest(compare(
                   draw_welded_pendulum, [] { return index3(5e-4); }, 0.5));
  expect_below("steps of 2 ms", coarse, 1e-3);
  expect_below("steps of 0.5 ms", fine, coarse / 12);
}

/// A plate welded to two feet, these to ground, all in a loop and with a bearing besides; an arm on the plate.
std::vector<Sensor> draw_machine(SystemGraph& graph) {
  auto& plate = graph.add<RigidBody>("plate", piece(20, {1, 1, 2}, {0, 0, 0.5}));
  auto& left = graph.add<RigidBody>("left foot", piece(3, {0.1, 0.1, 0.1}, {-0.5, 0, 0.2}));
  auto& right =
      graph.add<RigidBody>("right foot", piece(3, {0.1, 0.1, 0.1}, {0.5, 0, 0.2}, rotation_about({0, 0, 1}, 0.4)));
  auto& arm = graph.add<RigidBody>("arm", piece(2, {0.01, 0.2, 0.2}, {0.5, 0, 0.6}));
  auto& tool = graph.add<RigidBody>("tool", piece(1, {0.01, 0.01, 0.02}, {1.1, 0.1, 0.6}));
  auto& floor_left = graph.add<FixedJoint>("floor left", {graph.ground().marker({-0.5, 0, 0}), at(left, {-0.5, 0, 0})});
  graph.add<FixedJoint>("floor right", {graph.ground().marker({0.5, 0, 0}), at(right, {0.5, 0, 0})});
  auto& top_left = graph.add<FixedJoint>("top left", {at(left, {-0.5, 0, 0.4}), at(plate, {-0.5, 0, 0.4})});
  graph.add<FixedJoint>("top right", {at(right, {0.5, 0, 0.4}), at(plate, {0.5, 0, 0.4})});
  auto& bearing = graph.add<RevoluteJoint>("bearing", {at(left, {0, 0, 0.3}), at(right, {0, 0, 0.3})});
  auto& pin = graph.add<RevoluteJoint>("pin", {at(plate, {0, 0, 0.6}, kAcross), at(arm, {0, 0, 0.6}, kAcross)});
  auto& wrist = graph.add<RevoluteJoint>("wrist", {at(arm, {1, 0, 0.6}, kAlong), at(tool, {1, 0, 0.6}, kAlong)});
  graph.add<CoordinateStop>("stop", {pin.angle()}, {.lower = -0.1, .upper = 0.7, .stiffness = 2000, .exponent = 1});
  graph.add<SpringDamper>("strut", {at(left, {-0.5, 0, 0.3}), at(plate, {0, 0, 0.5})},
                          {.stiffness = 1e3, .natural_length = 0.1});
  return {position(at(tool, {1.2, 0, 0})),
          joint_reaction(floor_left),
          joint_reaction(top_left),
          joint_reaction(pin),
          joint_reaction(bearing),
          coordinate(pin.angle(), "turn"),
          coordinate_rate(wrist.angle(), "w"),
          total_energy(),
          potential_energy(plate)};
}

TEST(Simplification, BodiesWeldedToGroundAreGroundAndStillBearTheirLoads) {
  const SimplificationOptions spatial{.planar = false};
  const Comparison found = compare(draw_machine, tight, 0.8, spatial);
  EXPECT_EQ(found.whole_velocities, 30);
  EXPECT_EQ(found.velocities, 12);
  EXPECT_EQ(found.rows, 10);
  EXPECT_TRUE(found.says("'plate', 'left foot' and 'right foot' are part of the ground: welded by ")) << found.report;
  EXPECT_TRUE(found.says("'bearing' holds what is welded already.")) << found.report;
  EXPECT_TRUE(found.says(" is left out: it repeats ")) << found.report;
  expect_alike("explicit", found, 1e-8);
  expect_alike("generalized-alpha",
               compare(
                   draw_machine, [] { return index3(2e-3); }, 0.4, spatial),
               1e-8);
  // The arm alone moves in a plane, but explicit integrators know a tree in space.
  const Comparison tree = compare(draw_machine, tight, 0.8);
  EXPECT_EQ(tree.velocities, 12);
}

TEST(Simplification, EachRuleCanBeTurnedOff) {
  const Comparison nothing = compare(draw_machine, tight, 0.1, {.weld = false, .hold = false, .planar = false});
  EXPECT_EQ(nothing.velocities, nothing.whole_velocities);
  EXPECT_EQ(nothing.rows, nothing.whole_rows);
  EXPECT_EQ(compare(draw_machine, tight, 0.1, {.weld = true, .hold = false, .planar = false}).velocities, 18);
  EXPECT_EQ(compare(draw_welded_pendulum, tight, 0.1, {.weld = false}).velocities, 24);
}

TEST(Simplification, StatesOfAnotherSystemAndScenesWithoutMotionAreMet) {
  SystemGraph graph;
  auto& block = graph.add<RigidBody>("block", piece(1, {1, 1, 1}, {0, 0, 0}));
  graph.add<FixedJoint>("bolt", {graph.ground().marker(), block.marker()});
  Simplification simple(graph, {.planar = false});  // something has to be left
  EXPECT_FALSE(simple.smaller());
  EXPECT_EQ(assemble(simple.graph()).layout().v_count(), 6);
  State state = simple.start();
  state.v.resize(3);
  EXPECT_THROW(simple.reduce(state), SceneError);
  State whole;
  EXPECT_THROW(simple.expand(state, whole), SceneError);
}

TEST(Simplification, AJointStaysWhereItsReactionIsFeltOrSomethingElseActsBetweenItsBodies) {
  const auto draw = [](int what) -> Draw {
    return [what](SystemGraph& graph) -> std::vector<Sensor> {
      auto& arm = graph.add<RigidBody>("arm", piece(1, {0.01, 0.1, 0.1}, {0.5, 0, 0}));
      auto& box = graph.add<RigidBody>("box", piece(1, {0.02, 0.02, 0.03}, {1.1, 0.1, 0}));
      auto& pin = graph.add<RevoluteJoint>("pin", {graph.ground().marker({}, kAcross), at(arm, {0, 0, 0}, kAcross)});
      const Vector3 seat = what == 2 ? Vector3(1, 0.01, 0) : Vector3(1, 0, 0);
      auto& bolt = graph.add<FixedJoint>("bolt", {at(arm, {1, 0, 0}), at(box, seat)});
      if (what == 0)
        graph.add<JointFriction>("rub", {pin.angle()}, {.joint = &bolt, .coefficient = 0.3, .radius = 0.02});
      if (what == 1)
        graph.add<CoordinateDrive>("drive", {angle_between(at(arm, {1, 0, 0}), at(box, {1, 0, 0}))},
                                   {.motion = constant(0)});
      return {position(box.marker()), joint_reaction(bolt), joint_reaction(pin), total_energy()};
    };
  };
  const std::string reasons[] = {"'bolt' stays a joint: 'rub' asks for its reaction.",
                                 "bodies welded to 'arm' stay apart: 'drive' acts between them.",
                                 "'bolt' stays a joint: it does not close as drawn."};
  for (int what = 0; what < 3; ++what) {
    const Comparison found = compare(draw(what), tight, 0.5, {.planar = false});
    EXPECT_EQ(found.velocities, 12) << what;
    EXPECT_TRUE(found.says(reasons[what])) << found.report;
    expect_alike(reasons[what], found, 1e-8);
  }
}

TEST(Simplification, FrictionOfABearingIsToldThoughAWeldBesideItHasGone) {
  const Draw draw = [](SystemGraph& graph) -> std::vector<Sensor> {
    auto& arm = graph.add<RigidBody>("arm", piece(1, {0.01, 0.1, 0.1}, {0.5, 0, 0}));
    auto& box = graph.add<RigidBody>("box", piece(1, {0.02, 0.02, 0.03}, {1.1, 0.1, 0}));
    auto& pin = graph.add<RevoluteJoint>("pin", {graph.ground().marker({}, kAcross), at(arm, {0, 0, 0}, kAcross)});
    auto& bolt = graph.add<FixedJoint>("bolt", {at(arm, {1, 0, 0}), at(box, {1, 0, 0})});
    auto& rub = graph.add<JointFriction>("rub", {pin.angle()}, {.joint = &pin, .coefficient = 0.3, .radius = 0.05});
    return {position(box.marker()), applied_force(rub, 1), power(rub), joint_reaction(bolt), joint_reaction(pin)};
  };
  const Comparison found = compare(draw, tight, 1);
  EXPECT_EQ(found.velocities, 6);
  expect_alike("explicit", found, 1e-8);
}

TEST(Simplification, AFlexibleBarCarriesAWeldedPairOnARigidClamp) {
  const FiniteElementModel model =
      bar_model({.size = {0.3, 0.04, 0.03}, .bricks = {4, 1, 1}, .young = 3e6, .density = 1000});
  const auto &start = model.node_set("start"), &end = model.node_set("end");
  const auto basis = make_basis(model, MeanAxisFrame{}, 2, {.loaded = {{start}, {end}}});
  const Draw draw = [&](SystemGraph& graph) -> std::vector<Sensor> {
    auto& clamp = graph.add<RigidBody>("clamp", piece(2, {0.01, 0.01, 0.01}, {-0.1, 0, 0}));
    auto& hub = graph.add<RigidBody>("hub", piece(0.5, {0.001, 0.002, 0.003}, {-0.05, 0, 0.05}));
    auto& bar = graph.add<FlexibleBody>("bar", {.basis = basis});
    auto& bob = graph.add<RigidBody>("bob", piece(0.3, {1e-3, 2e-3, 2e-3}, {0.35, 0, 0}));
    auto& hook = graph.add<RigidBody>("hook", piece(0.1, {1e-4, 1e-4, 1e-4}, {0.35, 0.05, -0.05}));
    graph.add<FixedJoint>("anchor", {graph.ground().marker({-0.1, 0, 0}), at(clamp, {-0.1, 0, 0})});
    graph.add<RevoluteJoint>("pin", {at(clamp, {0, 0, 0}, kAcross), at(hub, {0, 0, 0}, kAcross)});
    auto& root = graph.add<FixedJoint>("root", {at(hub, {0, 0, 0}), bar.average(start)});
    auto& tip = graph.add<FixedJoint>("tip", {bar.average(end), at(bob, {0.3, 0, 0})});
    auto& weld = graph.add<FixedJoint>("weld", {at(bob, {0.35, 0, 0}), at(hook, {0.35, 0, 0})});
    return {position(hook.marker()), modal_coordinates(bar), joint_reaction(root), joint_reaction(tip),
            joint_reaction(weld),    elastic_energy(),       total_energy()};
  };
  const Comparison found = compare(
      draw, [] { return runge_kutta(1e-10); }, 0.05);
  EXPECT_TRUE(found.says("'hook' is one body with 'bob': welded by 'weld'.")) << found.report;
  EXPECT_TRUE(found.says("'clamp' is part of the ground: welded by 'anchor'.")) << found.report;
  EXPECT_TRUE(found.says("'hub' moves in a plane")) << found.report;
  EXPECT_EQ(found.whole_velocities - found.velocities, 6 + 6 + 3);
  expect_alike("explicit", found, 1e-7);
}

// ---- planes ----

/// Crank, rod, slider, in a plane whose axes are `world`; the rod's markers and mass lie out of it.
Draw slider_crank(const Matrix3& world, double friction = 0) {
  return [=](SystemGraph& graph) -> std::vector<Sensor> {
    const double reach = std::sqrt(0.8 * 0.8 - 0.3 * 0.3), speed = 5;
    const auto place = [&](double x, double y, double z) -> Vector3 { return world * Vector3(x, y, z); };
    const Matrix3 across = world * kAcross, along = world * kAlong;
    RigidBody::Parameters turning =
        piece(1, {0.01, 0.02, 0.025}, place(0, 0, 0.15), world * rotation_about({1, 2, 1}, 0.3));
    turning.velocity = world * Vector3(0.15 * speed, 0, 0);
    turning.angular_velocity = turning.orientation.transpose() * (world * Vector3(0, speed, 0));
    RigidBody::Parameters sliding = piece(2, {0.01, 0.01, 0.01}, place(reach, 0, 0));
    RigidBody::Parameters swinging = piece(0.7, {0.02, 0.04, 0.05}, place(reach / 2, 0.05, 0.15), world);
    swinging.velocity = sliding.velocity = world * Vector3(0.3 * speed, 0, 0);
    auto& crank = graph.add<RigidBody>("crank", turning);
    auto& rod = graph.add<RigidBody>("rod", swinging);
    auto& slider = graph.add<RigidBody>("slider", sliding);
    auto& pin = graph.add<RevoluteJoint>(
        "pin", {graph.ground().marker(place(0, 0, 0), across), at(crank, place(0, 0, 0), across)});
    auto& big = graph.add<RevoluteJoint>(
        "big end", {at(crank, place(0, 0.02, 0.3), across), at(rod, place(0, 0.02, 0.3), across)});
    auto& small = graph.add<RevoluteJoint>(
        "small end", {at(rod, place(reach, 0, 0), across), at(slider, place(reach, 0, 0), across)});
    auto& guide = graph.add<PrismaticJoint>(
        "guide", {graph.ground().marker(place(0, 0, 0), along), at(slider, place(reach, 0, 0), along)});
    // Pulls out of the plane too.
    graph.add<SpringDamper>("spring", {graph.ground().marker(place(1.5, 0.1, 0)), at(rod, place(reach, 0, 0.1))},
                            {.stiffness = 200, .damping = 1, .natural_length = 0.5});
    if (friction > 0)
      graph.add<JointFriction>("rub", {guide.displacement()},
                               {.joint = &guide, .coefficient = friction, .creep_speed = 0.3});
    return {position(at(rod, place(0.1, 0.2, 0.3))),
            coordinates(crank),
            generalized_velocities(rod),
            acceleration(at(rod, place(0, 1, 0))),
            joint_reaction(pin),
            joint_reaction(big),
            joint_reaction(small),
            joint_reaction(guide),
            total_energy(),
            coordinate(pin.angle(), "turn")};
  };
}

TEST(Simplification, ASliderCrankKeepsThreeCoordinatesABodyAndItsReactionsOutOfThePlane) {
  for (const Matrix3& world : {Matrix3(Matrix3::Identity()), rotation_about({1, 2, -1}, 0.8)}) {
    const Draw draw = slider_crank(world);
    const Comparison found = compare(draw, tight, 1);
    EXPECT_EQ(found.whole_velocities, 18);
    EXPECT_EQ(found.velocities, 9);
    EXPECT_EQ(found.rows, 8);
    EXPECT_EQ(found.dependent_rows, 0);
    EXPECT_TRUE(found.says("'crank', 'rod' and 'slider' move in planes: three coordinates each.")) << found.report;
    EXPECT_TRUE(found.says("12 rows that say nothing in these planes are left out.")) << found.report;
    expect_alike("explicit", found, 1e-9);
    expect_alike("generalized-alpha, index 3",
                 compare(
                     draw, [] { return index3(2e-3); }, 1),
                 1e-9);
    expect_alike("generalized-alpha, index 2",
                 compare(
                     draw, [] { return index2(2e-3); }, 1),
                 1e-9);
    expect_alike("RATTLE",
                 compare(
                     draw, [] { return rattle(2e-3); }, 1),
                 1e-9);
    expect_alike("Radau",
                 compare(
                     draw, [] { return radau(1e-9); }, 1),
                 1e-7);
    expect_alike("BDF",
                 compare(
                     draw, [] { return bdf(1e-9); }, 1),
                 1e-5);
    expect_alike("IDA",
                 compare(
                     draw, [] { return ida(1e-9); }, 1),
                 1e-5);
  }
}

TEST(Simplification, AFourBarWithAWeldedCouplerMovesInThePlane) {
  const Draw draw = [](SystemGraph& graph) -> std::vector<Sensor> {
    auto& left = graph.add<RigidBody>("left", piece(1, {0.08, 0.09, 0.01}, {0, 0, 0.5}));
    auto& coupler = graph.add<RigidBody>("coupler", piece(1.5, {0.02, 0.1, 0.1}, {0.4, 0, 1}));
    auto& load =
        graph.add<RigidBody>("load", piece(0.6, {0.02, 0.03, 0.01}, {0.7, 0.2, 1.3}, rotation_about({1, 1, 0}, 1)));
    auto& right = graph.add<RigidBody>("right", piece(1, {0.08, 0.09, 0.01}, {0.9, 0, 0.6}));
    const auto hinge = [&](const std::string& name, const Marker& A, const Marker& B) -> RevoluteJoint& {
      return graph.add<RevoluteJoint>(name, {A, B});
    };
    auto& pin = hinge("pin", graph.ground().marker({0, 0, 0}, kAcross), at(left, {0, 0, 0}, kAcross));
    hinge("knee", at(left, {0, 0, 1}, kAcross), at(coupler, {0, 0, 1}, kAcross));
    hinge("elbow", at(coupler, {0.8, 0, 1.2}, kAcross), at(right, {0.8, 0, 1.2}, kAcross));
    hinge("foot", graph.ground().marker({1, 0, 0}, kAcross), at(right, {1, 0, 0}, kAcross));
    auto& bolt = graph.add<FixedJoint>("bolt", {at(coupler, {0.7, 0.1, 1.2}), at(load, {0.7, 0.1, 1.2})});
    return {position(load.marker()), joint_reaction(pin), joint_reaction(bolt), coordinates(load), total_energy()};
  };
  const Comparison found = compare(draw, tight, 1);
  EXPECT_EQ(found.velocities, 9);
  EXPECT_EQ(found.rows, 8);
  expect_alike("explicit", found, 1e-8);
}

TEST(Simplification, GearsRodsBeltsAndDrivesWorkInTheirPlanes) {
  const Draw draw = [](SystemGraph& graph) -> std::vector<Sensor> {
    auto& ground = graph.ground();
    const auto shaft = [&](const std::string& name, const Vector3& place, const Matrix3& axes) -> RigidBody& {
      return graph.add<RigidBody>(name, piece(1, {0.01, 0.012, 0.015}, place, axes * rotation_about({0, 0, 1}, 0.2)));
    };
    // Two gears about y, the first driven, the second pulls a slider by a slanting rod.
    auto& wheel = shaft("wheel", {0, 0, 0}, kAcross);
    auto& gear = shaft("gear", {0.5, 0.1, 0}, kAcross);
    auto& pin = graph.add<RevoluteJoint>("pin", {ground.marker({}, kAcross), at(wheel, {0, 0, 0}, kAcross)});
    graph.add<RevoluteJoint>("axle", {ground.marker({0.5, 0, 0}, kAcross), at(gear, {0.5, 0, 0}, kAcross)});
    auto& teeth = graph.add<GearPair>("teeth", {at(wheel, {0, 0, 0}, kAcross), at(gear, {0.5, 0, 0}, kAcross)},
                                      {.radius_A = 0.2, .radius_B = 0.3});
    auto& drive = graph.add<CoordinateDrive>("drive", {pin.angle()}, {.motion = smooth_step(0, 9, 0, 1)});
    auto& slider = graph.add<RigidBody>("slider", piece(2, {0.01, 0.01, 0.01}, {1.3, 0.3, 0.1}));
    graph.add<PrismaticJoint>("guide", {ground.marker({1, 0.3, 0.1}, kAlong), at(slider, {1.3, 0.3, 0.1}, kAlong)});
    auto& rod = graph.add<DistanceJoint>("rod", {at(gear, {0.6, 0, 0.05}), at(slider, {1.3, 0.3, 0})});
    // A fan about another axis by a belt, a bead on a wire of its own.
    auto& fan = shaft("fan", {3, 1, 0}, kAlong);
    auto& hub = graph.add<RevoluteJoint>("hub", {ground.marker({3, 1.1, 0}, kAlong), at(fan, {3, 1.1, 0}, kAlong)});
    graph.add<CoordinateCoupling>("belt", {pin.angle(), hub.angle()}, {.factors = {1, -0.5}});
    const Matrix3 wire = rotation_about({1, 1, 0}, 0.7);
    auto& bead = graph.add<RigidBody>("bead", piece(0.5, {1e-3, 1e-3, 1e-3}, {0, 2, 0}));
    auto& slide = graph.add<PrismaticJoint>("wire", {ground.marker({0, 2, 0}, wire), at(bead, {0, 2, 0}, wire)});
    graph.add<SpringDamper>("spring", {at(fan, {3, 1.3, 0.2}), bead.marker()}, {.stiffness = 40, .damping = 0.5});
    return {position(slider.marker()),
            coordinates(gear),
            coordinates(bead),
            joint_reaction(teeth),
            joint_reaction(drive),
            joint_reaction(rod),
            joint_reaction(slide),
            power(drive),
            acceleration(bead.marker()),
            total_energy(),
            coordinate(hub.angle(), "turn")};
  };
  const Comparison found = compare(draw, tight, 1);
  EXPECT_EQ(found.velocities, 15);
  EXPECT_EQ(found.rows, 14);
  EXPECT_EQ(found.dependent_rows, 0);
  expect_alike("explicit", found, 1e-8);
  expect_alike("generalized-alpha",
               compare(
                   draw, [] { return index3(2e-3); }, 1),
               1e-7);
}

TEST(Simplification, VelocitiesOutOfThePlaneAreTheJointsAffair) {
  const Draw draw = [](SystemGraph& graph) -> std::vector<Sensor> {
    RigidBody::Parameters swinging = piece(1, {0.03, 0.1, 0.12}, {0.5, 0, 0}, rotation_about({1, 0, 0}, 0.3));
    swinging.angular_velocity = {1, 2, 3};
    auto& bob = graph.add<RigidBody>("bob", swinging);
    auto& pin = graph.add<RevoluteJoint>("pin", {graph.ground().marker({}, kAcross), at(bob, {0, 0, 0}, kAcross)});
    return {position(bob.marker()), generalized_velocities(bob), joint_reaction(pin)};
  };
  const Comparison found = compare(draw, tight, 1);
  EXPECT_EQ(found.velocities, 3);
  expect_alike("explicit", found, 1e-9);
}

TEST(Simplification, APuckOnATableNeedsNoRowsAndItsTurnsAreCounted) {
  const Draw draw = [](SystemGraph& graph) -> std::vector<Sensor> {
    RigidBody::Parameters spinning = piece(1, {0.02, 0.02, 0.03}, {0, 0, 0.1});
    spinning.velocity = {1, 0, 0}, spinning.angular_velocity = {0, 0, 12};
    auto& puck = graph.add<RigidBody>("puck", spinning);
    auto& table = graph.add<PlanarJoint>("table", {graph.ground().marker({0.1, 0.2, 0}), at(puck, {0, 0, 0})});
    graph.add<SpringDamper>("string", {graph.ground().marker({0, 0.5, 0}), at(puck, {0.05, 0, 0.1})},
                            {.stiffness = 20});
    return {coordinate(table.angle(), "turn"), coordinates(puck), joint_reaction(table)};
  };
  const Comparison found = compare(
      draw, [] { return index2(2e-3); }, 2);
  EXPECT_EQ(found.velocities, 3);
  EXPECT_EQ(found.rows, 0);
  expect_alike("generalized-alpha, index 2", found, 1e-10);  // index 3 starts otherwise without rows
}

TEST(Simplification, OnlyJointsMakeAPlane) {
  // It swings in a plane, but nothing holds it there.
  const Draw draw = [](SystemGraph& graph) -> std::vector<Sensor> {
    auto& bob = graph.add<RigidBody>("bob", piece(1, {0.03, 0.1, 0.12}, {0.5, 0, 0}));
    graph.add<SphericalJoint>("ball", {graph.ground().marker(), at(bob, {0, 0, 0})});
    return {position(bob.marker())};
  };
  EXPECT_EQ(compare(draw, tight, 0.1).velocities, 6);
}

TEST(Simplification, FrictionFeelsForcesOutOfThePlaneSoThatItsMechanismStaysSpatial) {
  const Comparison found = compare(
      slider_crank(Matrix3::Identity(), 0.2), [] { return index3(2e-3); }, 0.2);
  EXPECT_EQ(found.velocities, 18);
  expect_alike("generalized-alpha", found, 1e-9);
}

}  // namespace
}  // namespace lithe::test::simplification_test
