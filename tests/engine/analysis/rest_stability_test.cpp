// Whether a rest is stable: against closed forms, and the dense linearization about it.
#include <gtest/gtest.h>

#include <cmath>

#include "bodies/beam/beam.h"
#include "bodies/beam/slender_body.h"
#include "bodies/point_mass.h"
#include "bodies/rigid_body.h"
#include "engine/analysis/equilibrium.h"
#include "engine/analysis/linearization.h"
#include "joints/distance_joint.h"
#include "joints/fixed_joint.h"
#include "joints/forces/spring_damper.h"
#include "joints/forces/user_force.h"
#include "joints/revolute_joint.h"

namespace lithe::test::rest_stability_test {
namespace {

constexpr double kGravity = 9.81;
const Matrix3 kAboutY = rotation_about({1, 0, 0}, -M_PI / 2);

/// Found, at rest.
Equilibrium rest_of(SystemGraph& graph, double time = 0) {
  const System system = assemble(graph);
  State start = system.initial_state();
  start.time = time;
  const Equilibrium found = find_equilibrium(system, start);
  EXPECT_TRUE(found.state.v.isZero(0) && found.state.v_dot.isZero(0));
  return found;
}

/// A rod of a length on a pin, upright or hanging.
RigidBody& add_rod(SystemGraph& graph, const std::string& name, double x, double length, bool upright) {
  const double up = upright ? 0.5 * length : -0.5 * length, J = length * length / 12;
  auto& rod = graph.add<RigidBody>(name, {.mass = 1, .inertia = {J, J, 0.1 * J}, .position = {x, 0, up}});
  graph.add<RevoluteJoint>("pin of " + name,
                           {graph.ground().marker({x, 0, 0}, kAboutY), rod.marker({0, 0, -up}, kAboutY)});
  return rod;
}
/// Of it: m g l/2 over m l²/3.
double of_rod(double length) { return 1.5 * kGravity / length; }

TEST(RestStability, OfAPendulumUpAndDown) {
  for (const bool upright : {true, false}) {
    SystemGraph graph;
    add_rod(graph, "rod", 0, 0.8, upright);
    const Equilibrium found = rest_of(graph);
    EXPECT_EQ(found.stability, upright ? RestStability::unstable : RestStability::stable);
    EXPECT_NEAR(found.lowest_stiffness * (upright ? -1 : 1) / of_rod(0.8), 1, 1e-8);
    EXPECT_LT(found.stiffness_uncertainty, 1e-6);
    EXPECT_NE(
        found.stability_text().find(upright ? "unstable, lowest stiffness -18.4" : "stable, lowest stiffness 18.4"),
        std::string::npos)
        << found.stability_text();
    int largest = 0;
    found.softest.cwiseAbs().maxCoeff(&largest);
    EXPECT_EQ(largest, 4);  // it turns about y
  }
}

/// Two bars on pins about y; K = -m g l/2 diag(3 s_1, s_2) with signs s of up and down, as in equilibrium_test.cpp.
TEST(RestStability, OfTwoBarsAtTheirSaddles) {
  const double m = 1, l = 1, J = 0.1;
  for (const double first : {1.0, -1.0})
    for (const double second : {1.0, -1.0}) {
      SCOPED_TRACE(testing::Message() << first << ' ' << second);
      SystemGraph graph;
      const RigidBody::Parameters bar{.mass = m, .inertia = {J, J, 1e-3}};
      RigidBody::Parameters lower = bar, upper = bar;
      lower.position = {0, 0, first * l / 2}, upper.position = {0, 0, first * l + second * l / 2};
      auto& one = graph.add<RigidBody>("one", lower);
      auto& two = graph.add<RigidBody>("two", upper);
      graph.add<RevoluteJoint>("foot",
                               {graph.ground().marker({}, kAboutY), one.marker({0, 0, -first * l / 2}, kAboutY)});
      graph.add<RevoluteJoint>(
          "knee", {one.marker({0, 0, first * l / 2}, kAboutY), two.marker({0, 0, -second * l / 2}, kAboutY)});
      const Equilibrium found = rest_of(graph);
      const double a = J + 1.25 * m * l * l, b = first * second * m * l * l / 2, c = J + 0.25 * m * l * l;
      const double k = -1.5 * m * kGravity * l * first, n = -0.5 * m * kGravity * l * second;
      const double half = (a * n + c * k) / 2, det = a * c - b * b;
      EXPECT_NEAR(found.lowest_stiffness * det / (half - std::sqrt(half * half - det * k * n)), 1, 1e-7);
      EXPECT_EQ(found.stability, first < 0 && second < 0 ? RestStability::stable : RestStability::unstable);
    }
}

/// A motion that nothing holds or drives is neither; a load that follows has no potential.
TEST(RestStability, IsUnknownWhereNothingHoldsOrLoadsFollow) {
  SystemGraph free;
  auto& ball = free.add<RigidBody>("ball", {.mass = 1, .inertia = {0.1, 0.1, 0.1}, .position = {0, 0, -1}});
  free.add<DistanceJoint>("string", {free.ground().marker(), ball.marker()}, {.length = 1});
  const Equilibrium turns = rest_of(free);
  EXPECT_EQ(turns.stability, RestStability::unknown);
  EXPECT_NEAR(turns.lowest_stiffness, 0, 1e-6);

  // Two bars upright on springs with a thrust along the upper one.
  SystemGraph graph{{.gravity = Vector3::Zero()}};
  const Vector3 half(0, 0, 0.5);
  auto& one = graph.add<RigidBody>("one", {.mass = 1, .inertia = {0.1, 0.1, 1e-3}, .position = half});
  auto& two = graph.add<RigidBody>("two", {.mass = 1, .inertia = {0.1, 0.1, 1e-3}, .position = 3 * half});
  graph.add<RevoluteJoint>("foot", {graph.ground().marker({}, kAboutY), one.marker(-half, kAboutY)});
  graph.add<RevoluteJoint>("knee", {one.marker(half, kAboutY), two.marker(-half, kAboutY)});
  for (const double side : {-1.0, 1.0}) {
    graph.add<SpringDamper>("low" + std::to_string(side), {graph.ground().marker({side, 0, 0.5}), one.marker()},
                            {.stiffness = 100, .natural_length = 1});
    graph.add<SpringDamper>("high" + std::to_string(side), {graph.ground().marker({side, 0, 1.5}), two.marker()},
                            {.stiffness = 100, .natural_length = 1});
  }
  graph.add<UserForce>("thrust", {two.marker(half)},
                       {[](double, const MarkerView& at) { return force(-5 * Vector3(at.z())); }});
  const Equilibrium thrust = rest_of(graph);
  EXPECT_EQ(thrust.stability, RestStability::unknown);
}

TEST(RestStability, IsCertainWhereJointsHoldEverything) {
  SystemGraph graph;
  auto& block = graph.add<RigidBody>("block", {.mass = 1, .inertia = {0.1, 0.1, 0.1}});
  graph.add<FixedJoint>("weld", {graph.ground().marker(), block.marker()});
  const Equilibrium found = rest_of(graph);
  EXPECT_EQ(found.stability, RestStability::stable);
  EXPECT_TRUE(std::isinf(found.lowest_stiffness));
}

/// More freedoms than the space of the search has vectors: a rod a few millimetres long that stands upright, among
/// many that hang, has the one stiffness that is far below theirs.
TEST(RestStability, OfASmallRodUprightAmongManyThatHang) {
  for (const bool upright : {true, false}) {
    SystemGraph graph;
    for (int i = 0; i < 150; ++i) add_rod(graph, "rod " + std::to_string(i), 0.1 * i, 0.5 + 0.01 * i, false);
    add_rod(graph, "small", -1, 5e-3, upright);
    const Equilibrium found = rest_of(graph);
    EXPECT_EQ(found.stability, upright ? RestStability::unstable : RestStability::stable);
    EXPECT_NEAR(found.lowest_stiffness / (upright ? -of_rod(5e-3) : of_rod(0.5 + 0.01 * 149)), 1, 1e-6);
  }
}

TEST(RestStability, OfAFlexibleRodOnAPin) {
  for (const double up : {1.0, -1.0}) {
    SystemGraph graph;
    const BeamSection section = BeamSection::rectangle(0.02, 0.02, {7e10, 0.3, 2700});
    auto& rod = graph.add<SlenderBody>("rod", {.beam = {.axis = BeamAxis::straight({0, 0, 0}, {0, 0, up}, {0, 1, 0}),
                                                        .sections = {{0, section}},
                                                        .elements = 8},
                                               .mode_count = 4});
    graph.add<RevoluteJoint>("pin", {graph.ground().marker({}, kAboutY), rod.marker_at_world({}, kAboutY)});
    const System system = assemble(graph);
    const Equilibrium found = find_equilibrium(system, system.initial_state());
    EXPECT_EQ(found.stability, up > 0 ? RestStability::unstable : RestStability::stable);
    EXPECT_NEAR(-up * found.lowest_stiffness / of_rod(1), 1, 2e-3);  // of a rigid one
    EXPECT_NEAR(found.lowest_stiffness / linearize(system, found.state).lowest_stiffness(), 1, 1e-6);
  }
}

/// A column that is clamped at its foot: straight it is stable up to Euler's load π² E I/(4 l²), beyond that bent.
TEST(RestStability, OfABeamBelowAndBeyondItsBucklingLoad) {
  const double edge = 0.02, young = 7e10, critical = M_PI * M_PI * young * std::pow(edge, 4) / 12 / 4;
  for (const double share : {0.98, 1.02})
    for (const double aside : {0.0, 0.02}) {
      SCOPED_TRACE(testing::Message() << share << ' ' << aside);
      SystemGraph graph{{.gravity = Vector3::Zero()}};
      auto& beam =
          graph.add<Beam>("beam", {.axis = BeamAxis::straight({0, 0, 0}, {0, 0, 1}, {0, 1, 0}),
                                   .sections = {{0, BeamSection::rectangle(edge, 2 * edge, {young, 0.3, 2700})}},
                                   .elements = 12});
      graph.add<FixedJoint>("clamp", {graph.ground().marker_at_world({}), beam.marker_at_world({})});
      // A second of time is a pull aside, by which the bent shape is found; at 0 it is gone.
      graph.add<UserForce>(
          "load", {beam.marker(1)}, {[=](double t, const MarkerView&) {
            return force(Vector3(0, 0, -2 * share * critical) + t * Vector3(critical * aside, critical * aside, 0));
          }});
      const System system = assemble(graph);
      State start = system.initial_state();
      if (aside > 0) {
        start.time = 1;
        start = find_equilibrium(system, start).state;
        start.time = 0;
      }
      const Equilibrium found = find_equilibrium(system, start);
      const bool straight = aside == 0;
      EXPECT_EQ(found.stability, straight && share > 1 ? RestStability::unstable : RestStability::stable)
          << found.stability_text();
      EXPECT_NEAR(found.lowest_stiffness / linearize(system, found.state).lowest_stiffness(), 1, 1e-4);
    }
}

}  // namespace
}  // namespace lithe::test::rest_stability_test
