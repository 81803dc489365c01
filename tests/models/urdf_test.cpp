#include <cmath>
#include <nlohmann/json.hpp>

#include "engine/assembly/system.h"
#include "engine/base/rotations.h"
#include "engine/observe/sensors.h"
#include "engine/observe/snapshot.h"
#include "joints/forces/coordinate_motor.h"
#include "joints/forces/point_force.h"
#include "models/draw_model.h"
#include "models/read_model.h"
#include "tests/models/refusal.h"
#include "tests/support/json_file.h"

namespace lithe {
namespace {

using Json = nlohmann::json;

std::string data(const std::string& file) { return std::string(LITHE_TEST_DATA) + "/robots/" + file; }

VectorX vector(const Json& list) {
  VectorX v(static_cast<Eigen::Index>(list.size()));
  for (Eigen::Index i = 0; i < v.size(); ++i) v[i] = list[static_cast<std::size_t>(i)].get<double>();
  return v;
}

Matrix3 matrix3(const Json& rows) {
  Matrix3 R;
  for (int i = 0; i < 3; ++i) R.row(i) = vector(rows[static_cast<std::size_t>(i)]).transpose();
  return R;
}

/// The robot in one state of the reference, with its joint torques, and what a test asks of it.
struct Robot {
  SystemGraph graph;
  DrawnModel drawn;

  Robot(const ModelDescription& model, const Json& reference, const Json& state, bool damping)
      : drawn(draw_model(graph, model, options(reference, state, damping))) {
    const auto& joints = reference["joints"];
    for (std::size_t j = 0; j < joints.size(); ++j) {
      const double effort = state["tau"][j];
      graph.add<CoordinateMotor>("motor_" + joints[j].get<std::string>(), {drawn.coordinate(joints[j])},
                                 {[effort](double, double, double) { return effort; }});
    }
    if (!state.contains("base_force")) return;
    const std::string root = reference["root"];
    graph.add<PointForce>("push", {drawn.marker(root)}, {.force = vector(state["base_force"])});
    graph.add<PointForce>("turn", {drawn.marker(root)},
                          {.torque = vector(state["base_moment"]), .axes = PointForce::Axes::marker});
  }

  static DrawnModel::Options options(const Json& reference, const Json& state, bool damping) {
    DrawnModel::Options o{.damping = damping};
    const auto& joints = reference["joints"];
    for (std::size_t j = 0; j < joints.size(); ++j) {
      o.positions[joints[j]] = state["q"][j];
      o.velocities[joints[j]] = state["v"][j];
    }
    if (!state.contains("base_position")) return o;
    o.floating = true;
    const VectorX e = vector(state["base_quaternion"]);
    o.root = {vector(state["base_position"]), Eigen::Quaterniond(e[0], e[1], e[2], e[3]).toRotationMatrix()};
    o.velocity = vector(state["base_velocity"]);
    o.angular_velocity = vector(state["base_angular_velocity"]);
    return o;
  }

