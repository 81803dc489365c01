#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <random>

#include "engine/assembly/system.h"
#include "engine/observe/snapshot.h"
#include "joints/cylindrical_joint.h"
#include "joints/fixed_joint.h"
#include "joints/forces/coordinate_motor.h"
#include "joints/forces/coordinate_spring.h"
#include "joints/forces/spring_damper.h"
#include "joints/planar_joint.h"
#include "joints/prismatic_joint.h"
#include "joints/revolute_joint.h"
#include "joints/spherical_joint.h"
#include "joints/universal_joint.h"
#include "models/compiled/compiled_scene.h"
#include "models/compiled/runtime_internal.h"
#include "models/compiled/tape_internal.h"
#include "models/compiled/tree_equations_internal.h"
#include "models/draw_model.h"
#include "models/read_model.h"
#include "tests/reference/mechanism.h"
#include "tests/support/json_file.h"

// Joint coordinates' equations of motion against the engine's, whose state is that of the bodies.
namespace lithe::test::compiled_test {
namespace {

using Json = nlohmann::json;

/// Accelerations of all coordinates of a system at its start by the engine, named as compiled scenes name them:
/// relative motions of markers, differentiated here. A ball turns about axes of its second marker.
std::map<std::string, double> engine_accelerations(const System& system) {
  Snapshot now(system);
  now.evaluate(system.initial_state(), Accelerations::solved);
  std::map<std::string, double> all;
  for (const auto& entry : system.graph().constraints()) {
    const JointFreedom freedom = *entry.constraint->freedom();
    const MarkerKinematics A = now.marker(entry.markers[0]), B = now.marker(entry.markers[1]);
    const Vector6 a_A = now.acceleration(entry.markers[0]), a_B = now.acceleration(entry.markers[1]);
    const Vector3 d = B.p - A.p, slide = B.v - A.v - A.w.cross(d), alpha = a_B.tail<3>() - a_A.tail<3>();
    const Vector3 gain = a_B.head<3>() - a_A.head<3>() - Vector3(a_A.tail<3>()).cross(d) - A.w.cross(A.w.cross(d)) -
                         2 * A.w.cross(slide);
    const bool turns = freedom.rotation == JointFreedom::Rotation::about_z;
    const bool several = freedom.x + freedom.y + freedom.z + turns > 1;
    const std::string& name = entry.constraint->name();
    if (freedom.x) all[name + ".x"] = A.R.col(0).dot(gain);
    if (freedom.y) all[name + ".y"] = A.R.col(1).dot(gain);
    if (freedom.z) all[name + (several ? ".z" : "")] = A.R.col(2).dot(gain);
    if (turns) all[name + (several ? ".angle" : "")] = A.R.col(2).dot(alpha);
    if (freedom.rotation != JointFreedom::Rotation::any) continue;
    const Vector3 turning = B.R.transpose() * (alpha - B.w.cross(B.w - A.w));
    all[name + ".omega_x"] = turning[0], all[name + ".omega_y"] = turning[1], all[name + ".omega_z"] = turning[2];
  }
  for (const auto& slice : system.layout().bodies()) {
    const char* parts[] = {".v_x", ".v_y", ".v_z", ".omega_x", ".omega_y", ".omega_z"};
    for (int k = 0; k < 6; ++k) all[slice.body->name() + parts[k]] = now.accelerations()[slice.v + k];
  }
  return all;
}

/// Largest difference of the tree's accelerations at the start, relative to the largest of them.
double difference(const System& system, double right_angles_within = 0) {
  const CompiledTree tree = CompiledTree::of(system, right_angles_within);
  std::vector<double> q(tree.q.begin(), tree.q.end()), v(tree.v.begin(), tree.v.end()), u(v.size(), 0);
  for (const Input* input : tree.inputs) u.push_back(input->value(0));
  const std::vector<double> found = CompiledEquations<double>(tree).accelerations(q, v, u);
  const auto expected = engine_accelerations(system);
  double error = 0, largest = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    error = std::max(error, std::abs(found[i] - expected.at(tree.velocity_names[i])));
    largest = std::max(largest, std::abs(found[i]));
  }
  EXPECT_GT(largest, 0.01);
  return error / largest;
}

class Random {
 public:
  explicit Random(unsigned seed) : generator_(seed) {}
  double number(double from, double to) { return std::uniform_real_distribution<>(from, to)(generator_); }
  int below(int n) { return std::uniform_int_distribution<>(0, n - 1)(generator_); }
  Vector3 vector(double size) { return {number(-size, size), number(-size, size), number(-size, size)}; }
  Matrix3 rotation() { return rotation_exp(vector(2)); }

