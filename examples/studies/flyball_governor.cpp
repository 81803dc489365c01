// Flyball governor (R05): arms that damp against the slider at 3e4 1/s beside a motion of 6 rad/s. Stiff: explicit
// methods are held to steps of some 1e-4 s whatever the tolerance.  lithe chart flyball_governor
#include "lithe/lithe.h"

using namespace lithe;

namespace {

/// Two arms of 0.3 kg and 1 m with 5 kg at their ends, on a shaft that turns once a second.
std::vector<Sensor> draw(SystemGraph& graph) {
  const Vector3 spin(0, 0, 2 * M_PI);
  const double across = 0.3 * (1 + 1e-4) / 12, thin = 0.3 * 2e-4 / 12;
  auto& shaft = graph.add<RigidBody>(
      "shaft", {.mass = 0.3, .inertia = {across, across, thin}, .position = {0, 0, 0.5}, .angular_velocity = spin});
  auto& slider = graph.add<RigidBody>(
      "slider", {.mass = 3, .inertia = {0.005, 0.005, 0.005}, .position = {0, 0, 0.5}, .angular_velocity = spin});
  graph.add<RevoluteJoint>("bearing", {graph.ground().marker(), shaft.marker({0, 0, -0.5})});
  graph.add<PrismaticJoint>("guide", {shaft.marker(), slider.marker()});

  const Matrix3 along_y = rotation_about({1, 0, 0}, -M_PI / 2);
  for (const double side : {1.0, -1.0}) {
    // The arm's x axis points outwards and down by 30 degrees; its centre of mass lies at s from the hinge.
    const double mass = 5.3, s = (0.3 * 0.5 + 5) / mass;
    const double about_center = across + 0.3 * (s - 0.5) * (s - 0.5) + 5 * (1 - s) * (1 - s);
    const Vector3 hinge(side * 0.05, 0, 1), d(side * std::cos(M_PI / 6), 0, -std::sin(M_PI / 6));
    Matrix3 R;
    R << d, Vector3::UnitY(), d.cross(Vector3::UnitY());
    const std::string name = side > 0 ? "right" : "left";
    auto& arm = graph.add<RigidBody>(name, {.mass = mass,
                                            .inertia = {thin, about_center, about_center},
                                            .position = hinge + s * d,
                                            .orientation = R,
                                            .velocity = spin.cross(hinge + s * d),
                                            .angular_velocity = R.transpose() * spin});
    graph.add<RevoluteJoint>(name + " hinge", {shaft.marker({side * 0.05, 0, 0.5}, along_y),
                                               arm.marker({-s, 0, 0}, Matrix3(R.transpose() * along_y))});
    graph.add<SpringDamper>(name + " damper", {slider.marker({side * 0.05, 0, 0}), arm.marker({0.5 - s, 0, 0})},
                            {.stiffness = 8e5, .damping = 4e4, .natural_length = 0.5});
  }
  return {height(slider.marker(), "slider")};
}

}  // namespace

StudyScene scene() { return {.name = "flyball governor", .duration = 2, .characteristic_length = 1, .draw = draw}; }