  /// In the order and the axes of the reference: of a free root p̈ in world, ω̇ in root axes, then the joints.
  VectorX accelerations(Snapshot& now, const Json& reference) {
    const auto& joints = reference["joints"];
    const bool floating = reference["base"] == "floating";
    VectorX result(static_cast<Eigen::Index>(joints.size()) + (floating ? 6 : 0));
    if (floating) {
      const Marker root = drawn.marker(reference["root"]);
      result.head<3>() = now.acceleration(root).head<3>();
      result.segment<3>(3) = now.marker(root).R.transpose() * now.acceleration(root).tail<3>();
    }
    for (std::size_t j = 0; j < joints.size(); ++j)
      result[static_cast<Eigen::Index>(j) + (floating ? 6 : 0)] =
          coordinate_acceleration(drawn.coordinate(joints[j]), "a").value(now);
    return result;
  }
};

class Urdf : public testing::TestWithParam<const char*> {};

/// Reference: two formulations of their own, points at 60 digits and Newton-Euler, which agree to 1e-15
/// (tests/data/robots; MuJoCo is a third).
TEST_P(Urdf, MovesAsTwoIndependentMethodsSay) {
  const Json reference = test::read_json(data(std::string(GetParam()) + ".json"));
  const ModelDescription model = read_model(data(reference["file"]));
  double mass = 0;
  for (const ModelLink& link : model.links) mass += link.mass;
  EXPECT_NEAR(mass, reference["total_mass"].get<double>(), 1e-12 * mass);
  const double condition = reference["largest_condition_of_mass_matrix"];
  for (const Json& state : reference["states"]) {
    Robot robot(model, reference, state, false);
    const System system = assemble(robot.graph);
    EXPECT_EQ(system.degrees_of_freedom(), reference["velocity_count"].get<int>());
    const State start = system.initial_state();
    Snapshot now(system, start);

    const VectorX expected = vector(state["acceleration"]), found = robot.accelerations(now, reference);
    EXPECT_LE((found - expected).lpNorm<Eigen::Infinity>(),
              std::min(1e-9, 1e-13 * condition) * expected.lpNorm<Eigen::Infinity>());
    // M v̇ + f = τ, with M and f of the reference.
    const Eigen::Index n = expected.size();
    MatrixX M(n, n);
    for (Eigen::Index i = 0; i < n; ++i) M.row(i) = vector(state["mass_matrix"][static_cast<std::size_t>(i)]);
    VectorX effort(n);
    if (n > vector(state["tau"]).size())
      effort << vector(state["base_force"]), vector(state["base_moment"]), vector(state["tau"]);
    else
      effort = vector(state["tau"]);
    const VectorX f = vector(state["inverse_dynamics_at_zero_acceleration"]);
    EXPECT_LE((M * found + f - effort).lpNorm<Eigen::Infinity>(),
              1e-11 * ((M * found).lpNorm<Eigen::Infinity>() + f.lpNorm<Eigen::Infinity>()));

    const double kinetic = state["kinetic_energy"];
    EXPECT_NEAR(kinetic_energy().value(now), kinetic, 1e-12 * kinetic);
    if (robot.drawn.body(reference["root"])) {  // else the root's part lies in ground, which is not weighed
      const double potential = state["potential_energy"];
      double gravity = 0;  // of bodies: the push has a potential too
      for (const auto& entry : robot.graph.bodies()) gravity += potential_energy(*entry.body).value(now);
      EXPECT_NEAR(gravity, potential, 1e-12 * mass * 9.81);
    }
    const auto& tips = reference["tips"];
    for (std::size_t t = 0; t < tips.size(); ++t)
      EXPECT_LE((now.marker(robot.drawn.marker(tips[t])).p - vector(state["tip_positions"][t])).norm(), 1e-12);
    const Matrix3 R = now.marker(robot.drawn.marker(state["last_link"])).R;
    EXPECT_LE((R - matrix3(state["last_link_rotation"])).norm(), 1e-12);

    if (!state.contains("acceleration_with_damping")) continue;
    Robot damped(model, reference, state, true);
    const System system_damped = assemble(damped.graph);
    const State start_damped = system_damped.initial_state();
    Snapshot then(system_damped, start_damped);
    const VectorX slowed = vector(state["acceleration_with_damping"]);
    EXPECT_LE((damped.accelerations(then, reference) - slowed).lpNorm<Eigen::Infinity>(),
              std::min(1e-9, 1e-13 * condition) * slowed.lpNorm<Eigen::Infinity>());
  }
}

INSTANTIATE_TEST_SUITE_P(Robots, Urdf,
                         testing::Values("iiwa", "hyq", "panda", "anymal_c", "hyq.floating", "anymal_c.floating"),
                         [](const auto& robot) {
                           std::string name = robot.param;
                           std::replace(name.begin(), name.end(), '.', '_');
                           return name;
                         });

TEST(UrdfNotes, SayWhatDoesNotActAndWhere) {
  const ModelDescription panda = read_model(data("panda.urdf"));
  const std::string sheet = panda.sheet();
  for (const char* words : {"7 revolute, 2 prismatic", "limits do not act", "<visual> of a mesh", "<collision>",
                            "<safety_controller>", "1 joint follows another"})
    EXPECT_NE(sheet.find(words), std::string::npos) << words << "\n" << sheet;
  EXPECT_EQ(read_model(data("anymal_c.urdf")).joints.size(), 77u);
}

TEST(UrdfErrors, NameTheLineAndTheFix) {
  const std::string arm =
      "<robot name='r'>\n<link name='base'/>\n"
      "<link name='arm'><inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1'/></inertial></link>\n";
  const std::string hinge = "<joint name='j' type='revolute'><parent link='base'/><child link='arm'/></joint>\n";
  const auto says = [](const std::string& text, const std::string& what) {
    const std::string told = test::refusal("robot.urdf", text);
    EXPECT_NE(told.find(what), std::string::npos) << "wanted: " << what << "\n" << told;
  };
  EXPECT_EQ(test::refusal("robot.urdf", arm + hinge + "</robot>"), "");
  says("<robot name='r'>\n<link name='base'>\n</robot>", "robot.urdf:3");
  says("<banana version='1.7'/>", "of no known format");
  says("<robot name='r'/>", "has no link");
  says(arm + hinge + hinge + "</robot>", "there are two joints 'j'");
  says(arm + "<link name='arm'/></robot>", "robot.urdf:4");
  says(arm + "<joint name='j' type='ball'><parent link='base'/><child link='arm'/></joint></robot>",
       "unknown type 'ball'");
  says(arm + "<joint name='j' type='fixed'><parent link='bas'/><child link='arm'/></joint></robot>", "no link 'bas'");
  says(arm + "<joint name='j' type='fixed'><child link='arm'/></joint></robot>", "no <parent>");
  says(arm + "</robot>", "2 links have no parent");
  says(arm + hinge + "<joint name='k' type='fixed'><parent link='base'/><child link='arm'/></joint></robot>",
       "child of two joints");
  says(
      "<robot name='r'><link name='a'/><link name='b'/><link name='c'/>"
      "<joint name='j' type='fixed'><parent link='b'/><child link='c'/></joint>"
      "<joint name='k' type='fixed'><parent link='c'/><child link='b'/></joint></robot>",
      "cycle of joints");
  says(
      arm +
          "<joint name='j' type='revolute'><axis xyz='0 0 0'/><parent link='base'/><child link='arm'/></joint></robot>",
      "has no direction");
  says(
      arm +
          "<joint name='j' type='revolute'><axis xyz='0 0 x'/><parent link='base'/><child link='arm'/></joint></robot>",
      "is not 3 numbers");
  says(arm +
           "<joint name='j' type='revolute'><axis xyz='0 0 1 0'/><parent link='base'/><child "
           "link='arm'/></joint></robot>",
       "has more than 3 numbers");
  says(arm +
           "<joint name='j' type='revolute'><origin xyz='0 nan 1'/><parent link='base'/><child "
           "link='arm'/></joint></robot>",
       "is not 3 numbers");
  says("<robot name='r'><link name='a'><inertial><mass value='-1'/></inertial></link></robot>", "is negative");
  says(
      "<robot name='r'><link name='a'/><link name='b'/>"
      "<joint name='j' type='revolute'><parent link='a'/><child link='b'/></joint></robot>",
      "moves and has no mass");
  says(arm + hinge.substr(0, hinge.size() - 9) + "<mimic joint='j'/></joint></robot>", "cannot follow");
  EXPECT_NE(
      test::refusal(
          "robot.urdf",
          "<robot name='r'><link name='a'><visual><geometry><sphere radius='-1'/></geometry></visual></link></robot>"),
      "");
}

TEST(DrawnModel, RefusesValuesOfJointsThatTakeNone) {
  const ModelDescription panda = read_model(data("panda.urdf"));
  SystemGraph graph;
  EXPECT_THROW(draw_model(graph, panda, {.positions = {{"elbow", 0.1}}}), SceneError);
  EXPECT_THROW(draw_model(graph, panda, {.positions = {{"panda_finger_joint2", 0.1}}}), SceneError);
  EXPECT_THROW(draw_model(graph, panda, {.velocities = {{"panda_joint1", NAN}}}), SceneError);
  const DrawnModel left = draw_model(graph, panda, {.prefix = "left_"});
  EXPECT_THROW(left.coordinate("panda_joint8"), SceneError);
  EXPECT_THROW(left.joint("panda_joint8"), SceneError);
  EXPECT_EQ(left.body("panda_link0"), nullptr);
  const DrawnModel right = draw_model(graph, panda, {.root = {{0, 1, 0}}, .prefix = "right_"});
  EXPECT_NE(right.body("panda_link1"), left.body("panda_link1"));
  EXPECT_EQ(assemble(graph).degrees_of_freedom(), 16);
}

}  // namespace
}  // namespace lithe
