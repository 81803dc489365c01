#include "tools/scenes/squeezer.h"

#include "joints/forces/point_force.h"
#include "joints/forces/spring_damper.h"
#include "joints/revolute_joint.h"
#include "tools/scenes/parts.h"

namespace lithe::scenes {

SqueezerPoints draw_squeezer(SystemGraph& graph, const SqueezerAngles& at, const SqueezerNumbers& numbers) {
  /// Direction of an angle, and the direction of the problem's (sin, -cos) formulas, a quarter turn back.
  const auto along = [](double a) { return Vector3(std::cos(a), std::sin(a), 0); };
  const auto back = [](double a) { return Vector3(std::sin(a), -std::cos(a), 0); };
  const auto& [b, th, ga, ph, de, om, ep] = at;
  const Vector3 O(0, 0, 0), A(-0.06934, -0.00227, 0), B(-0.03635, 0.03273, 0), C(0.014, 0.072, 0);
  const Vector3 F = 0.007 * along(b), E = F - 0.028 * along(b + th), D = B + 0.02 * along(ga) + 0.018 * back(ga);
  const Vector3 G = A + 0.04 * along(de), H = A + 0.04 * back(ep);
  const auto body = [&](const char* name, double mass, double inertia, const Vector3& center, double angle) {
    return Part(graph, name, mass, Vector3::Constant(inertia), center, about_z(angle));
  };
  const Part K1 = body("K1", 0.04325, 2.194e-6, 0.00092 * along(b), b);
  const Part K2 = body("K2", 0.00365, 4.410e-7, F - 0.0115 * along(b + th), b + th);
  const Part K3 = body("K3", 0.02373, 5.255e-6, B + 0.01043 * along(ga) + 0.01874 * back(ga), ga);
  const Part K4 = body("K4", 0.00706, 5.667e-7, E - 0.01421 * back(ph + de), ph + de);
  const Part K5 = body("K5", numbers.mass, 1.169e-5, A + 0.02308 * along(de) - 0.00916 * back(de), de);
  const Part K6 = body("K6", 0.00706, 5.667e-7, E - 0.01421 * along(om + ep), om + ep);
  const Part K7 = body("K7", 0.05498, 1.912e-5, A + 0.01228 * back(ep) - 0.00449 * along(ep), ep);
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
                          {.stiffness = numbers.stiffness, .natural_length = numbers.natural_length});
  graph.add<PointForce>("motor", {K1.body.marker()}, {.torque = {0, 0, numbers.torque}});
  return {K1.at(F), K3.at(E), K5.at(G), K7.at(H)};
}

}  // namespace lithe::scenes
