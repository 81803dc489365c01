#include "bodies/beam/slender_body.h"
#include "bodies/rigid_body.h"
#include "joints/coordinate_drive.h"
#include "joints/fixed_joint.h"
#include "joints/forces/coordinate_spring.h"
#include "joints/forces/point_force.h"
#include "joints/forces/spring_damper.h"
#include "joints/prismatic_joint.h"
#include "joints/revolute_joint.h"
#include "joints/spherical_joint.h"
#include "tests/gradient/gradient_support.h"

namespace lithe::test {
namespace {

const Matrix3 kAlongY = rotation_about({1, 0, 0}, -M_PI / 2);

/// A rod on a hinge, driven off its rest by its first speed.
ParametricScene pendulum() {
  return {.name = "pendulum",
          .duration = 0.6,
          .draw =
              [](SystemGraph& graph, const SweepPoint& p) {
                const double a = p["length"];
                auto& rod = graph.add<RigidBody>("rod", {.mass = p["mass"],
                                                         .inertia = {0.03, p["inertia"], 0.09},
                                                         .position = {a, 0, 0},
                                                         .velocity = {0, 0, -a * p["speed"]},
                                                         .angular_velocity = {0, p["speed"], 0}});
                graph.add<RevoluteJoint>("pin", {graph.ground().marker({}, kAlongY), rod.marker({-a, 0, 0}, kAlongY)});
                return std::vector<Sensor>{position(rod.marker({a, 0, 0}), "tip"), velocity(rod.marker(), "v"),
                                           total_energy("energy")};
              },
          .integrator = exact_alpha(5e-3)};
}

TEST(RunGradient, OfAPendulumByItsMassInertiaLengthAndSpeed) {
  expect_gradient(pendulum(),
                  {value_at("tip_x", 0.6), value_at("tip_z", 0.3137), value_at("v_x", 0.4), integral("tip_z"),
                   integral("tip_x", 0.1, 0.4), smallest("tip_z"), largest("v_x"), value_at("energy", 0.5)},
                  {{"mass", 1.3}, {"inertia", 0.08}, {"length", 0.4}, {"speed", 0.7}});
}

/// Two rods and a slider on a table: a redundant loop (planar), a spring, a drive, a damper.
ParametricScene loop() {
  return {
      .name = "redundant loop",
      .duration = 0.3,
      .draw =
          [](SystemGraph& graph, const SweepPoint& p) {
            const Vector3 A(0, 0, 0), B(0, 0, 0.3), C(0.5 + p["offset"], 0, 0.4), D(0.6, 0, 0);
            const auto rod = [&](const char* name, const Vector3& a, const Vector3& b, double mass) -> RigidBody& {
              const Vector3 x = (b - a).normalized();
              Matrix3 R;
              R << x, Vector3::UnitY(), x.cross(Vector3::UnitY());
              const double l = (b - a).norm();
              return graph.add<RigidBody>(name, {.mass = mass,
                                                 .inertia = {1e-3, mass * l * l / 12, mass * l * l / 12},
                                                 .position = (a + b) / 2,
                                                 .orientation = R});
            };
            auto& crank = rod("crank", A, B, p["mass"]);
            auto& coupler = rod("coupler", B, C, 0.7);
            auto& rocker = rod("rocker", D, C, 0.5);
            const auto hinge = [&](const char* name, auto& a, auto& b, const Vector3& at) -> RevoluteJoint& {
              return graph.add<RevoluteJoint>(name, {a.marker_at_world(at, kAlongY), b.marker_at_world(at, kAlongY)});
            };
            auto& pin =
                graph.add<RevoluteJoint>("A", {graph.ground().marker(A, kAlongY), crank.marker_at_world(A, kAlongY)});
            hinge("B", crank, coupler, B);
            hinge("C", coupler, rocker, C);
            graph.add<RevoluteJoint>("D", {graph.ground().marker(D, kAlongY), rocker.marker_at_world(D, kAlongY)});
            graph.add<SpringDamper>("spring", {graph.ground().marker({0.9, 0, 0.2}), coupler.marker()},
                                    {.stiffness = p["stiffness"], .damping = p["damping"]});
            return std::vector<Sensor>{position(coupler.marker(), "coupler"), joint_reaction(pin, "A"),
                                       coordinate(pin.angle(), "angle")};
          },
      .integrator = exact_alpha(3e-3)};
}

TEST(RunGradient, OfALoopWithRedundantRowsAndItsReactions) {
  expect_gradient(loop(),
                  {value_at("coupler_z", 0.3), value_at("angle", 0.2), value_at("A_force_x", 0.15),
                   integral("coupler_x"), smallest("coupler_z")},
                  {{"mass", 0.4}, {"offset", 0.02}, {"stiffness", 250}, {"damping", 3}});
}

/// A slender rod on a driven hinge; as a beam, with modes, with modes and deflections of second order.
ParametricScene driven_rod(const char* name, const Fidelity& fidelity, int elements) {
  return {
      .name = name,
      .duration = 0.2,
      .draw =
          [=](SystemGraph& graph, const SweepPoint& p) {
            const BeamSection section = BeamSection::rectangle(0.02, p["thickness"], {p["E"], 0.3, p["density"]});
            auto& rod =
                graph.add<SlenderBody>("rod", {.beam = {.axis = BeamAxis::straight({0, 0, 0}, {1, 0, 0}, {0, 1, 0}),
                                                        .sections = {{0, section}},
                                                        .elements = elements},
                                               .mode_count = 3});
            rod.set_fidelity(fidelity);
            auto& pin = graph.add<RevoluteJoint>("hub", {graph.ground().marker({}, kAlongY), rod.marker(0, kAlongY)});
            graph.add<CoordinateDrive>("drive", {pin.angle()}, {.motion = smooth_step(0, p["turn"], 0, 0.25)});
            return std::vector<Sensor>{position(rod.marker(1), "tip"), joint_reaction(pin, "hub")};
          },
      .integrator = exact_alpha(2e-3)};
}

const std::vector<DesignParameter> kRod{{"thickness", 0.01}, {"E", 7e10}, {"density", 2700}, {"turn", 0.6}};

TEST(RunGradient, OfADrivenRodWithModesByItsSectionAndMaterial) {
  expect_gradient(driven_rod("linear modes", {.modes = {0, 1, 2}}, 6), {value_at("tip_z", 0.2), integral("tip_x")},
                  kRod);
}
TEST(RunGradient, OfAStiffenedRod) {
  expect_gradient(driven_rod("stiffened", {.modes = {0, 1, 2}, .deflection = Deflection::stiffened}, 6),
                  {value_at("tip_z", 0.2), value_at("hub_force_x", 0.1)}, kRod);
}
TEST(RunGradient, OfABeam) {
  expect_gradient(driven_rod("beam", {.deflection = Deflection::exact}, 4), {value_at("tip_z", 0.2), smallest("tip_z")},
                  kRod);
}

TEST(RunGradient, LeavesTheRunItsBits) {
  const ParametricScene scene = pendulum();
  const std::vector<DesignParameter> parameters{{"mass", 1.3}, {"inertia", 0.08}, {"length", 0.4}, {"speed", 0.7}};
  const Gradient found = gradient(scene, {value_at("tip_x", 0.6), value_at("v_z", 0.6)}, parameters);
  SystemGraph graph{{.gravity = scene.gravity}};
  Table table{.columns = {"mass", "inertia", "length", "speed"}, .values = {1.3, 0.08, 0.4, 0.7}};
  const std::vector<Sensor> sensors = scene.draw(graph, SweepPoint(table, 0));
  const System system = assemble(graph);
  State state = system.initial_state();
  const auto integrator = scene.integrator();
  Simulation simulation(system, *integrator);
  simulation.run(state, scene.duration);
  Snapshot now(system, state);
  EXPECT_EQ(found.values[0], sensors[0].value(now, 0));
  EXPECT_EQ(found.values[1], sensors[1].value(now, 2));
}

TEST(RunGradient, RunsStretchesAgainWhereMemoryIsShort) {
  const std::vector<Quantity> quantities{value_at("coupler_z", 0.3), largest("angle")};
  const std::vector<DesignParameter> parameters{{"mass", 0.4}, {"offset", 0.02}, {"stiffness", 250}, {"damping", 3}};
  const Gradient all = gradient(loop(), quantities, parameters, {.mode = GradientOptions::Mode::adjoint});
  const Gradient some =
      gradient(loop(), quantities, parameters, {.mode = GradientOptions::Mode::adjoint, .memory = 60000});
  EXPECT_EQ(all.stretches, 1);
  EXPECT_GE(some.stretches, 3);
  EXPECT_LE(some.tape_bytes, 90000u);
  EXPECT_EQ(all.derivatives, some.derivatives);
}

TEST(RunGradient, RefusesByNameWhatItCannotDifferentiate) {
  const std::vector<DesignParameter> parameters{{"mass", 1.3}, {"inertia", 0.08}, {"length", 0.4}, {"speed", 0.7}};
  const auto refusal = [&](const ParametricScene& scene, const Quantity& quantity) -> std::string {
    try {
      gradient(scene, {quantity}, parameters);
    } catch (const SceneError& error) {
      return error.what();
    }
    return "none";
  };
  ParametricScene scene = pendulum();
  EXPECT_NE(refusal(scene, value_at("tip_q", 0.1)).find("known are tip_x"), std::string::npos);
  EXPECT_NE(refusal(scene, value_at("tip_x", 0.7)).find("outside the run"), std::string::npos);
  scene.integrator = [] { return std::make_unique<GeneralizedAlpha>(GeneralizedAlpha::Parameters{}); };
  EXPECT_NE(refusal(scene, value_at("tip_x", 0.1)).find("cannot be differentiated"), std::string::npos);
  scene.integrator = exact_alpha(7e-3);
  EXPECT_NE(refusal(scene, value_at("tip_x", 0.1)).find("divides the duration"), std::string::npos);
}

}  // namespace
}  // namespace lithe::test
