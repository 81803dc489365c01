#pragma once

#include <numbers>
#include <vector>

#include "engine/sensors.h"
#include "engine/snapshot.h"
#include "joints/revolute_joint.h"
#include "tests/support/methods.h"
#include "tests/support/scenes.h"

/// Pieces of the machines that the tests of joints run.
namespace lithe::test {

constexpr double kPi = std::numbers::pi;

inline double read(const Scene& scene, const Sensor& sensor, int column = 0) {
  Snapshot now{scene.system, scene.state};
  return sensor.value(now, column);
}
inline Vector3 read_vector(const Scene& scene, const Sensor& sensor, int first = 0) {
  Snapshot now{scene.system, scene.state};
  return {sensor.value(now, first), sensor.value(now, first + 1), sensor.value(now, first + 2)};
}

/// A body on a bearing of the ground, its axis the z axis of `axes`.
struct Shaft {
  RigidBody* body = nullptr;
  RevoluteJoint* pin = nullptr;

  JointCoordinate angle() const { return pin->angle(); }
};
inline Shaft draw_shaft(SystemGraph& graph, const std::string& name, double inertia, const Vector3& center = {0, 0, 0},
                        const Matrix3& axes = Matrix3::Identity(), double speed = 0) {
  Shaft shaft;
  shaft.body = &graph.add<RigidBody>(name, {.mass = 2,
                                            .inertia = {0.8 * inertia, 0.7 * inertia, inertia},
                                            .position = center,
                                            .orientation = axes,
                                            .angular_velocity = {0, 0, speed}});
  shaft.pin = &graph.add<RevoluteJoint>(name + " pin", {graph.ground().marker(center, axes), shaft.body->marker()});
  return shaft;
}

/// One of each integrator, steps of h where they are fixed.
struct NamedMethod {
  std::string name;
  Method integrator;
};
inline std::vector<NamedMethod> every_method(double h, double tolerance = 1e-9) {
  std::vector<NamedMethod> all;
  all.push_back({"index 3", index3(h)});
  all.push_back({"index 2", index2(h)});
  all.push_back({"Runge-Kutta", runge_kutta(tolerance)});
  all.push_back({"IDA", ida(tolerance)});
  return all;
}

}  // namespace lithe::test
