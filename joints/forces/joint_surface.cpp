#include "joints/forces/joint_surface.h"

#include "engine/base/checks.h"

namespace lithe {
namespace {

bool share_an_axis(const JointCoordinate& angle, const JointCoordinate& displacement) {
  return angle.kind == JointCoordinate::Kind::angle && displacement.kind == JointCoordinate::Kind::displacement &&
         angle.A == displacement.A && angle.B == displacement.B && angle.axis == displacement.axis;
}

void add(JointSurface::Press& press, const Vector3& f, double arm, Vector3 Wrench::*of) {
  const double length = f.norm();
  if (length == 0) return;
  press.force += length / arm;
  press.by.*of += f / (length * arm);
}

}  // namespace

JointSurface::JointSurface(CoordinateSet coordinates, Parameters parameters)
    : coordinates_(std::move(coordinates)), parameters_(parameters) {
  const Parameters& p = parameters_;
  if (!p.joint) throw SceneError("names no joint", "", "give .joint = &pin: whose reaction presses");
  if (coordinates_.count() > 2 || (coordinates_.count() == 2 && !share_an_axis(coordinates_[0], coordinates_[1])))
    throw SceneError("friction acts on one coordinate, or on an angle and the displacement along its axis", "",
                     "give {joint.angle(), joint.displacement()}, or add one for each coordinate");
  for (const auto& [value, name] :
       {std::pair(p.radius, "radius"), std::pair(p.bending_arm, "bending_arm"), std::pair(p.preload, "preload")})
    require::not_negative(value, name);
  if (turns()) require::positive(p.radius, "radius");
}

double JointSurface::viscous(double given) const {
  return slides() ? given : given / (parameters_.radius * parameters_.radius);
}

JointSurface::Sliding JointSurface::sliding(std::span<const MarkerView> markers, const AngleMemory& memory) const {
  Sliding all;
  for (int k = 0; k < directions(); ++k) {
    if (ball()) {
      const Vector3 arm = parameters_.radius * markers[0].R.col(k);
      all.speed[k] = arm.dot(markers[1].w - markers[0].w);
      all.on_A[k] = torque(-arm), all.on_B[k] = torque(arm);
      continue;
    }
    const MeasuredCoordinate x = coordinates_.measure(k, markers, memory);
    const double arm = coordinates_.is_angle(k) ? parameters_.radius : 1;
    all.speed[k] = arm * x.rate;
    all.on_A[k] = arm * x.on_A, all.on_B[k] = arm * x.on_B;
  }
  return all;
}

void JointSurface::fill(const Sliding& sliding, const Vector3& direction, Wrench* wrenches) const {
  for (int m = 0; m < marker_count(); ++m) wrenches[m] = {Vector3::Zero(), Vector3::Zero()};
  for (int k = 0; k < directions(); ++k) {
    Wrench* pair = wrenches + (ball() ? 0 : 2 * k);
    pair[0] = pair[0] + direction[k] * sliding.on_A[k];
    pair[1] = pair[1] + direction[k] * sliding.on_B[k];
  }
}

JointSurface::Press JointSurface::press(std::span<const MarkerView> markers, const Wrench& reaction) const {
  const Parameters& p = parameters_;
  const auto& [F, T] = reaction;
  Press press{p.preload, {Vector3::Zero(), Vector3::Zero()}};
  if (ball()) {
    add(press, F, 1, &Wrench::force);
    return press;
  }
  const Vector3 axis = coordinates_.axis(0, markers);
  const double thrust = turns() ? axis.dot(F) : 0, twist = slides() && p.radius > 0 ? axis.dot(T) / p.radius : 0;
  add(press, F - axis.dot(F) * axis, 1, &Wrench::force);
  if (p.bending_arm > 0) add(press, T - axis.dot(T) * axis, p.bending_arm, &Wrench::torque);
  const double axial = std::hypot(thrust, twist);
  if (axial == 0) return press;
  press.force += axial;
  press.by.force += thrust / axial * axis;
  if (twist != 0) press.by.torque += twist / (axial * p.radius) * axis;
  return press;
}

}  // namespace lithe
