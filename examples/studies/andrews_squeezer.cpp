// Andrews' squeezing mechanism (R03; Hairer & Wanner II, VII.7): seven bodies, ten hinges, 30 ms of a motion that turns
// its crank two and a half times.  lithe chart andrews_squeezer
#include "lithe/lithe.h"

using namespace lithe;

namespace {

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

std::vector<Sensor> draw(SystemGraph& graph) {
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
  const Piece K5(graph, "K5", 0.07050, 1.169e-5, A + 0.02308 * along(de) - 0.00916 * back(de), de);
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
  graph.add<SpringDamper>("spring", {ground(C), K3.at(D)}, {.stiffness = 4530, .natural_length = 0.07785});
  graph.add<PointForce>("motor", {K1.body.marker()}, {.torque = {0, 0, 0.033}});
  return {position(K1.at(F), "F"), position(K3.at(E), "E"), position(K5.at(G), "G"), position(K7.at(H), "H")};
}

}  // namespace

StudyScene scene() {
  return {.name = "Andrews' squeezer",
          .duration = 0.03,
          .gravity = {0, 0, 0},
          .characteristic_length = 0.007,  // m: the crank
          .draw = draw};
}
