#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "bodies/rigid_body.h"
#include "engine/assembly/evaluator.h"
#include "joints/cylindrical_joint.h"
#include "joints/distance_joint.h"
#include "joints/fixed_joint.h"
#include "joints/prismatic_joint.h"
#include "joints/revolute_joint.h"
#include "joints/spherical_joint.h"
#include "joints/three_node_fixation.h"
#include "joints/universal_joint.h"
#include "tests/support/dense.h"
#include "tests/support/joint_checks.h"
#include "tests/support/marker_body.h"
#include "tests/support/motion.h"
#include "tests/support/pairs.h"

namespace lithe::test::joint_rows_test {
namespace {

/// The checks that every joint owes, between every pairing of bodies. `gap`: from marker A to B as drawn.
template <class T, class... Parameters>
void check_between_all_pairs(int rank, const Vector3& gap, const Parameters&... parameters) {
  for (const Pair& pair : pairs()) {
    SCOPED_TRACE(pair.name);
    SystemGraph graph;
    const std::vector<Marker> markers = pair.draw(graph, gap);
    auto& joint = graph.add<T>("joint", markers, parameters...);
    check_joint(graph, joint, {.rank = rank});
  }
}

TEST(SphericalJoint, LeavesThreeRotationsFree) { check_between_all_pairs<SphericalJoint>(3, {0, 0, 0}); }
/// The second marker adds to the blocks that the first one writes.
TEST(SphericalJoint, HoldsTwoPlacesOfOneDeformingBodyTogether) {
  RandomNumbers random(3);
  constexpr int kModes = 7;
  const VectorX eta = random.vector(kModes, 0.3);
  const auto marker = [&] {
    return ModalMarker{random.vector3(), random.matrix3x(kModes), random.matrix3x(kModes), random.rotation()};
  };
  const ModalMarker a = marker();
  ModalMarker b = marker();
  b.c += a.point(eta) - b.point(eta);
  SystemGraph graph;
  auto& body = graph.add<MarkerBody>(
      "body", {.markers = {a, b}, .position = random.vector3(), .orientation = random.rotation(), .eta = eta});
  auto& joint = graph.add<SphericalJoint>("joint", {body.marker(0), body.marker(1)});
  check_joint(graph, joint, {.rank = 3});
}
TEST(RevoluteJoint, LeavesOneRotationFree) { check_between_all_pairs<RevoluteJoint>(5, {0, 0, 0}); }
TEST(UniversalJoint, LeavesTwoRotationsFree) { check_between_all_pairs<UniversalJoint>(4, {0, 0, 0}); }
TEST(CylindricalJoint, LeavesSlidingAndTurningFree) { check_between_all_pairs<CylindricalJoint>(4, {0, 0, 0.3}); }
TEST(PrismaticJoint, LeavesOneTranslationFree) { check_between_all_pairs<PrismaticJoint>(5, {0, 0, -0.4}); }
TEST(FixedJoint, LeavesNothingFree) { check_between_all_pairs<FixedJoint>(6, {0, 0, 0}); }
TEST(DistanceJoint, LeavesFiveFreedoms) {
  check_between_all_pairs<DistanceJoint>(1, {0.3, 0.4, -0.2}, DistanceJoint::Parameters{});
  check_between_all_pairs<DistanceJoint>(1, {0.3, 0.4, -0.2}, DistanceJoint::Parameters{.length = 0.5});
}

/// 0.2 sin 3t + start, with its derivatives.
MotionLaw swinging(double start) {
  return [start](double t) {
    return Motion{start + 0.2 * std::sin(3 * t), 0.6 * std::cos(3 * t), -1.8 * std::sin(3 * t)};
  };
}
TEST(DistanceJoint, TelescopesByALaw) {
  check_between_all_pairs<DistanceJoint>(1, {0.3, 0.4, -0.2}, DistanceJoint::Parameters{.length_law = swinging(0.5)});
}

TEST(DistanceJoint, TakesItsLengthFromTheDrawing) {
  SystemGraph graph;
  auto& ball = graph.add<RigidBody>("ball", {.position = {3, 4, 0}});
  auto& rod = graph.add<DistanceJoint>("rod", {graph.ground().marker(), ball.marker()});
  auto& other = graph.add<DistanceJoint>("other", {graph.ground().marker({3, 0, 0}), ball.marker()}, {.length = 4});
  assemble(graph);
  EXPECT_DOUBLE_EQ(rod.length(), 5);
  EXPECT_DOUBLE_EQ(other.length(), 4);
}

/// `free_motions`: what the joint leaves of B's motion in A's axes, shifts 0 1 2 and turns 3 4 5 about x y z.
template <class T>
void expect_freedoms(const Vector3& gap, const std::vector<int>& free_motions) {
  SystemGraph graph{{.gravity = Vector3::Zero()}};
  const Matrix3 axes = rotation_exp(Vector3(0.4, -0.7, 0.9));
  auto& body = graph.add<RigidBody>("body", {.position = axes * gap, .orientation = axes});
  graph.add<T>("joint", {graph.ground().marker({0, 0, 0}, axes), body.marker()});
  const System system = assemble(graph);
  Evaluator evaluator(system);
  for (int motion = 0; motion < 6; ++motion) {
    Vector6 v = Vector6::Unit(motion);        // body axes are A's axes here,
    v.head<3>() = axes * v.head<3>().eval();  // velocities are in world axes
    evaluator.evaluate(0, system.initial_state().q, v, Level::velocity);
    VectorX g_dot(T::kRows);
    evaluator.constraint(Level::velocity, g_dot);
    const bool is_free = std::find(free_motions.begin(), free_motions.end(), motion) != free_motions.end();
    if (is_free) {
      EXPECT_LT(g_dot.norm(), 1e-14) << "motion " << motion;
    } else {
      EXPECT_GT(g_dot.norm(), 0.1) << "motion " << motion;
    }
  }
}

TEST(JointFreedoms, AreThoseOfTheZAxis) {
  expect_freedoms<SphericalJoint>({0, 0, 0}, {3, 4, 5});
  expect_freedoms<RevoluteJoint>({0, 0, 0}, {5});
  expect_freedoms<UniversalJoint>({0, 0, 0}, {3, 4});
  expect_freedoms<CylindricalJoint>({0, 0, 0.5}, {2, 5});
  expect_freedoms<PrismaticJoint>({0, 0, 0.5}, {2});
  expect_freedoms<FixedJoint>({0, 0, 0}, {});
}

std::vector<Marker> three_nodes(RigidBody& body, const std::array<Vector3, 3>& points) {
  return {body.marker(points[0]), body.marker(points[1]), body.marker(points[2])};
}
constexpr double kSide = 0.4;
const std::array<Vector3, 3> kTriangle{Vector3(0, 0, 0), Vector3(kSide, 0, 0), Vector3(0.1, kSide, 0.2)};
const std::array<Vector3, 3> kLine{Vector3(0, 0, 0), Vector3(kSide, 0, 0), Vector3(3 * kSide, 0, 0)};

/// Six of the nine rows hold a rigid body; three nodes in a line hold five of its freedoms, and it swings about the
/// line.
TEST(ThreeNodeFixation, ClampsARigidBodyAndHingesOneByItsEdge) {
  for (const auto& [points, held] : {std::pair(kTriangle, 6), std::pair(kLine, 5)}) {
    SystemGraph graph;
    auto& hub = graph.add<RigidBody>("hub", {.orientation = rotation_exp(Vector3(0.2, 0.4, -0.8))});
    auto& link = graph.add<RigidBody>("link", {.position = {0.5, 0.1, -0.2}});
    std::vector<Marker> markers = three_nodes(link, points);
    markers.insert(markers.begin(), hub.marker({0.1, 0.2, 0.3}, rotation_exp(Vector3(1, 0.5, -0.5))));
    auto& clamp = graph.add<ThreeNodeFixation>("clamp", markers);
    check_joint(graph, clamp, {.rank = held});
  }
}

TEST(ThreeNodeFixation, HoldsBodyOnGroundWhereItWasDrawn) {
  SystemGraph graph;
  auto& link =
      graph.add<RigidBody>("link", {.position = {0.5, 0.1, -0.2}, .orientation = rotation_exp(Vector3(1, 2, 3))});
  std::vector<Marker> markers = three_nodes(link, kTriangle);
  markers.insert(markers.begin(), graph.ground().marker());
  graph.add<ThreeNodeFixation>("clamp", markers);
  const System system = assemble(graph);
  EXPECT_EQ(system.degrees_of_freedom(), 0);
  EXPECT_LT((system.initial_state().q.head<3>() - Vector3(0.5, 0.1, -0.2)).norm(), 1e-15);
  EXPECT_LT(system.initial_state().v_dot.norm(), 1e-10);
}

/// With modes that strain the triangle all nine rows count, and three strains are taken from the modes
/// (docs/equations.md 5.4).
TEST(ThreeNodeFixation, AlsoHoldsTheStrainsOfAFlexibleBody) {
  for (int modes : {1, 2, 3, 5}) {
    SystemGraph graph;
    RandomNumbers random(17);
    MarkerBody::Parameters parameters{.position = {0.3, 0.2, 0.1}, .eta = random.vector(modes, 0.1)};
    for (const Vector3& c : kTriangle)
      parameters.markers.push_back({c, random.matrix3x(modes, 0.3), Matrix3X::Zero(3, modes), Matrix3::Identity()});
    auto& link = graph.add<MarkerBody>("link", parameters);
    auto& hub = graph.add<RigidBody>("hub");
    auto& clamp = graph.add<ThreeNodeFixation>("clamp", {hub.marker(), link.marker(0), link.marker(1), link.marker(2)});
    check_joint(graph, clamp, {.rank = 6 + std::min(modes, 3)});
  }
}

}  // namespace
}  // namespace lithe::test::joint_rows_test
