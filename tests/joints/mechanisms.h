#pragma once

#include <numbers>
#include <string>
#include <vector>

#include "bodies/rigid_body.h"
#include "engine/observe/sensors.h"
#include "joints/revolute_joint.h"
#include "tests/support/methods.h"
#include "tests/support/scenes.h"

/// Pieces of the machines that the tests of joints run.
namespace lithe::test {

constexpr double kPi = std::numbers::pi;

double read(const Scene& scene, const Sensor& sensor, int column = 0);

Vector3 read_vector(const Scene& scene, const Sensor& sensor, int first = 0);

/// A body on a bearing of the ground, its axis the z axis of `axes`.
struct Shaft {
  RigidBody* body = nullptr;
  RevoluteJoint* pin = nullptr;

  JointCoordinate angle() const { return pin->angle(); }
};

Shaft draw_shaft(SystemGraph& graph, const std::string& name, double inertia, const Vector3& center = {0, 0, 0},
                 const Matrix3& axes = Matrix3::Identity(), double speed = 0);

/// One of each integrator, steps of h where they are fixed.
struct NamedMethod {
  std::string name;
  Method integrator;
};

std::vector<NamedMethod> every_method(double h, double tolerance = 1e-9);

}  // namespace lithe::test
