#include <gtest/gtest.h>

#include "bodies/rigid_body.h"
#include "engine/model/system_graph.h"
#include "engine/observe/sensors.h"
#include "engine/observe/snapshot.h"
#include "joints/distance_joint.h"
#include "joints/revolute_joint.h"
#include "joints/spherical_joint.h"
#include "tests/joints/mechanisms.h"

namespace lithe::test::total_reaction_test {
namespace {

constexpr double kMass = 5, kWeight = 9.81 * kMass;
const Vector3 kCentre(0.3, -0.2, 0.8);  // of the table top, between its feet

/// A table on four balls, one more than it needs: how they share its weight is not unique, what they carry together is.
struct Table {
  SystemGraph graph;
  RigidBody& top = graph.add<RigidBody>("top", {.mass = kMass, .position = kCentre});
  std::vector<const Constraint*> feet;
  Table() {
    for (const Vector3& at : {Vector3(1, 1, 0), Vector3(-1, 1, 0), Vector3(-1, -1, 0), Vector3(1, -1, 0)}) {
      std::vector<Marker> markers{graph.ground().marker_at_world(at), top.marker_at_world(at)};
      if (feet.size() % 2) std::swap(markers[0], markers[1]);  // held as first marker, too
      feet.push_back(&graph.add<SphericalJoint>("foot " + std::to_string(feet.size() + 1), markers));
    }
  }
};

Vector3 part_of(const Sensor& sensor, Snapshot& now, int first) {
  return {sensor.value(now, first), sensor.value(now, first + 1), sensor.value(now, first + 2)};
}

TEST(TotalReaction, OfFourFeetIsTheWeightThroughTheCentreOfMass) {
  Table table;
  const Marker centre = table.top.marker(), corner = table.graph.ground().marker({1, 1, 0});
  const Matrix3 turned = rotation_about({1, 2, 3}, 0.7);
  const Marker axes = table.graph.ground().marker({7, 8, 9}, turned);
  const System system = assemble(table.graph);
  EXPECT_GT(system.redundant_rows().size(), 0u);
  Snapshot now{system, system.initial_state()};

  const Sensor at_centre = total_reaction(table.top, table.feet, centre);
  EXPECT_LT((part_of(at_centre, now, 0) - Vector3(0, 0, kWeight)).norm(), 1e-11);
  EXPECT_LT(part_of(at_centre, now, 3).norm(), 1e-11);
  EXPECT_EQ(at_centre.columns()[3], "top_reactions_moment_x");

  const Vector3 moment = (kCentre - Vector3(1, 1, 0)).cross(Vector3(0, 0, kWeight));
  const Sensor at_corner = total_reaction(table.top, table.feet, corner, kWorldAxes, "feet");
  EXPECT_LT((part_of(at_corner, now, 0) - Vector3(0, 0, kWeight)).norm(), 1e-11);
  EXPECT_LT((part_of(at_corner, now, 3) - moment).norm(), 1e-11);
  EXPECT_EQ(at_corner.columns()[0], "feet_force_x");
  const Sensor in_axes = total_reaction(table.top, table.feet, corner, axes);
  EXPECT_LT((part_of(in_axes, now, 0) - turned.transpose() * Vector3(0, 0, kWeight)).norm(), 1e-11);
  EXPECT_LT((part_of(in_axes, now, 3) - turned.transpose() * moment).norm(), 1e-11);

  // On ground the opposite.
  const Sensor on_ground = total_reaction(table.graph.ground(), table.feet, corner);
  EXPECT_LT((part_of(on_ground, now, 0) + Vector3(0, 0, kWeight)).norm(), 1e-11);
  EXPECT_LT((part_of(on_ground, now, 3) + moment).norm(), 1e-11);
}

/// All joints of a body that moves give it m (a - g), and about its centre of mass the rate of its spin: a rod that
/// hangs on another, both swinging.
TEST(TotalReaction, OfAllJointsOfABodyIsItsMassTimesAcceleration) {
  const double J = 0.4, m = 3;
  RigidBody *upper = nullptr, *lower = nullptr;
  const Matrix3 hinge = rotation_about({1, 0, 0}, -kPi / 2);
  Scene scene({0, 0, -9.81}, [&](SystemGraph& graph) {
    upper = &graph.add<RigidBody>("upper", {.mass = m, .inertia = {0.1, J, J}, .position = {0.5, 0, 0}});
    lower = &graph.add<RigidBody>("lower", {.mass = 2, .position = {1.5, 0, 0}});
    graph.add<RevoluteJoint>("pin", {graph.ground().marker({}, hinge), upper->marker({-0.5, 0, 0}, hinge)});
    graph.add<DistanceJoint>("string", {upper->marker({0.5, 0, 0.1}), lower->marker()});
  });
  const Marker centre = upper->marker();
  scene.run(*runge_kutta(1e-10), 0.4);
  const Sensor total =
      total_reaction(*upper, {scene.graph.find<Constraint>("pin"), scene.graph.find<Constraint>("string")}, centre);
  Snapshot now{scene.system, scene.state};
  const Vector6 a = now.acceleration(centre);
  EXPECT_GT(a.norm(), 1);
  EXPECT_LT((part_of(total, now, 0) - m * (a.head<3>() + Vector3(0, 0, 9.81))).norm(), 1e-9);
  EXPECT_LT((part_of(total, now, 3) - J * a.tail<3>()).norm(), 1e-9);
}

TEST(TotalReaction, NamesAJointThatHoldsAnotherBody) {
  Table table;
  auto& other = table.graph.add<RigidBody>("other");
  const Marker centre = table.top.marker();
  const auto problem_of = [&](const Body& body, std::vector<const Constraint*> joints, Marker about) {
    try {
      total_reaction(body, std::move(joints), about);
    } catch (const SceneError& error) {
      EXPECT_NE(error.where().find("total_reaction_test.cpp"), std::string::npos) << error.where();
      return error.problem();
    }
    return std::string("taken");
  };
  EXPECT_EQ(problem_of(other, table.feet, centre), "'foot 1' does not hold 'other'");
  EXPECT_EQ(problem_of(table.top, {nullptr}, centre), "a null joint does not hold 'top'");
  EXPECT_EQ(problem_of(table.top, {}, centre), "no joint is to be summed");
  EXPECT_NE(problem_of(table.top, table.feet, {}).find("no body"), std::string::npos);
}

}  // namespace
}  // namespace lithe::test::total_reaction_test