 private:
  std::mt19937 generator_;
};

/// Bodies that hang on ground, on others before them, or on nothing, by joints of all kinds, a third of them drawn from
/// the outer body to the inner one.
void draw_random_tree(SystemGraph& graph, int bodies, unsigned seed) {
  Random random(seed);
  std::vector<Part> parts;
  for (int i = 0; i < bodies; ++i) {
    const std::string name = "body" + std::to_string(i);
    const double a = random.number(0.1, 0.5), b = random.number(0.1, 0.5), c = random.number(0.1, 0.5);
    parts.emplace_back(graph, name, random.number(0.5, 2), Vector3(b + c, a + c, a + b), random.vector(1),
                       random.rotation(), random.vector(1), random.vector(1));
    const int kind = random.below(8), on = random.below(i + 1) - 1;
    const bool back = random.below(3) == 0;
    const Vector3 at = random.vector(1);
    const Matrix3 axes = random.below(2) ? random.rotation() : Matrix3::Identity();
    const Marker inner = on < 0 ? graph.ground().marker(at, axes) : parts[on].at(at, axes),
                 outer = parts[i].at(at, axes);
    const std::vector<Marker> markers = back ? std::vector{outer, inner} : std::vector{inner, outer};
    const std::string joint = "joint" + std::to_string(i);
    if (kind < 2) graph.add<RevoluteJoint>(joint, markers);
    if (kind == 2) graph.add<PrismaticJoint>(joint, markers);
    if (kind == 3) graph.add<CylindricalJoint>(joint, markers);
    if (kind == 4) graph.add<PlanarJoint>(joint, markers);
    if (kind == 5) graph.add<SphericalJoint>(joint, {inner, outer});
    if (kind == 6) graph.add<FixedJoint>(joint, markers);
  }
}

TEST(CompiledScene, RandomTreesOfAllJointsAccelerateAsInTheEngine) {
  for (unsigned seed = 1; seed <= 40; ++seed) {
    SystemGraph graph{{.gravity = {1.5, -3, -9.81}}};
    draw_random_tree(graph, 1 + static_cast<int>(seed % 9), seed);
    EXPECT_LT(difference(assemble(graph)), 1e-12) << "seed " << seed;
  }
}

/// The robots of the reference in its states.
TEST(CompiledScene, RobotsAccelerateAsInTheEngine) {
  for (const char* file : {"iiwa", "hyq", "anymal_c", "hyq.floating", "anymal_c.floating"}) {
    const Json reference = read_json(std::string(LITHE_TEST_DATA) + "/robots/" + file + ".json");
    const ModelDescription model =
        read_model(std::string(LITHE_TEST_DATA) + "/robots/" + reference["file"].get<std::string>());
    for (const Json& state : reference["states"]) {
      DrawnModel::Options options{.floating = reference["base"] == "floating"};
      for (std::size_t j = 0; j < reference["joints"].size(); ++j) {
        options.positions[reference["joints"][j]] = state["q"][j];
        options.velocities[reference["joints"][j]] = state["v"][j];
      }
      if (options.floating) options.angular_velocity = {0.3, -0.4, 0.5}, options.velocity = {0.1, 0.2, -0.3};
      SystemGraph graph{{.gravity = model.gravity}};
      draw_model(graph, model, options);
      EXPECT_LT(difference(assemble(graph)), 1e-12) << file;
    }
  }
}

/// The file gives right angles to eleven digits: taken as such, they cost less and change accelerations by no more.
TEST(CompiledScene, RightAnglesOfAFileMayBeTakenAsSuch) {
  const ModelDescription model = read_model(std::string(LITHE_TEST_DATA) + "/robots/iiwa.urdf");
  DrawnModel::Options options;
  for (const ModelJoint& joint : model.joints)
    options.positions[joint.name] = 0.3, options.velocities[joint.name] = 0.5;
  SystemGraph graph;
  draw_model(graph, model, options);
  const System system = assemble(graph);
  const double error = difference(system, 1e-10);
  EXPECT_LT(error, 1e-9);
  EXPECT_GT(error, 1e-13);
  const CompiledScene exact = CompiledScene::of(system, "exact"),
                      rounded = CompiledScene::of(system, "rounded", {.right_angles_within = 1e-10});
  EXPECT_LT(rounded.products, 0.85 * exact.products);
  EXPECT_LT(rounded.sums, 0.85 * exact.sums);
  EXPECT_THROW(CompiledScene::of(system, "coarse", {.right_angles_within = 0.1}), SceneError);
}

/// Springs and motors on coordinates drawn either way, their numbers Inputs or not: as in the engine.
TEST(CompiledScene, SpringsAndMotorsActAsInTheEngine) {
  SystemGraph graph;
  const auto& torque = graph.add<Input>("torque", {.value = 3});
  const auto& stiffness = graph.add<Input>("stiffness", {.value = 20});
  const Part a(graph, "a", 1, {0.2, 0.3, 0.4}, {0.5, 0, 0}, Matrix3::Identity(), {0, 0, 0}, {0, 0, 0.7}),
      b(graph, "b", 2, {0.3, 0.2, 0.4}, {1, 0.5, 0}, Matrix3::Identity(), {0.1, 0.2, 0.3}, {0.2, 0.1, 0.7});
  const Matrix3 skewed = axes_with_z({0.2, 0.1, 1}), other = axes_with_z({0.3, 1, 0.2});
  auto& pin = graph.add<RevoluteJoint>("pin", {a.at({0, 0, 0}, skewed), graph.ground().marker({0, 0, 0}, skewed)});
  auto& sleeve = graph.add<CylindricalJoint>("sleeve", {a.at({1, 0, 0}, other), b.at({1, 0, 0}, other)});
  graph.add<CoordinateMotor>("motor", {-pin.angle()}, {.effort = torque});
  graph.add<CoordinateSpring>("clock", {pin.angle()}, {.stiffness = stiffness, .damping = 0.3, .free_value = 0.4});
  graph.add<CoordinateSpring>("coil", {sleeve.displacement()}, {.stiffness = 50, .free_value = -0.1, .preload = 2});
  graph.add<CoordinateSpring>("twist", {-sleeve.angle()}, {.stiffness = 7, .damping = 0.2, .free_value = 0.5});
  // Between other markers of the same bodies, from the outer to the inner one.
  const Matrix3 across = other * rotation_exp({0, 0, 0.8});
  graph.add<CoordinateSpring>("more", {angle_between(b.at({2, 1, 0}, across), a.at({0, 1, 3}, across))},
                              {.stiffness = 3, .free_value = 0.7});
  EXPECT_LT(difference(assemble(graph)), 1e-12);
}

TEST(CompiledScene, RefusesByNameWhatItCannotHold) {
  const auto refusal = [](const std::function<void(SystemGraph&, const Part&)>& draw) -> std::string {
    SystemGraph graph;
    const Part body(graph, "body", 1, {1, 1, 1}, {1, 0, 0});
    draw(graph, body);
    const System system = assemble(graph);
    try {
      CompiledScene::of(system, "scene");
    } catch (const SceneError& error) {
      return error.what();
    }
    return "";
  };
  const auto pin = [](SystemGraph& graph, const Part& body) -> RevoluteJoint& {
    return graph.add<RevoluteJoint>("pin", {graph.ground().marker(), body.at({0, 0, 0})});
  };
  EXPECT_EQ(refusal([&](SystemGraph& graph, const Part& body) { pin(graph, body); }), "");
  const auto expect = [&](const std::string& words, const std::function<void(SystemGraph&, const Part&)>& draw) {
    const std::string said = refusal(draw);
    EXPECT_NE(said.find(words), std::string::npos) << words << "\n" << said;
  };
  expect("'cross' cannot be compiled: it is no lower pair", [](SystemGraph& graph, const Part& body) {
    graph.add<UniversalJoint>("cross", {graph.ground().marker({1, 0, 0}, axes_with_z({1, 0, 0})),
                                        body.at({1, 0, 0}, axes_with_z({0, 1, 0}))});
  });
  expect("'again' cannot be compiled: it closes a loop", [&](SystemGraph& graph, const Part& body) {
    pin(graph, body);
    graph.add<SphericalJoint>("again", {graph.ground().marker({0, 0, 1}), body.at({0, 0, 1})});
  });
  expect("'strut' cannot be compiled: of forces", [&](SystemGraph& graph, const Part& body) {
    graph.add<SpringDamper>("strut", {graph.ground().marker({3, 0, 0}), body.at({1, 0, 0})}, {.stiffness = 1});
  });
  expect("'law' cannot be compiled: its effort is a function", [&](SystemGraph& graph, const Part& body) {
    graph.add<CoordinateMotor>("law", {pin(graph, body).angle()}, {[](double, double, double) { return 1.0; }});
  });
  expect("'stuff' cannot be compiled: its law is a function", [&](SystemGraph& graph, const Part& body) {
    graph.add<CoordinateSpring>("stuff", {pin(graph, body).angle()}, {.law = [](double x, double) {
                                  return Tension{x, 1, 0, 0};
                                }});
  });
  expect("'far' cannot be compiled: its coordinate is not that of one joint",
         [&](SystemGraph& graph, const Part& body) {
           pin(graph, body);
           graph.add<CoordinateSpring>("far", {angle_between(graph.ground().marker(), body.at({0, 0, 0}), 1)},
                                       {.stiffness = 1});
         });
}

/// Against the library's in extended precision: of a sine near a multiple of π, in units of its own last place.
TEST(CompiledScene, SineAndCosineAreWithinAUnitOfTheLastPlace) {
  Random random(3);
  const auto units = [](double found, long double exact) {
    const double rounded = static_cast<double>(exact);
    const double unit = std::nextafter(std::abs(rounded), 1e300) - std::abs(rounded);
    return static_cast<double>(std::abs(found - exact)) / unit;
  };
  double worst = 0;
  for (int i = 0; i < 400000; ++i) {
    double x = random.number(-1, 1) * std::pow(10, random.number(-6, 6));
    if (i % 4 == 0) x = std::round(x) * M_PI_2;  // where one of them is nearly zero
    double s, c;
    lithe_compiled::sine_cosine(x, s, c);
    worst = std::max(
        {worst, units(s, std::sin(static_cast<long double>(x))), units(c, std::cos(static_cast<long double>(x)))});
  }
  EXPECT_LT(worst, 1);
  EXPECT_GT(worst, 0.5) << "too good to be true";
  for (const double lost : {NAN, INFINITY}) {
    double s, c;
    lithe_compiled::sine_cosine(lost, s, c);
    EXPECT_TRUE(std::isnan(s) && std::isnan(c));
  }
}

}  // namespace
}  // namespace lithe::test::compiled_test
