#include "joints/forces/joint_surface.h"

#include "engine/base/checks.h"

namespace lithe {
namespace {

bool share_an_axis(const JointCoordinate& angle, const JointCoordinate& displacement) {
  return angle.kind == JointCoordinate::Kind::angle && displacement.kind == JointCoordinate::Kind::displacement &&
         angle.A == displacement.A && angle.B == displacement.B && angle.axis == displacement.axis;
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

Vector3 JointSurface::slid(std::span<const MarkerView> from, std::span<const MarkerView> to) const {
  if (ball()) {
    const Matrix3 before = from[0].R.transpose() * from[1].R, now = to[0].R.transpose() * to[1].R;
    return parameters_.radius * rotation_log(now * before.transpose());
  }
  Vector3 way = Vector3::Zero();
  for (int k = 0; k < directions(); ++k) {
    const JointCoordinate& x = coordinates_[k];
    const auto value = [&](std::span<const MarkerView> m) {
      return x.sign * measure(x.kind, x.axis, m[2 * k], m[2 * k + 1]).value;
    };
    const double change = value(to) - value(from);
    way[k] = x.is_angle() ? parameters_.radius * std::remainder(change, 2 * M_PI) : change;
  }
  return way;
}

int JointSurface::presses(std::span<const MarkerView> markers, FrictionByImpulses::Press* P) const {
  const Parameters& p = parameters_;
  int count = 0;
  const auto open = [&]() -> FrictionByImpulses::Press& {
    P[count].setZero();
    return P[count++];
  };
  if (ball()) {
    open().leftCols<3>().setIdentity();
    return count;
  }
  const Vector3 axis = coordinates_.axis(0, markers);
  const Matrix3 across = Matrix3::Identity() - axis * axis.transpose();
  open().leftCols<3>() = across;
  if (p.bending_arm > 0) open().rightCols<3>() = across / p.bending_arm;
  const bool twists = slides() && p.radius > 0;
  if (!turns() && !twists) return count;
  auto& axial = open();
  if (turns()) axial.row(0).head<3>() = axis;
  if (twists) axial.row(1).tail<3>() = axis / p.radius;
  return count;
}

JointSurface::Press JointSurface::press(std::span<const MarkerView> markers, const Wrench& reaction) const {
  FrictionByImpulses::Press P[FrictionByImpulses::kMostPresses];
  Vector6 R, by = Vector6::Zero();
  R << reaction.force, reaction.torque;
  double force = parameters_.preload;
  const int count = presses(markers, P);
  for (int i = 0; i < count; ++i) {
    const Vector3 part = P[i] * R;
    const double length = part.norm();
    if (length == 0) continue;
    force += length;
    by += P[i].transpose() * part / length;
  }
  return {force, {by.head<3>(), by.tail<3>()}};
}

}  // namespace lithe
