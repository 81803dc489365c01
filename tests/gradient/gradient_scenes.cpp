#include "tests/gradient/gradient_scenes.h"

#include "bodies/beam/slender_body.h"
#include "bodies/rigid_body.h"
#include "joints/coordinate_drive.h"
#include "joints/forces/spring_damper.h"
#include "joints/revolute_joint.h"
#include "joints/spherical_joint.h"
#include "tools/scenes/squeezer.h"

namespace lithe::test {
namespace {

const Matrix3 kAlongY = rotation_about({1, 0, 0}, -M_PI / 2);

std::vector<Sensor> draw_measured(SystemGraph& graph, const SweepPoint& p) {
  const scenes::SqueezerPoints at = scenes::draw_squeezer(
      graph, scenes::kSqueezerStart,
      {.mass = p["mass"], .stiffness = p["stiffness"], .natural_length = p["natural_length"], .torque = p["torque"]});
  return {position(at.F, "F"), position(at.E, "E"), position(at.G, "G"), position(at.H, "H")};
}

}  // namespace

ParametricScene squeezer() {
  return {.name = "squeezer",
          .duration = 0.03,
          .gravity = {0, 0, 0},
          .draw = draw_measured,
          .integrator = exact_alpha(1e-4)};
}

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

ParametricScene tumbling_top() {
  return {.name = "top",
          .duration = 0.4,
          .draw =
              [](SystemGraph& graph, const SweepPoint& p) {
                const Vector3 arm(0.1, -0.05, p["length"]), turning(1.5, -2, p["spin"]);
                const Matrix3 R = rotation_about({1, 0, 0}, 0.4);
                auto& top = graph.add<RigidBody>("top", {.mass = p["mass"],
                                                         .inertia = {p["inertia"], 0.05, 0.03},
                                                         .position = R * arm,
                                                         .orientation = R,
                                                         .velocity = R * turning.cross(arm),
                                                         .angular_velocity = turning});
                graph.add<SphericalJoint>("ball", {graph.ground().marker(), top.marker(-arm)});
                return std::vector<Sensor>{position(top.marker({0.2, 0, 0}), "tip"), velocity(top.marker(), "v")};
              },
          .integrator = exact_alpha(5e-3)};
}

ParametricScene redundant_loop() {
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

}  // namespace lithe::test
