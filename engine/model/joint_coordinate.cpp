#include "engine/model/joint_coordinate.h"

#include <string>

#include "engine/base/error.h"
#include "engine/model/initial_pose.h"

namespace lithe {
namespace {

using Kind = JointCoordinate::Kind;

/// φ = atan2(s, c) with c = u·e₁, s = u·e₂: e₁, e₂ turn with A, u is a vector whose rate in A's axes is `u_rate`.
/// φ̇ = h·u_rate / ρ² with h = c e₂ - s e₁, ρ² = c² + s².
struct Turning {
  double angle;
  Vector3 f, f_dot;  // h / ρ² and its rate in the world

  Turning(const MarkerView& A, int axis, const Vector3& u, const Vector3& u_rate) {
    const Vector3 e1 = A.R.col((axis + 1) % 3), e2 = A.R.col((axis + 2) % 3);
    const double c = u.dot(e1), s = u.dot(e2), c_dot = u_rate.dot(e1), s_dot = u_rate.dot(e2);
    const double rho = c * c + s * s;
    const Vector3 h = c * e2 - s * e1;
    angle = std::atan2(s, c);
    f = h / rho;
    f_dot = (c_dot * e2 - s_dot * e1 + A.w.cross(h)) / rho - f * (2 * (c * c_dot + s * s_dot) / rho);
  }
};

MeasuredCoordinate angle(int axis, const MarkerView& A, const MarkerView& B) {
  const Vector3 u = B.R.col((axis + 1) % 3), w = B.w - A.w;
  const Turning turning(A, axis, u, w.cross(u));
  // φ̇ = f·(w × u) = (u × f)·w
  const Vector3 t = u.cross(turning.f), t_dot = B.w.cross(u).cross(turning.f) + u.cross(turning.f_dot);
  return {turning.angle, t.dot(w), t_dot.dot(w), torque(-t), torque(t)};
}

MeasuredCoordinate bearing(int axis, const MarkerView& A, const MarkerView& B) {
  const Vector3 d = B.p - A.p, d_dot = B.v - A.v, d_rate = d_dot - A.w.cross(d);
  const Turning turning(A, axis, d, d_rate);
  const Vector3& f = turning.f;
  return {
      turning.angle, f.dot(d_rate), turning.f_dot.dot(d_rate) - f.dot(A.w.cross(d_dot)), {-f, -d.cross(f)}, force(f)};
}

MeasuredCoordinate displacement(int axis, const MarkerView& A, const MarkerView& B) {
  const Vector3 a = A.R.col(axis), d = B.p - A.p, d_dot = B.v - A.v, a_dot = A.w.cross(a);
  return {a.dot(d),
          a.dot(d_dot) + a_dot.dot(d),
          2 * a_dot.dot(d_dot) + A.w.cross(a_dot).dot(d),
          {-a, a.cross(d)},
          force(a)};
}

MeasuredCoordinate distance(const MarkerView& A, const MarkerView& B) {
  const Vector3 d = B.p - A.p, d_dot = B.v - A.v;
  const double length = d.norm();
  const Vector3 n = length > 0 ? Vector3(d / length) : Vector3(0, 0, 0);
  const double rate = n.dot(d_dot);
  return {length, rate, length > 0 ? (d_dot.squaredNorm() - rate * rate) / length : 0, force(-n), force(n)};
}

}  // namespace

MeasuredCoordinate measure(Kind kind, int axis, const MarkerView& A, const MarkerView& B) {
  switch (kind) {
    case Kind::angle:
      return angle(axis, A, B);
    case Kind::bearing:
      return bearing(axis, A, B);
    case Kind::displacement:
      return displacement(axis, A, B);
    case Kind::distance:
      break;
  }
  return distance(A, B);
}

void CoordinateSet::require_one(const char* element) const {
  if (count() != 1)
    throw SceneError(std::string(element) + " acts on one coordinate", "", "add one for each coordinate");
}

std::vector<Marker> CoordinateSet::markers() const {
  std::vector<Marker> all;
  for (const JointCoordinate& x : coordinates_) {
    if (x.axis < 0 || x.axis > 2)
      throw SceneError("a joint coordinate has the axis " + std::to_string(x.axis), "",
                       "give 0, 1 or 2: x, y or z of A");
    all.insert(all.end(), {x.A, x.B});
  }
  return all;
}

std::vector<MeasuredAngle> CoordinateSet::angles() const {
  std::vector<MeasuredAngle> all;
  for (int i = 0; i < count(); ++i)
    all.push_back({2 * i, 2 * i + 1, coordinates_[i].axis, coordinates_[i].kind == Kind::bearing});
  return all;
}

MeasuredCoordinate CoordinateSet::measure(int i, std::span<const MarkerView> markers, const AngleMemory& memory) const {
  const auto& [kind, A, B, axis, sign] = coordinates_[i];
  MeasuredCoordinate x = lithe::measure(kind, axis, markers[2 * i], markers[2 * i + 1]);
  if (is_angle(i)) x.value = memory.quarter_turns() ? memory.wound(i, x.value) : initial::angle(x.value);
  if (sign > 0) return x;
  return {-x.value, -x.rate, -x.bias, {-x.on_A.force, -x.on_A.torque}, {-x.on_B.force, -x.on_B.torque}};
}

}  // namespace lithe
