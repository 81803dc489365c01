#pragma once

#include <memory>
#include <string>
#include <vector>

#include "bodies/rigid_body.h"
#include "engine/study/doctor.h"
#include "integrators/explicit_runge_kutta.h"
#include "integrators/generalized_alpha.h"
#include "integrators/ida.h"
#include "joints/revolute_joint.h"

/// What patients of the doctor are made of.
namespace lithe::test {

using Draw = std::function<std::vector<Sensor>(SystemGraph&)>;

/// A scene, how it is run, and what is wrong with it (sound scenes: unknown).
struct Patient {
  std::string name;
  Cause cause = Cause::unknown;
  StudyMethod method;
  double setting = 0;
  StudyScene scene;
};

inline StudyMethod runge_kutta_by_tolerance() {
  return {"explicit Runge-Kutta", StudyMethod::Setting::tolerance, [](double t) {
            return std::make_unique<ExplicitRungeKutta>(
                ExplicitRungeKutta::Parameters{.tolerance = {.relative = t, .absolute = t}});
          }};
}
inline StudyMethod runge_kutta_by_step() {
  return {"explicit Runge-Kutta", StudyMethod::Setting::step,
          [](double h) { return std::make_unique<ExplicitRungeKutta>(ExplicitRungeKutta::Parameters{.step = h}); }};
}
inline StudyMethod ida_by_tolerance() {
  return {"IDA", StudyMethod::Setting::tolerance,
          [](double t) { return std::make_unique<Ida>(Ida::Parameters{.tolerance = {.relative = t, .absolute = t}}); }};
}
inline StudyMethod alpha_by_step(double spectral_radius = 0.8,
                                 GeneralizedAlpha::Form form = GeneralizedAlpha::Form::stabilized_index2) {
  return {"generalized-alpha", StudyMethod::Setting::step, [=](double h) {
            return std::make_unique<GeneralizedAlpha>(
                GeneralizedAlpha::Parameters{.step = h, .spectral_radius = spectral_radius, .form = form});
          }};
}
inline StudyMethod alpha_by_tolerance() {
  return {"generalized-alpha", StudyMethod::Setting::tolerance, [](double t) {
            return std::make_unique<GeneralizedAlpha>(GeneralizedAlpha::Parameters{
                .form = GeneralizedAlpha::Form::stabilized_index2, .tolerance = {.relative = t, .absolute = t}});
          }};
}

/// z of markers along world y: hinges of machines in the plane of x and z.
inline Matrix3 along_y() { return rotation_about({1, 0, 0}, -M_PI / 2); }

/// A slender rod of `mass` from A to B, in the plane of x and z, x along it.
inline RigidBody& draw_rod(SystemGraph& graph, const std::string& name, const Vector3& A, const Vector3& B,
                           double mass = 1, const Vector3& velocity = {0, 0, 0}, double speed = 0) {
  const Vector3 d = B - A;
  const double J = mass * d.squaredNorm() / 12;
  return graph.add<RigidBody>(name, {.mass = mass,
                                     .inertia = {0.01 * J, J, J},
                                     .position = 0.5 * (A + B),
                                     .orientation = rotation_about({0, 1, 0}, std::atan2(-d.z(), d.x())),
                                     .velocity = velocity,
                                     .angular_velocity = {0, speed, 0}});
}
/// The end of such a rod, at x = side · length / 2, hinge axis y.
inline Marker end_of(RigidBody& rod, double length, double side) {
  return rod.marker({side * length / 2, 0, 0}, along_y());
}
inline Marker ground_at(SystemGraph& graph, const Vector3& p) { return graph.ground().marker(p, along_y()); }

/// A rod of 1 m on a hinge at the origin, lifted by `angle` from hanging, turning at `speed` about y.
inline RigidBody& draw_pendulum(SystemGraph& graph, double angle, double speed = 0, double mass = 1) {
  const Vector3 tip(std::sin(angle), 0, -std::cos(angle));
  const Vector3 omega(0, speed, 0);
  auto& rod = draw_rod(graph, "rod", {0, 0, 0}, tip, mass, omega.cross(0.5 * tip), speed);
  graph.add<RevoluteJoint>("pin", {ground_at(graph, {0, 0, 0}), end_of(rod, 1, -1)});
  return rod;
}

}  // namespace lithe::test
