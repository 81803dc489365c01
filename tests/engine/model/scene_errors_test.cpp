#include <gtest/gtest.h>

#include <limits>

#include "bodies/rigid_body.h"
#include "engine/assembly/system.h"
#include "joints/distance_joint.h"
#include "joints/fixed_joint.h"
#include "joints/forces/point_force.h"
#include "joints/forces/spring_damper.h"
#include "joints/forces/user_force.h"
#include "joints/prismatic_joint.h"
#include "joints/revolute_joint.h"
#include "joints/spherical_joint.h"
#include "joints/universal_joint.h"

namespace lithe::test::scene_errors_test {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// `where` of an error that names a line of this file.
const std::string kHere = "scene_errors_test.cpp:";

/// The error says what is wrong (each of `words`), where, and how to fix it.
template <class F>
void expect_error(F&& draw, const std::vector<std::string>& words, const std::string& where = kHere) {
  try {
    draw();
    ADD_FAILURE() << "no error; expected one with '" << words.front() << "'";
  } catch (const SceneError& error) {
    for (const std::string& word : words) EXPECT_NE(error.problem().find(word), std::string::npos) << error.what();
    EXPECT_EQ(error.where().rfind(where, 0), 0u) << error.what();
    EXPECT_FALSE(error.fix().empty()) << error.what();
  }
}

TEST(SceneErrors, ABodyNeedsMassAndAnInertiaOfARealBody) {
  SystemGraph graph;
  const auto body = [&](RigidBody::Parameters p) { graph.add<RigidBody>("body", std::move(p)); };
  expect_error([&] { body({.mass = 0}); }, {"'body'", "mass", "0"});
  expect_error([&] { body({.mass = -2}); }, {"'body'", "mass", "-2"});
  expect_error([&] { body({.mass = kNaN}); }, {"'body'", "mass", "nan"});
  expect_error([&] { body({.inertia = {1, 1, 0}}); }, {"'body'", "inertia"});
  expect_error([&] { body({.inertia = {1, 1, 3}}); }, {"'body'", "inertia", "no real body"});
  expect_error([&] { body({.inertia = {1, kNaN, 1}}); }, {"'body'", "inertia"});
  Matrix3 lopsided = Matrix3::Identity();
  lopsided(0, 1) = 0.1;
  expect_error([&] { body({.inertia = lopsided}); }, {"'body'", "inertia", "symmetric"});
  EXPECT_NO_THROW(body({.inertia = {1, 2, 3}}));  // a flat plate, and the name is still free
}

TEST(SceneErrors, APoseIsARotationAndFiniteNumbers) {
  SystemGraph graph;
  const auto body = [&](RigidBody::Parameters p) { graph.add<RigidBody>("body", std::move(p)); };
  Matrix3 sheared = Matrix3::Identity(), mirrored = Matrix3::Identity();
  sheared(0, 1) = 1e-3;
  mirrored(2, 2) = -1;
  expect_error([&] { body({.orientation = sheared}); }, {"'body'", "orientation", "not a rotation"});
  expect_error([&] { body({.orientation = mirrored}); }, {"'body'", "orientation", "not a rotation"});
  expect_error([&] { body({.orientation = Matrix3::Constant(kNaN)}); }, {"'body'", "orientation"});
  expect_error([&] { body({.position = {0, kNaN, 0}}); }, {"'body'", "position"});
  expect_error([&] { body({.velocity = {0, kInfinity, 0}}); }, {"'body'", "velocity"});
  expect_error([&] { body({.angular_velocity = {0, kNaN, 0}}); }, {"'body'", "angular_velocity"});
  auto& fine = graph.add<RigidBody>("body");
  expect_error([&] { fine.marker({kNaN, 0, 0}); }, {"marker position"}, "'body' of scene_errors_test.cpp:");
  expect_error([&] { fine.marker({0, 0, 0}, sheared); }, {"marker orientation"}, "'body' of scene_errors_test.cpp:");
  expect_error([&] { graph.ground().marker({kNaN, 0, 0}); }, {"marker position"}, "ground");
  expect_error([&] { SystemGraph weightless{{.gravity = {0, 0, kNaN}}}; }, {"gravity"}, "SystemGraph");
}

TEST(SceneErrors, ANameIsGivenOnce) {
  SystemGraph graph;
  auto& body = graph.add<RigidBody>("hub");
  expect_error([&] { graph.add<RigidBody>("hub"); }, {"'hub'", "in use since scene_errors_test.cpp"});
  expect_error([&] { graph.add<SphericalJoint>("hub", {graph.ground().marker(), body.marker()}); }, {"'hub'"});
  expect_error([&] { graph.add<RigidBody>("ground"); }, {"'ground'", "fixed body, which every graph has"});
  expect_error([&] { graph.add<RigidBody>(""); }, {"no name"});
}

TEST(SceneErrors, AJointTiesAsManyMarkersAsItHas) {
  SystemGraph graph, other;
  auto& body = graph.add<RigidBody>("body");
  auto& stranger = other.add<RigidBody>("stranger");
  const Marker fixed = graph.ground().marker(), moving = body.marker();
  expect_error([&] { graph.add<SphericalJoint>("pin", {moving}); }, {"'pin'", "2 markers", "got 1"});
  expect_error([&] { graph.add<SphericalJoint>("pin", {fixed, moving, moving}); }, {"'pin'", "2 markers", "got 3"});
  expect_error([&] { graph.add<PointForce>("push", {}); }, {"'push'", "1 markers", "got 0"});
  expect_error([&] { graph.add<SphericalJoint>("pin", {fixed, Marker{}}); }, {"'pin'", "marker 2", "no body"});
  expect_error([&] { graph.add<SphericalJoint>("pin", {fixed, Marker{&body, 7}}); }, {"'pin'", "marker 2", "'body'"});
  expect_error(
      [&] {
        graph.add<SphericalJoint>("pin", {stranger.marker(), moving});
      },
      {"'pin'", "marker 1", "another graph"});
  // Nothing of the refused joints is left.
  EXPECT_EQ(graph.find("pin"), nullptr);
  EXPECT_TRUE(graph.constraints().empty());
  EXPECT_NO_THROW(graph.add<SphericalJoint>("pin", {fixed, moving}));
  EXPECT_NO_THROW(assemble(graph));
}

TEST(SceneErrors, ParametersOfJointsAndForcesAreNumbersThatMakeSense) {
  SystemGraph graph;
  auto& body = graph.add<RigidBody>("body", {.position = {1, 0, 0}});
  const std::vector<Marker> markers{graph.ground().marker(), body.marker()};
  const auto rod = [&](double length) { graph.add<DistanceJoint>("rod", markers, {.length = length}); };
  expect_error([&] { rod(kNaN); }, {"'rod'", "length", "nan"});
  expect_error([&] { rod(-1); }, {"'rod'", "length", "-1"});
  expect_error([&] { rod(0); }, {"'rod'", "length", "0"});
  const auto spring = [&](SpringDamper::Parameters p) { graph.add<SpringDamper>("spring", markers, p); };
  expect_error([&] { spring({.stiffness = -1}); }, {"'spring'", "stiffness"});
  expect_error([&] { spring({.damping = kNaN}); }, {"'spring'", "damping"});
  expect_error([&] { spring({.natural_length = kNaN}); }, {"'spring'", "natural_length"});
  expect_error([&] { spring({.natural_length = -1}); }, {"'spring'", "natural_length"});
  expect_error([&] { spring({.preload = kInfinity}); }, {"'spring'", "preload"});
  expect_error([&] { graph.add<PointForce>("push", {body.marker()}, {.force = {0, kNaN, 0}}); }, {"'push'", "force"});
  expect_error([&] { graph.add<PointForce>("push", {body.marker()}, {.torque = {0, kNaN, 0}}); }, {"'push'", "torque"});
  expect_error([&] { graph.add<UserForce>("wind", {body.marker()}); }, {"'wind'", "law"});
}

/// A scene with one body, drawn at `position` and turned, and one joint to ground.
template <class T>
void assemble_with(const Vector3& position, const Matrix3& turned) {
  SystemGraph graph;
  auto& body = graph.add<RigidBody>("body", {.position = position, .orientation = turned});
  graph.add<T>("joint", {graph.ground().marker(), body.marker()});
  assemble(graph);
}

TEST(SceneErrors, AJointIsDrawnTheWayItIsMeant) {
  const Matrix3 about_x = rotation_about({1, 0, 0}, M_PI), about_z = rotation_about({0, 0, 1}, M_PI),
                in_a_circle = rotation_about({1, 1, 1}, 2 * M_PI / 3), crossed = rotation_about({0, 0, 1}, M_PI / 2);
  // All of these satisfy the rows.
  expect_error([&] { assemble_with<RevoluteJoint>({0, 0, 0}, about_x); }, {"'joint'", "z axes", "180"});
  expect_error([&] { assemble_with<FixedJoint>({0, 0, 0}, about_z); }, {"'joint'", "x axes", "180"});
  expect_error([&] { assemble_with<PrismaticJoint>({0, 0, 1}, in_a_circle); }, {"'joint'", "x axes", "90"});
  expect_error([&] { assemble_with<UniversalJoint>({0, 0, 0}, crossed); }, {"'joint'", "right angles"});
  expect_error([&] { assemble_with<DistanceJoint>({0, 0, 0}, about_x); }, {"'joint'", "one place"});
  EXPECT_NO_THROW(assemble_with<RevoluteJoint>({0, 0, 0}, about_z));
  EXPECT_NO_THROW(assemble_with<UniversalJoint>({0, 0, 0}, about_x));
}

TEST(SceneErrors, GroundIsNotTiedToGround) {
  SystemGraph graph;
  graph.add<RigidBody>("body");
  graph.add<SphericalJoint>("joint", {graph.ground().marker(), graph.ground().marker({1, 0, 0})});
  expect_error([&] { assemble(graph); }, {"'joint'", "ground to ground"});
}

TEST(SceneErrors, ASceneHasABody) {
  SystemGraph graph;
  expect_error([&] { assemble(graph); }, {"no body"}, "assemble");
}

TEST(SceneErrors, JointsThatCannotBeAssembledAreNamed) {
  SystemGraph graph;
  auto& link = graph.add<RigidBody>("link", {.position = {1, 0, 0}});
  graph.add<SphericalJoint>("left", {graph.ground().marker(), link.marker({-1, 0, 0})});
  graph.add<SphericalJoint>("right", {graph.ground().marker({3, 0, 0}), link.marker({1, 0, 0})});
  expect_error([&] { assemble(graph); }, {"cannot be assembled"}, "assemble");
}

}  // namespace
}  // namespace lithe::test::scene_errors_test
