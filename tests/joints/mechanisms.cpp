#include "tests/joints/mechanisms.h"

#include "engine/observe/snapshot.h"

namespace lithe::test {

double read(const Scene& scene, const Sensor& sensor, int column) {
  Snapshot now{scene.system, scene.state};
  return sensor.value(now, column);
}

Vector3 read_vector(const Scene& scene, const Sensor& sensor, int first) {
  Snapshot now{scene.system, scene.state};
  return {sensor.value(now, first), sensor.value(now, first + 1), sensor.value(now, first + 2)};
}

Shaft draw_shaft(SystemGraph& graph, const std::string& name, double inertia, const Vector3& center,
                 const Matrix3& axes, double speed) {
  Shaft shaft;
  shaft.body = &graph.add<RigidBody>(name, {.mass = 2,
                                            .inertia = {0.8 * inertia, 0.7 * inertia, inertia},
                                            .position = center,
                                            .orientation = axes,
                                            .angular_velocity = {0, 0, speed}});
  shaft.pin = &graph.add<RevoluteJoint>(name + " pin", {graph.ground().marker(center, axes), shaft.body->marker()});
  return shaft;
}

std::vector<NamedMethod> every_method(double h, double tolerance) {
  std::vector<NamedMethod> all;
  all.push_back({"index 3", index3(h)});
  all.push_back({"index 2", index2(h)});
  all.push_back({"Runge-Kutta", runge_kutta(tolerance)});
  all.push_back({"IDA", ida(tolerance)});
  return all;
}

}  // namespace lithe::test
