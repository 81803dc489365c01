#include <gtest/gtest.h>

#include <limits>

#include "bodies/integral_state.h"
#include "bodies/rigid_body.h"
#include "engine/assembly/system.h"
#include "joints/constant_velocity_joint.h"
#include "joints/coordinate_coupling.h"
#include "joints/coordinate_drive.h"
#include "joints/forces/bushing.h"
#include "joints/forces/coordinate_motor.h"
#include "joints/forces/coordinate_spring.h"
#include "joints/forces/coordinate_stop.h"
#include "joints/forces/distributed_load.h"
#include "joints/forces/joint_friction.h"
#include "joints/forces/pid_controller.h"
#include "joints/forces/spring_damper.h"
#include "joints/gear_pair.h"
#include "joints/planar_joint.h"
#include "joints/rack_and_pinion.h"
#include "joints/revolute_joint.h"
#include "joints/rolling_disc.h"
#include "joints/screw_joint.h"

/// Bad input of the elements on joint coordinates: an error that names the element and the line, and how to fix it.
namespace lithe::test::element_errors_test {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
const Matrix3 kUpsideDown = rotation_about({1, 0, 0}, M_PI), kTwisted = rotation_about({0, 0, 1}, M_PI);

template <class F>
void expect_error(F&& draw, const std::vector<std::string>& words) {
  try {
    draw();
    ADD_FAILURE() << "no error; expected one with '" << words.back() << "'";
  } catch (const SceneError& error) {
    for (const std::string& word : words) EXPECT_NE(error.problem().find(word), std::string::npos) << error.what();
    EXPECT_EQ(error.where().rfind("element_errors_test.cpp:", 0), 0u) << error.what();
    EXPECT_FALSE(error.fix().empty()) << error.what();
  }
}

/// A shaft on a pin, to add elements to.
struct Bench {
  SystemGraph graph;
  RigidBody* body;
  RevoluteJoint* pin;

