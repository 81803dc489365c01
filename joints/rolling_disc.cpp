#include "joints/rolling_disc.h"

#include "engine/assembly/batch_of.h"
#include "engine/base/checks.h"
#include "engine/model/initial_pose.h"

namespace lithe {

RollingDisc::RollingDisc(Parameters parameters) : radius_(parameters.radius) { require::positive(radius_, "radius"); }

void RollingDisc::evaluate(double, std::span<const MarkerView> markers, ConstraintRows& rows) const {
  const auto &A = markers[0], &B = markers[1];
  const double r = radius_;
  const Vector3 n = A.z(), a = B.z(), d = B.p - A.p, n_dot = A.w.cross(n), a_dot = B.w.cross(a);
  // u = m / |m|, m = n - (n·a) a
  const double na = n.dot(a), na_dot = n_dot.dot(a) + n.dot(a_dot);
  const Vector3 m = n - na * a, m_dot = n_dot - na_dot * a - na * a_dot;
  const double length = m.norm();
  const Vector3 u = m / length, u_dot = (m_dot - u * u.dot(m_dot)) / length;

  // Height of the lowest point: n·d - r |m|, with |m|' = -na na' / |m| and na' = (n × a)·(w_A - w_B).
  const Vector3 turn = (r * na / length) * n.cross(a);
  const Vector3 d_dot = B.v - A.v;
  const double na_length = na / length;
  const double na_length_dot = na_dot / length + na * na * na_dot / (length * length * length);
  const Vector3 turn_dot = r * (na_length_dot * n.cross(a) + na_length * (n_dot.cross(a) + n.cross(a_dot)));
  rows.add(n.dot(d) - r * length, {{-n, turn + n.cross(d)}, {n, -turn}},
           2 * n_dot.dot(d_dot) + A.w.cross(n_dot).dot(d) + turn_dot.dot(A.w - B.w));

  // Slip of the disc's point on the plane's, along x_A and y_A.
  const Vector3 arm = -r * u, arm_dot = -r * u_dot, contact = d + arm, contact_dot = d_dot + arm_dot;
  const Vector3 slip = d_dot + B.w.cross(arm) - A.w.cross(contact);
  const Vector3 slip_bias = B.w.cross(arm_dot) - A.w.cross(contact_dot);
  for (int axis = 0; axis < 2; ++axis) {
    const Vector3 t = A.R.col(axis);
    rows.add_velocity({{-t, -contact.cross(t)}, {t, arm.cross(t)}}, t.dot(slip_bias) + A.w.cross(t).dot(slip));
  }
}

void RollingDisc::initialize(std::span<const MarkerView> m) { initial::not_parallel(m[0].z(), m[1].z(), "z", "z"); }

template std::unique_ptr<ConstraintBatch> make_constraint_batch<RollingDisc>();

}  // namespace lithe
