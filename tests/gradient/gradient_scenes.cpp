#include "tests/gradient/gradient_scenes.h"
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

namespace lithe::test {
namespace {

const Matrix3 kAlongY = rotation_about({1, 0, 0}, -M_PI / 2);

/// Direction of an angle, and the direction of the problem's (sin, -cos), a quarter turn back.
Vector3 along(double a) { return {std::cos(a), std::sin(a), 0}; }
Vector3 back(double a) { return {std::sin(a), -std::cos(a), 0}; }

/// A body drawn where it lies at the start; markers by points of the world.
struct Piece {
  RigidBody& body;
  Vector3 center;
  Matrix3 R;
  Piece(SystemGraph& graph, const std::string& name, double mass, double inertia, const Vector3& p, double angle)
      : body(graph.add<RigidBody>(name, {.mass = mass,
                                         .inertia = {inertia, inertia, inertia},
                                         .position = p,
                                         .orientation = rotation_about({0, 0, 1}, angle)})),
        center(p),
        R(rotation_about({0, 0, 1}, angle)) {}
  Marker at(const Vector3& p) const { return body.marker(Vector3(R.transpose() * (p - center))); }
};

std::vector<Sensor> draw_squeezer(SystemGraph& graph, const SweepPoint& point) {
  // The angles at t = 0, as the problem names them.
  const double b = -6.17138900142764485e-2, th = 0, ga = 4.55279819163070365e-1, ph = 2.22668390165885882e-1;
  const double de = 4.87364979543842558e-1, om = -2.22668390165885882e-1, ep = 1.23054744454982123;
  const Vector3 O(0, 0, 0), A(-0.06934, -0.00227, 0), B(-0.03635, 0.03273, 0), C(0.014, 0.072, 0);
  const Vector3 F = 0.007 * along(b), E = F - 0.028 * along(b + th), D = B + 0.02 * along(ga) + 0.018 * back(ga);
  const Vector3 G = A + 0.04 * along(de), H = A + 0.04 * back(ep);

  const Piece K1(graph, "K1", 0.04325, 2.194e-6, 0.00092 * along(b), b);
  const Piece K2(graph, "K2", 0.00365, 4.410e-7, F - 0.0115 * along(b + th), b + th);
  const Piece K3(graph, "K3", 0.02373, 5.255e-6, B + 0.01043 * along(ga) + 0.01874 * back(ga), ga);
  const Piece K4(graph, "K4", 0.00706, 5.667e-7, E - 0.01421 * back(ph + de), ph + de);
  const Piece K5(graph, "K5", point["mass"], 1.169e-5, A + 0.02308 * along(de) - 0.00916 * back(de), de);
  const Piece K6(graph, "K6", 0.00706, 5.667e-7, E - 0.01421 * along(om + ep), om + ep);
  const Piece K7(graph, "K7", 0.05498, 1.912e-5, A + 0.01228 * back(ep) - 0.00449 * along(ep), ep);
  const auto ground = [&](const Vector3& p) { return graph.ground().marker(p); };
  graph.add<RevoluteJoint>("O", {ground(O), K1.at(O)});
  graph.add<RevoluteJoint>("F", {K1.at(F), K2.at(F)});
  graph.add<RevoluteJoint>("E of K3", {K2.at(E), K3.at(E)});
  graph.add<RevoluteJoint>("E of K4", {K2.at(E), K4.at(E)});
  graph.add<RevoluteJoint>("E of K6", {K2.at(E), K6.at(E)});
  graph.add<RevoluteJoint>("B", {ground(B), K3.at(B)});
  graph.add<RevoluteJoint>("G", {K5.at(G), K4.at(G)});
  graph.add<RevoluteJoint>("H", {K7.at(H), K6.at(H)});
  graph.add<RevoluteJoint>("A of K5", {ground(A), K5.at(A)});
  graph.add<RevoluteJoint>("A of K7", {ground(A), K7.at(A)});
  graph.add<SpringDamper>("spring", {ground(C), K3.at(D)},
                          {.stiffness = point["stiffness"], .natural_length = point["natural_length"]});
  graph.add<PointForce>("motor", {K1.body.marker()}, {.torque = {0, 0, point["torque"]}});
  return {position(K1.at(F), "F"), position(K3.at(E), "E"), position(K5.at(G), "G"), position(K7.at(H), "H")};
}

}  // namespace

ParametricScene squeezer() {
  return {.name = "squeezer",
          .duration = 0.03,
          .gravity = {0, 0, 0},
          .draw = draw_squeezer,
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