  explicit Bench(const Vector3& place = {0, 0, 0}, const Matrix3& axes = Matrix3::Identity()) {
    body = &graph.add<RigidBody>("body", {.position = place, .orientation = axes});
    pin = &graph.add<RevoluteJoint>("pin", {graph.ground().marker(place, axes), body->marker()});
  }
  std::vector<Marker> markers() { return {graph.ground().marker(), body->marker()}; }
  JointCoordinate angle() const { return pin->angle(); }
};

template <class T, class... Parameters>
void refuses(const std::vector<std::string>& words, const Parameters&... parameters) {
  Bench bench;
  expect_error([&] { bench.graph.add<T>("bad", bench.markers(), parameters...); }, words);
}
template <class T>
void refuses_on_angle(const std::vector<std::string>& words, const typename T::Parameters& parameters) {
  Bench bench;
  expect_error([&] { bench.graph.add<T>("bad", {bench.angle()}, parameters); }, words);
  expect_error([&] { bench.graph.add<T>("bad", std::vector<JointCoordinate>{}, parameters); }, {"'bad'"});
}
/// Drawn upside down or twisted, known when the scene is assembled.
template <class T, class... Parameters>
void refuses_drawing(const Vector3& place, const Matrix3& axes, const std::vector<std::string>& words,
                     const Parameters&... parameters) {
  SystemGraph graph;
  auto& body = graph.add<RigidBody>("body", {.position = place, .orientation = axes});
  graph.add<T>("bad", {graph.ground().marker(), body.marker()}, parameters...);
  expect_error([&] { assemble(graph); }, words);
}

TEST(ElementErrors, JointsNeedTheirSizes) {
  for (double value : {0.0, kNaN, kInfinity}) {
    refuses<ScrewJoint>({"'bad'", "lead"}, ScrewJoint::Parameters{.lead = value});
    refuses<RackAndPinion>({"'bad'", "radius"}, RackAndPinion::Parameters{.radius = value});
    refuses<GearPair>({"'bad'", "radi"}, GearPair::Parameters{.radius_A = 0.1, .radius_B = value});
    refuses<RollingDisc>({"'bad'", "radius"}, RollingDisc::Parameters{.radius = value});
  }
  refuses<GearPair>({"'bad'", "radii"}, GearPair::Parameters{.radius_A = 0.1, .radius_B = -0.1});
  refuses<RollingDisc>({"'bad'", "radius"}, RollingDisc::Parameters{.radius = -1});
}

TEST(ElementErrors, JointsAreDrawnTheRightWayRound) {
  refuses_drawing<PlanarJoint>({0, 0, 0}, kUpsideDown, {"'bad'", "z"});
  refuses_drawing<ConstantVelocityJoint>({0, 0, 0}, kUpsideDown, {"'bad'", "z"});
  refuses_drawing<ConstantVelocityJoint>({0, 0, 0}, kTwisted, {"'bad'", "x"});
  refuses_drawing<ScrewJoint>({0, 0, 0}, kUpsideDown, {"'bad'", "z"}, ScrewJoint::Parameters{.lead = 0.1});
  refuses_drawing<RackAndPinion>({0, 0, 0}, kUpsideDown, {"'bad'", "z"}, RackAndPinion::Parameters{.radius = 0.1});
  refuses_drawing<GearPair>({0.3, 0, 0}, kUpsideDown, {"'bad'", "z"},
                            GearPair::Parameters{.radius_A = 0.1, .radius_B = 0.2});
  refuses_drawing<GearPair>({0.4, 0, 0}, Matrix3::Identity(), {"'bad'", "0.4", "0.3"},
                            GearPair::Parameters{.radius_A = 0.1, .radius_B = 0.2});
  refuses_drawing<RollingDisc>({0, 0, 0.1}, Matrix3::Identity(), {"'bad'", "z"},
                               RollingDisc::Parameters{.radius = 0.1});
}

TEST(ElementErrors, SpringsInOnePlaceHaveNoTension) {
  // 3 N/m from a free length of 2 m, and a preload: along which line?
  const Matrix3 E = Matrix3::Identity();
  refuses_drawing<SpringDamper>({0, 0, 0}, E, {"'bad'", "one place", "-6.0", "direction"},
                                SpringDamper::Parameters{.stiffness = 3, .natural_length = 2});
  refuses_drawing<SpringDamper>({0, 0, 0}, E, {"'bad'", "one place", "4.0"}, SpringDamper::Parameters{.preload = 4});
  refuses_drawing<SpringDamper>({0, 0, 0}, E, {"'bad'", "one place", "-0.5"},
                                SpringDamper::Parameters{.natural_length = 1, .law = [](double stretch, double) {
                                                           return Tension{.force = 0.5 * stretch};
                                                         }});
  // k d needs no line: a spring of free length zero, or as drawn, and a damper.
  const auto accepts = [](const Vector3& place, const SpringDamper::Parameters& parameters) {
    SystemGraph graph;
    auto& body = graph.add<RigidBody>("body", {.position = place});
    graph.add<SpringDamper>("fine", {graph.ground().marker(), body.marker()}, parameters);
    EXPECT_NO_THROW(assemble(graph));
  };
  accepts({0, 0, 0}, {.stiffness = 3, .damping = 1, .natural_length = 0});
  accepts({0, 0, 0}, {.stiffness = 3, .damping = 1});
  accepts({1e-9, 0, 0}, {.stiffness = 3, .natural_length = 2});
}

TEST(ElementErrors, CouplingsNeedAFactorForEachCoordinate) {
  Bench bench;
  const auto couple = [&](std::vector<JointCoordinate> coordinates, CoordinateCoupling::Parameters p) {
    bench.graph.add<CoordinateCoupling>("bad", std::move(coordinates), std::move(p));
  };
  const JointCoordinate x = bench.angle();
  expect_error([&] { couple({x}, {}); }, {"'bad'", "factors"});
  expect_error([&] { couple({x, -x}, {.factors = {1}}); }, {"'bad'", "factors"});
  expect_error([&] { couple({x, x, x, x, x}, {.factors = {1, 1, 1, 1, 1}}); }, {"'bad'", "5"});
  expect_error([&] { couple({x}, {.factors = {kNaN}}); }, {"'bad'", "factors"});
  expect_error([&] { couple({x}, {.factors = {1}, .offset = kNaN}); }, {"'bad'", "offset"});
  expect_error([&] { couple({x}, {.factors = {0}}); }, {"'bad'", "factors"});
}

TEST(ElementErrors, DrivesAndForcesNeedTheirLaws) {
  refuses_on_angle<CoordinateDrive>({"'bad'", "motion"}, {});
  refuses_on_angle<CoordinateMotor>({"'bad'", "law"}, {});
  refuses_on_angle<CoordinateSpring>({"'bad'", "stiffness"}, {.stiffness = -1});
  refuses_on_angle<CoordinateSpring>({"'bad'", "damping"}, {.damping = kNaN});
  refuses_on_angle<CoordinateSpring>({"'bad'", "free_value"}, {.free_value = kInfinity});
  refuses_on_angle<CoordinateSpring>({"'bad'", "preload"}, {.preload = kNaN});
  refuses_on_angle<CoordinateStop>({"'bad'", "limit"}, {.lower = 1, .upper = -1, .stiffness = 1});
  refuses_on_angle<CoordinateStop>({"'bad'", "limit"}, {.stiffness = 1});
  refuses_on_angle<CoordinateStop>({"'bad'", "limit"}, {.upper = kNaN, .stiffness = 1});
  refuses_on_angle<CoordinateStop>({"'bad'", "stiffness"}, {.upper = 1});
  refuses_on_angle<CoordinateStop>({"'bad'", "exponent"}, {.upper = 1, .stiffness = 1, .exponent = 0.5});
  refuses_on_angle<CoordinateStop>({"'bad'", "exponent"}, {.upper = 1, .stiffness = 1, .exponent = kInfinity});
  refuses_on_angle<CoordinateStop>({"'bad'", "dissipation"}, {.upper = 1, .stiffness = 1, .dissipation = -1});
}

TEST(ElementErrors, FrictionNeedsAJointOfTheSceneAndAnArm) {
  Bench bench;
  refuses_on_angle<JointFriction>({"'bad'", "joint"}, {.coefficient = 0.1, .radius = 0.1});
  const auto rub = [&](JointFriction::Parameters p) { bench.graph.add<JointFriction>("bad", {bench.angle()}, p); };
  expect_error([&] { rub({.joint = bench.pin, .coefficient = 0.1}); }, {"'bad'", "radius"});
  expect_error([&] { rub({.joint = bench.pin, .coefficient = -0.1, .radius = 1}); }, {"'bad'", "coefficient"});
  expect_error([&] { rub({.joint = bench.pin, .static_coefficient = kNaN, .radius = 1}); },
               {"'bad'", "static_coefficient"});
  expect_error([&] { rub({.joint = bench.pin, .creep_speed = 0, .radius = 1}); }, {"'bad'", "creep_speed"});
  expect_error([&] { rub({.joint = bench.pin, .stribeck_speed = -1, .radius = 1}); }, {"'bad'", "stribeck_speed"});
  Bench other;
  rub({.joint = other.pin, .coefficient = 0.1, .radius = 1});
  expect_error([&] { assemble(bench.graph); }, {"'bad'", "joint"});
}

TEST(ElementErrors, ControllersNeedTargetAndMemory) {
  Bench bench;
  auto& memory = bench.graph.add<IntegralState>("memory");
  const auto servo = [&](std::vector<JointCoordinate> on, PidController::Parameters p) {
    bench.graph.add<PidController>("bad", std::move(on), std::move(p));
  };
  const std::vector<JointCoordinate> both = {bench.angle(), memory.coordinate()};
  expect_error([&] { servo({bench.angle()}, {.target = constant(1)}); }, {"'bad'", "two coordinates"});
  expect_error([&] { servo(both, {}); }, {"'bad'", "target"});
  expect_error([&] { servo(both, {.target = constant(1), .proportional = -1}); }, {"'bad'", "proportional"});
  expect_error([&] { servo(both, {.target = constant(1), .integral = kNaN}); }, {"'bad'", "integral"});
  expect_error([&] { servo(both, {.target = constant(1), .limit = 0}); }, {"'bad'", "limit"});
  expect_error([&] { bench.graph.add<IntegralState>("bad", {.start = kNaN}); }, {"'bad'", "start"});
}

TEST(ElementErrors, BushingsHaveSymmetricMatricesThatGiveNoEnergy) {
  Matrix6 lopsided = Matrix6::Identity(), negative = Matrix6::Identity(), broken = Matrix6::Identity();
  lopsided(0, 1) = 0.5, negative(2, 2) = -1, broken(3, 3) = kNaN;
  refuses<Bushing>({"'bad'", "stiffness", "symmetric"}, Bushing::Parameters{.stiffness = lopsided});
  refuses<Bushing>({"'bad'", "damping", "eigenvalue"}, Bushing::Parameters{.damping = negative});
  refuses<Bushing>({"'bad'", "stiffness"}, Bushing::Parameters{.stiffness = broken});
}

TEST(ElementErrors, LoadsHaveAForceForEachMarker) {
  const std::vector<Vector3> two(2, Vector3(1, 0, 0)), nine(9, Vector3(1, 0, 0)), broken(2, Vector3(kNaN, 0, 0));
  refuses<DistributedLoad>({"'bad'", "0 forces"}, DistributedLoad::Parameters{});
  refuses<DistributedLoad>({"'bad'", "9 forces"}, DistributedLoad::Parameters{.forces = nine});
  refuses<DistributedLoad>({"'bad'", "forces"}, DistributedLoad::Parameters{.forces = broken});
  Bench bench;
  expect_error([&] { bench.graph.add<DistributedLoad>("bad", {bench.body->marker()}, {.forces = two}); }, {"'bad'"});
}

TEST(ElementErrors, CoordinatesBelongToTheScene) {
  Bench bench, other;
  expect_error([&] { bench.graph.add<CoordinateSpring>("bad", {other.angle()}, {.stiffness = 1}); }, {"'bad'"});
}

TEST(ElementErrors, CoordinatesHaveAnAxis) {
  Bench bench;
  JointCoordinate broken = bench.angle();
  broken.axis = 3;
  expect_error([&] { bench.graph.add<CoordinateSpring>("bad", {broken}, {.stiffness = 1}); }, {"'bad'", "axis 3"});
}

}  // namespace
}  // namespace lithe::test::element_errors_test
