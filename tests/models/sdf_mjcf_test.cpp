// SDF and MJCF: robots against reference values of two independent methods (tests/data/robots), loops, conventions,
// bad input.
#include <cmath>
#include <nlohmann/json.hpp>

#include "engine/base/rotations.h"
#include "engine/observe/sensors.h"
#include "engine/run/simulation.h"
#include "joints/forces/coordinate_motor.h"
#include "models/draw_model.h"
#include "models/read_model.h"
#include "tests/models/refusal.h"
#include "tests/support/json_file.h"
#include "tests/support/methods.h"

namespace lithe::test::sdf_mjcf_test {
namespace {

using Json = nlohmann::json;

std::string data(const std::string& file) { return std::string(LITHE_TEST_DATA) + "/robots/" + file; }

void add_motor(SystemGraph& graph, const DrawnModel& drawn, const std::string& joint, double effort) {
  graph.add<CoordinateMotor>("motor_" + joint, {drawn.coordinate(joint)},
                             {[effort](double, double, double) { return effort; }});
}

std::map<std::string, double> values(const Json& of) {
  std::map<std::string, double> all;
  for (const auto& [name, value] : of.items()) all[name] = value;
  return all;
}

TEST(Mjcf, ThePandaMovesAsTwoIndependentMethodsSay) {
  const Json reference = read_json(data("panda.mjcf.json"));
  ModelDescription model = read_model(data("panda.mjcf.xml"));
  const std::string sheet = model.sheet();
  for (const char* words : {"Model 'panda' (MJCF)", "7 revolute, 2 prismatic, 2 fixed", "1 joint follows another",
                            "<actuator>", "<tendon>", "<geom> of a mesh", "range of <joint>", "<keyframe>"})
    EXPECT_NE(sheet.find(words), std::string::npos) << words << "\n" << sheet;
  for (ModelJoint& joint : model.joints) joint.mimic.reset();  // the reference leaves both fingers free
  const std::vector<std::string> order = reference["order_of_velocities"];
  const Eigen::Index n = static_cast<Eigen::Index>(order.size());
  double largest = 0;
  for (const Json& state : reference["states"]) {
    SystemGraph graph;
    const DrawnModel drawn =
        draw_model(graph, model, {.positions = values(state["q"]), .velocities = values(state["v"]), .damping = false});
    for (const std::string& joint : order) add_motor(graph, drawn, joint, state["tau"][joint]);
    const System system = assemble(graph);
    EXPECT_EQ(system.degrees_of_freedom(), 9);
    const State start = system.initial_state();
    Snapshot now(system, start);
    VectorX found(n), expected(n), effort(n), bias(n);
    MatrixX M(n, n);
    for (Eigen::Index j = 0; j < n; ++j) {
      const std::string& name = order[static_cast<std::size_t>(j)];
      found[j] = coordinate_acceleration(drawn.coordinate(name), "a").value(now);
      expected[j] = state["tree_acceleration"][name];
      effort[j] = state["tau"][name];
      bias[j] = state["inverse_dynamics_at_zero_acceleration"][name];
      for (Eigen::Index k = 0; k < n; ++k)
        M(j, k) = state["mass_matrix_with_armature"][static_cast<std::size_t>(j)][static_cast<std::size_t>(k)];
    }
    const double error = (found - expected).lpNorm<Eigen::Infinity>() / expected.lpNorm<Eigen::Infinity>();
    largest = std::max(largest, error);
    EXPECT_LE((M * found + bias - effort).lpNorm<Eigen::Infinity>(), 1e-11 * effort.lpNorm<Eigen::Infinity>());
    const double kinetic = state["kinetic_energy"];
    EXPECT_NEAR(kinetic_energy().value(now), kinetic, 1e-12 * kinetic);
    const ModelLink& base = model.links[static_cast<std::size_t>(model.link("link0"))];  // in ground, not weighed
    double potential = base.mass * 9.81 * base.inertial.position.z();
    for (const auto& entry : graph.bodies()) potential += potential_energy(*entry.body).value(now);
    EXPECT_NEAR(potential, state["potential_energy"].get<double>(), 1e-12 * 100);
    for (std::size_t t = 0; t < 2; ++t) {
      const std::vector<double> tip = state["tip_positions"][t];
      const Vector3 p = now.marker(drawn.marker(reference["tips"][t])).p;
      EXPECT_LT((p - Vector3(tip[0], tip[1], tip[2])).norm(), 1e-12);
    }
  }
  expect_below("panda.mjcf accelerations", largest, 1e-12);
}

TEST(Mjcf, AFollowerMovesWithItsLeader) {
  const ModelDescription model = read_model(data("panda.mjcf.xml"));
  SystemGraph graph;
  const DrawnModel drawn = draw_model(graph, model, {.positions = {{"finger_joint2", 0.01}}});
  const System system = assemble(graph);
  EXPECT_EQ(system.degrees_of_freedom(), 8);
  add_motor(graph, drawn, "finger_joint2", 0.5);
  const System driven = assemble(graph);
  const Method method = runge_kutta8(1e-9);
  Simulation simulation(driven, *method);
  State state = driven.initial_state();
  simulation.run(state, 0.3);
  Snapshot now(driven, state);
  const double x = coordinate(drawn.coordinate("finger_joint1"), "x").value(now);
  EXPECT_GT(std::abs(x - 0.01), 1e-3);
  EXPECT_NEAR(x, coordinate(drawn.coordinate("finger_joint2"), "x").value(now), 1e-10);
}

TEST(Sdf, TheFourBarMovesAsTwoIndependentMethodsSay) {
  const Json reference = read_json(data("four_bar.json"));
  const ModelDescription model = read_model(data("four_bar.sdf"));
  EXPECT_NE(model.sheet().find("less what 1 closed loop takes"), std::string::npos) << model.sheet();
  double largest = 0;
  for (const Json& state : reference["states"]) {
    SystemGraph graph;
    std::map<std::string, double> q = values(state["q"]), v = values(state["v"]);
    q.erase("C"), v.erase("C");
    const DrawnModel drawn = draw_model(graph, model, {.positions = q, .velocities = v});
    add_motor(graph, drawn, "A", state["tau_A"]);
    const System system = assemble(graph);
    EXPECT_EQ(system.degrees_of_freedom(), 1);
    const State start = system.initial_state();
    Snapshot now(system, start);
    for (const char* name : {"A", "B", "C", "D"}) {
      const double expected = state["acceleration"][name];
      largest = std::max(largest, std::abs(coordinate_acceleration(drawn.coordinate(name), "a").value(now) - expected) /
                                      std::abs(state["acceleration_A"].get<double>()));
      EXPECT_NEAR(coordinate(drawn.coordinate(name), "q").value(now), state["q"][name].get<double>(), 1e-12) << name;
      EXPECT_NEAR(coordinate_rate(drawn.coordinate(name), "v").value(now), state["v"][name].get<double>(), 1e-12)
          << name;
      double load[6];
      reaction(drawn.joint(name), 1, kWorldAxes, "load").evaluate(now, load);
      const std::vector<double> force = state["force_on_child"][name];
      // Three rows repeat others out of the plane: forces within it are unique.
      EXPECT_NEAR(load[0], force[0], 1e-9 * 50) << name;
      EXPECT_NEAR(load[2], force[2], 1e-9 * 50) << name;
    }
    EXPECT_NEAR(kinetic_energy().value(now), state["kinetic_energy"].get<double>(), 1e-12);
    EXPECT_NEAR(potential_energy().value(now), state["potential_energy"].get<double>(), 1e-11);
    const std::vector<double> C = state["C"];
    EXPECT_LT((now.marker(drawn.marker("rocker", {0.6, 0, 0})).p - Vector3(C[0], C[1], C[2])).norm(), 1e-12);
  }
  expect_below("four_bar.sdf accelerations", largest, 1e-11);
}

TEST(Sdf, TheLoopHoldsOverARun) {
  const ModelDescription model = read_model(data("four_bar.sdf"));
  SystemGraph graph;
  const DrawnModel drawn = draw_model(graph, model);
  const System system = assemble(graph);
  const Method method = runge_kutta8(1e-9);
  Simulation simulation(system, *method);
  State state = system.initial_state();
  Snapshot before(system, state);
  const double energy = total_energy().value(before);
  simulation.run(state, 3);
  Snapshot now(system, state);
  EXPECT_LT(
      (now.marker(drawn.marker("rocker", {0.6, 0, 0})).p - now.marker(drawn.marker("coupler", {0.8, 0, 0})).p).norm(),
      1e-9);
  EXPECT_NEAR(total_energy().value(now), energy, 1e-6 * std::abs(energy));
}

/// The same planar four-bar as an MJCF: the loop is closed by <connect>.
TEST(Mjcf, ConnectClosesALoopAsTheJointOfAnSdfDoes) {
  const ScratchFolder folder;
  const std::string link = "<inertial mass='1.2' pos='0.14 0 0.01' diaginertia='0.002 0.011 0.011'/>";
  const std::string text =
      "<mujoco model='four_bar'><compiler angle='radian'/><worldbody>"
      "<body name='crank' euler='0 -1.0471975511965976 0'><joint name='A' axis='0 1 0'/>" +
      link +
      "<body name='coupler' pos='0.3 0 0' euler='0 0.6490521124014565 0'><joint name='B' axis='0 1 0'/>"
      "<inertial mass='2.5' pos='0.42 0 -0.03' diaginertia='0.002 0.14 0.14'/></body></body>"
      "<body name='rocker' pos='0.7 0 0' euler='0 -1.2531037053649263 0'><joint name='D' axis='0 1 0'/>"
      "<inertial mass='1.8' pos='0.27 0 0.02' diaginertia='0.002 0.06 0.06'/></body></worldbody>"
      "<equality><connect body1='coupler' body2='rocker' anchor='0.8 0 0'/></equality></mujoco>";
  const ModelDescription mjcf = read_model(folder.write("four_bar.xml", text)), sdf = read_model(data("four_bar.sdf"));
  const auto run = [](const ModelDescription& model) {
    SystemGraph graph;
    const DrawnModel drawn = draw_model(graph, model);
    const System system = assemble(graph);
    EXPECT_EQ(system.degrees_of_freedom(), 1);
    const Method method = runge_kutta8(1e-10);
    Simulation simulation(system, *method);
    State state = system.initial_state();
    simulation.run(state, 1);
    Snapshot now(system, state);
    return now.marker(drawn.marker("coupler", {0.4, 0, 0.1})).p;
  };
  EXPECT_LT((run(mjcf) - run(sdf)).norm(), 1e-8);
}

TEST(Sdf, FramesPosesAndAxesAreThoseOfTheirFrames) {
  const ScratchFolder folder;
  const std::string text =
      "<sdf version='1.9'><world name='w'><gravity>0 0 -3</gravity>"
      "<model name='m'><pose>1 2 3 0 0 1.5707963267948966</pose>"
      "<frame name='f' attached_to='arm'><pose degrees='true'>0.1 0 0 0 0 90</pose></frame>"
      "<link name='base'><inertial><mass>2</mass></inertial></link>"
      "<link name='arm'><pose relative_to='base'>0.5 0 0 0 0 0</pose></link>"
      "<link name='tip'><pose relative_to='f'>0 0.2 0 0 0 0</pose></link>"
      "<joint name='ground' type='fixed'><parent>world</parent><child>base</child></joint>"
      "<joint name='hinge' type='revolute'><parent>base</parent><child>arm</child>"
      "<axis><xyz expressed_in='__model__'>1 0 "
      "0</xyz><dynamics><damping>0.5</damping><spring_stiffness>2</spring_stiffness>"
      "<spring_reference>0.1</spring_reference></dynamics></axis></joint>"
      "<joint name='back' type='prismatic'><pose relative_to='tip'/><parent>tip</parent><child>arm</child>"
      "<axis><xyz>0 0 1</xyz></axis></joint></model></world></sdf>";
  const ModelDescription model = read_model(folder.write("m.sdf", text));
  EXPECT_EQ(model.gravity, Vector3(0, 0, -3));
  SystemGraph graph{{.gravity = model.gravity}};
  const DrawnModel drawn = draw_model(graph, model, {.positions = {{"back", 0.3}}, .velocities = {{"back", 0.7}}});
  const System system = assemble(graph);
  EXPECT_EQ(system.degrees_of_freedom(), 2);
  const State start = system.initial_state();
  Snapshot now(system, start);
  EXPECT_LT((now.marker(drawn.marker("base")).p - Vector3(1, 2, 3)).norm(), 1e-14);
  EXPECT_LT((now.marker(drawn.marker("arm")).p - Vector3(1, 2.5, 3)).norm(), 1e-14);
  // f: 0.1 along x of the arm, turned by 90 degrees; tip: 0.2 along y of f, which is -x of the arm: (-0.1, 0, 0) in it.
  // `back` moves the arm from the tip by +z: the tip, drawn from the arm, goes down.
  EXPECT_LT((now.marker(drawn.marker("tip")).p - Vector3(1, 2.4, 2.7)).norm(), 1e-14);
  EXPECT_LT((now.marker(drawn.marker("tip")).v - Vector3(0, 0, -0.7)).norm(), 1e-14);
  EXPECT_NEAR(coordinate(drawn.coordinate("back"), "x").value(now), 0.3, 1e-14);
  EXPECT_NEAR(coordinate_rate(drawn.coordinate("back"), "x").value(now), 0.7, 1e-14);
  // The spring about the model's x: of the world's y.
  EXPECT_EQ(graph.find("hinge_spring") != nullptr, true);
  EXPECT_NEAR(now.acceleration(drawn.marker("arm"))[4] < 0 ? -1 : 1, 1, 0);
}

TEST(Mjcf, MassesOfGeomsAreThoseOfTheirShapes) {
  const ScratchFolder folder;
  const auto link = [&](const std::string& geom) {
    return read_model(folder.write("m.xml", "<mujoco><worldbody><body name='b'><freejoint/>" + geom +
                                                "</body></worldbody></mujoco>"))
        .links[1];
  };
  const ModelLink sphere = link("<geom size='0.2' density='500' pos='1 0 0'/>");
  EXPECT_NEAR(sphere.mass, 500 * 4.0 / 3 * M_PI * 0.008, 1e-12);
  EXPECT_NEAR(sphere.inertia(1, 1), 0.4 * sphere.mass * 0.04, 1e-12);
  EXPECT_EQ(sphere.inertial.position, Vector3(1, 0, 0));
  const ModelLink box = link("<geom type='box' size='0.1 0.2 0.3' mass='6'/>");
  EXPECT_NEAR(box.inertia(0, 0), 6.0 / 12 * (0.16 + 0.36), 1e-12);
  const ModelLink rod = link("<geom type='cylinder' fromto='0 0 0 2 0 0' size='0.1' mass='3'/>");
  EXPECT_LT((rod.inertial.position - Vector3(1, 0, 0)).norm(), 1e-14);
  EXPECT_NEAR(rod.inertia(1, 1), 3 * (0.01 / 4 + 4.0 / 12), 1e-12);
  EXPECT_NEAR(rod.inertia(0, 0), 3 * 0.01 / 2, 1e-12);
  // A capsule of no length is a ball; of great length a rod. Between, by a sum over slices.
  const ModelLink capsule = link("<geom type='capsule' size='0.3 0.5'/>");
  double mass = 0, across = 0, along = 0;
  const int slices = 200000;
  for (int i = 0; i < slices; ++i) {
    const double z = -0.8 + 1.6 * (i + 0.5) / slices, out = std::max(std::abs(z) - 0.5, 0.0);
    const double r2 = 0.09 - out * out, m = 1000 * M_PI * r2 * 1.6 / slices;
    mass += m, along += m * r2 / 2, across += m * (r2 / 4 + z * z);
  }
  EXPECT_NEAR(capsule.mass, mass, 1e-8 * mass);
  EXPECT_NEAR(capsule.inertia(0, 0), across, 1e-8 * across);
  EXPECT_NEAR(capsule.inertia(2, 2), along, 1e-8 * along);
  const ModelLink two = link("<geom size='0.1' mass='1' pos='1 0 0'/><geom size='0.1' mass='3' pos='-1 0 0'/>");
  EXPECT_NEAR(two.mass, 4, 1e-14);
  EXPECT_NEAR(two.inertial.position.x(), -0.5, 1e-14);
  EXPECT_NEAR(two.inertia(2, 2), 4 * 0.4 * 0.01 + 1 * 2.25 + 3 * 0.25, 1e-13);
}

TEST(Mjcf, OrientationsAndSeveralJointsOfABody) {
  const ScratchFolder folder;
  const auto pose = [&](const std::string& compiler, const std::string& attribute) {
    const ModelDescription model =
        read_model(folder.write("m.xml", "<mujoco><compiler " + compiler + "/><worldbody><body " + attribute +
                                             "><freejoint/><geom size='1'/></body></worldbody></mujoco>"));
    return model.joints[0].origin.rotation;
  };
  const auto R = [](int axis, double angle) { return rotation_about(Vector3::Unit(axis), angle); };
  EXPECT_LT((pose("", "euler='90 30 0'") - R(0, M_PI / 2) * R(1, M_PI / 6)).norm(), 1e-14);
  EXPECT_LT((pose("eulerseq='XYZ' angle='radian'", "euler='0.3 0.4 0.5'") - R(2, 0.5) * R(1, 0.4) * R(0, 0.3)).norm(),
            1e-14);
  EXPECT_LT((pose("", "axisangle='0 0 2 90'") - R(2, M_PI / 2)).norm(), 1e-14);
  EXPECT_LT((pose("", "quat='2 0 2 0'") - R(1, M_PI / 2)).norm(), 1e-14);
  EXPECT_LT((pose("", "xyaxes='0 1 0 -1 0 0'") - R(2, M_PI / 2)).norm(), 1e-14);
  EXPECT_LT((pose("", "zaxis='0 -1 0'") - R(0, M_PI / 2)).norm(), 1e-14);
  const auto freedoms = [&](const std::string& joints) {
    const ModelDescription model = read_model(
        folder.write("m.xml", "<mujoco><worldbody><body>" + joints + "<geom size='1'/></body></worldbody></mujoco>"));
    SystemGraph graph;
    draw_model(graph, model);
    return assemble(graph).degrees_of_freedom();
  };
  EXPECT_EQ(freedoms("<joint/>"), 1);
  EXPECT_EQ(freedoms("<joint type='slide'/>"), 1);
  EXPECT_EQ(freedoms("<joint type='ball'/>"), 3);
  EXPECT_EQ(freedoms("<joint type='free'/>"), 6);
  EXPECT_EQ(freedoms("<joint axis='1 0 0'/><joint axis='0 1 0'/>"), 2);
  EXPECT_EQ(freedoms("<joint axis='1 0 0'/><joint axis='0 1 0'/><joint/>"), 3);
  EXPECT_EQ(freedoms("<joint type='slide' axis='1 0 0'/><joint type='slide' axis='0 1 0'/><joint/>"), 3);
}

// ---- bad input ----

TEST(SdfErrors, NameTheLineAndTheFix) {
  const std::string head = "<sdf version='1.7'>\n<model name='m'>\n<link name='a'/>\n<link name='b'/>\n",
                    tail = "</model></sdf>";
  const auto says = [&](const std::string& middle, const std::string& words, int line) {
    const std::string told = refusal("bad.sdf", head + middle + tail);
    EXPECT_NE(told.find(words), std::string::npos) << "wanted: " << words << "\n" << told;
    EXPECT_NE(told.find("bad.sdf:" + std::to_string(line)), std::string::npos) << line << "\n" << told;
  };
  const std::string ends = "<parent>a</parent><child>b</child>";
  EXPECT_EQ(refusal("bad.sdf", head + tail), "");
  says("<banana/>", "is no tag that SDF has", 5);
  says("<link name='a'/>", "two links 'a'", 5);
  says("<link name='c'><inertial><mass>-1</mass></inertial></link>", "not above zero", 5);
  says("<link name='c'><inertial><mass>1 2</mass></inertial></link>", "more than 1", 5);
  says("<link name='c'><inertial><inertia><ixx>5</ixx></inertia></inertial></link>", "no real body", 5);
  says("<link name='c'><pose>0 0 0 0 0</pose></link>", "is not 6 numbers", 5);
  says("<link name='c'><pose relative_to='x'>0 0 0 0 0 0</pose></link>", "no link, joint or frame 'x'", 5);
  says("<link name='c'><pose relative_to='d'/></link>", "no link, joint or frame 'd'", 5);
  says(
      "<link name='c'><pose relative_to='d'>0 0 0 0 0 0</pose></link><link name='d'><pose relative_to='c'>0 0 0 0 0 "
      "0</pose></link>",
      "relative to itself", 5);
  says("<joint name='j' type='screw'>" + ends + "</joint>", "unknown or not read", 5);
  says("<joint name='j' type='revolute'>" + ends + "</joint>", "has no <axis>", 5);
  says("<joint name='j' type='revolute'>" + ends + "<axis><xyz>0 0 0</xyz></axis></joint>", "has no direction", 5);
  says("<joint name='j' type='fixed'><parent>a</parent></joint>", "no <child>", 5);
  says("<joint name='j' type='fixed'><parent>a</parent><child>x</child></joint>", "no link 'x'", 5);
  says("<joint name='j' type='fixed'><parent>a</parent><child>a</child></joint>", "to itself", 5);
  says("<joint name='j' type='revolute'>" + ends +
           "<axis><xyz>0 0 1</xyz><mimic joint='k'><multiplier>1</multiplier></mimic></axis></joint>",
       "no joint 'k'", 5);
  says("<model name='n'/>", "another model", 5);
  for (std::size_t cut = 1; cut < head.size(); cut += 5)
    EXPECT_NE(refusal("bad.sdf", (head + tail).substr(0, cut)), "") << cut;
  EXPECT_NE(refusal("bad.sdf", "<sdf><model name='m'><link name='a'/></model></sdf>").find("no version"),
            std::string::npos);
}

TEST(MjcfErrors, NameTheLineAndTheFix) {
  const std::string head = "<mujoco>\n<worldbody>\n<body name='a'><freejoint/><geom size='1'/></body>\n",
                    tail = "</worldbody></mujoco>";
  const auto says = [&](const std::string& middle, const std::string& words, int line = 4) {
    const std::string told = refusal("bad.xml", head + middle + tail);
    EXPECT_NE(told.find(words), std::string::npos) << "wanted: " << words << "\n" << told;
    EXPECT_NE(told.find("bad.xml:" + std::to_string(line)), std::string::npos) << line << "\n" << told;
  };
  EXPECT_EQ(refusal("bad.xml", head + tail), "");
  says("<banana/>", "is no tag that MJCF has");
  says("<include file='../../../etc/passwd'/>", "<include> is not read");
  says("<body name='a'/>", "two bodies 'a'");
  says("<body><joint/></body>", "has no mass", 4);
  says("<body><inertial mass='-1'/></body>", "is negative");
  says("<body><inertial mass='1' diaginertia='1 1 5'/></body>", "no real body");
  says("<body><joint type='spring'/><geom size='1'/></body>", "unknown type 'spring'");
  says("<body><joint axis='0 0 0'/><geom size='1'/></body>", "has no direction");
  says("<body><joint/><joint/><geom size='1'/></body>", "not read together");
  says("<body><geom type='box' size='1'/></body>", "has 1 sizes");
  says("<body><geom size='-1'/></body>", "not above zero");
  says("<body><geom class='x' size='1'/></body>", "no default class 'x'");
  says("<body><freejoint/><geom type='mesh' mesh='x'/></body>", "is that of a mesh");
  says("<body quat='0 0 0 0'/>", "quaternion is zero");
  says("<body pos='1 2'/>", "is not 3 numbers");
  says("</worldbody><equality><connect body1='a' body2='b' anchor='0 0 0'/></equality><worldbody>", "no body 'b'");
  says("</worldbody><equality><joint joint1='a'/></equality><worldbody>", "no joint 'a'");
  says("</worldbody><compiler angle='grad'/><worldbody>", "no unit of angles");
  std::string deep = head;
  for (int i = 0; i < 600; ++i) deep += "<body>";
  EXPECT_NE(refusal("bad.xml", deep), "");
  for (int i = 0; i < 600; ++i) deep += "</body>";
  EXPECT_NE(refusal("bad.xml", deep + tail).find("deeper than 500"), std::string::npos);
  for (std::size_t cut = 1; cut < head.size(); cut += 5)
    EXPECT_NE(refusal("bad.xml", (head + tail).substr(0, cut)), "") << cut;
}

}  // namespace
}  // namespace lithe::test::sdf_mjcf_test
