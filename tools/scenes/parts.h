#pragma once

#include <string>

#include "bodies/rigid_body.h"
#include "engine/model/system_graph.h"

/// Bodies drawn in world terms: what the problem statements of mechanisms give. For tests and tools.
namespace lithe::scenes {

/// A rotation with the given z axis (world), the x axis in the plane of z and `towards`.
inline Matrix3 axes_with_z(const Vector3& z, const Vector3& towards = Vector3(1, 0.1, 0.01)) {
  Matrix3 R;
  R.col(2) = z.normalized();
  R.col(0) = (towards - towards.dot(R.col(2)) * R.col(2)).normalized();
  R.col(1) = R.col(2).cross(R.col(0));
  return R;
}
/// A turn about world z, radians.
inline Matrix3 about_z(double angle) { return Eigen::AngleAxisd(angle, Vector3::UnitZ()).matrix(); }

/// A rigid body whose markers are placed by world points and axes at the start.
class Part {
 public:
  Part(SystemGraph& graph, Located name, double mass, const Vector3& inertia, const Vector3& position,
       const Matrix3& orientation = Matrix3::Identity(), const Vector3& velocity = Vector3::Zero(),
       const Vector3& world_angular_velocity = Vector3::Zero())
      : body(graph.add<RigidBody>(name, {.mass = mass,
                                         .inertia = inertia,
                                         .position = position,
                                         .orientation = orientation,
                                         .velocity = velocity,
                                         .angular_velocity = orientation.transpose() * world_angular_velocity})),
        position_(position),
        orientation_(orientation) {}

  Marker at(const Vector3& point, const Matrix3& axes = Matrix3::Identity()) const {
    return body.marker(Vector3(orientation_.transpose() * (point - position_)),
                       Matrix3(orientation_.transpose() * axes));
  }
  RigidBody& body;

 private:
  Vector3 position_;
  Matrix3 orientation_;
};

/// Uniform straight rod from a to b with its ends' velocities, x axis along it; it does not spin. `side` of its square
/// section, m; 0: slender, with a little inertia along that nothing excites.
inline Part rod(SystemGraph& graph, Located name, const Vector3& a, const Vector3& b, double mass, double side = 0,
                const Vector3& velocity_a = Vector3::Zero(), const Vector3& velocity_b = Vector3::Zero()) {
  const Vector3 d = b - a, omega = d.cross(velocity_b - velocity_a) / d.squaredNorm();
  Matrix3 R;  // x along the rod, z across it: world z if the rod is across that
  R.col(0) = d.normalized();
  const Vector3 z = std::abs(R(2, 0)) < 0.9 ? Vector3::UnitZ() : Vector3::UnitX();
  R.col(2) = (z - z.dot(R.col(0)) * R.col(0)).normalized();
  R.col(1) = R.col(2).cross(R.col(0));
  const double along = side > 0 ? mass * side * side / 6 : mass * d.squaredNorm() / 1200;
  const double across = mass * (d.squaredNorm() + side * side) / 12;
  return Part(graph, name, mass, {along, across, across}, (a + b) / 2, R, (velocity_a + velocity_b) / 2, omega);
}

}  // namespace lithe::scenes
