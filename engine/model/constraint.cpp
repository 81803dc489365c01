#include "engine/model/constraint.h"

namespace lithe {
namespace {

/// Adds a 3x3 block of the loaded rows' stiffness: marker `m`, force (0) or torque (3), by marker `n`'s motion (0) or
/// rotation (3).
void add(ConstraintRows& rows, int m, int of, int n, int by, const Matrix3& block) {
  rows.stiffness()->block<3, 3>(6 * m + of, 6 * n + by) += block;
}

}  // namespace

const Wrench& ActingMarkers::acting_wrench(const Wrench* kept, int marker) const {
  static const Wrench none{Vector3::Zero(), Vector3::Zero()};
  for (int i = 0; i < acting_; ++i)
    if (acting_on_[i] == marker) return kept[i];
  return none;
}

void perpendicular(const MarkerView& A, const Vector3& a, const MarkerView& B, const Vector3& b, ConstraintRows& rows) {
  const Vector3 n = a.cross(b);
  if (rows.stiffness()) {
    // δn = b~ a~ θ_A - a~ b~ θ_B, b~ a~ = a bᵀ - (a·b) E
    Matrix3 ba = (rows.multiplier() * a) * b.transpose();
    ba.diagonal().array() -= rows.multiplier() * a.dot(b);
    const Matrix3 ab = ba.transpose();
    ConstraintRows::Stiffness& K = *rows.stiffness();
    const int i = 6 * A.index + 3, j = 6 * B.index + 3;
    K.block<3, 3>(i, i) += ba, K.block<3, 3>(i, j) -= ab;
    K.block<3, 3>(j, i) -= ba, K.block<3, 3>(j, j) += ab;
  }
  Wrench* W = rows.open();
  W[A.index].torque = n;
  W[B.index].torque = -n;
  double bias = 0;
  if (rows.bias_wanted()) bias = (A.w.cross(a).cross(b) + a.cross(B.w.cross(b))).dot(A.w - B.w);
  rows.finish(a.dot(b), bias);
}

void in_plane(const MarkerView& A, const Vector3& a, const MarkerView& B, ConstraintRows& rows) {
  const Vector3 d = B.p - A.p, n = a.cross(d);
  if (rows.stiffness()) {
    const Matrix3 la = rows.multiplier() * skew(a);
    add(rows, A.index, 0, A.index, 3, la);
    add(rows, B.index, 0, A.index, 3, -la);
    add(rows, A.index, 3, A.index, 3, skew(d) * la);
    add(rows, A.index, 3, B.index, 0, la);
    add(rows, A.index, 3, A.index, 0, -la);
  }
  Wrench* W = rows.open();
  W[A.index] = {-a, n};
  W[B.index].force += a;
  const Vector3 a_dot = A.w.cross(a);
  rows.finish(a.dot(d), 2 * a_dot.dot(B.v - A.v) + A.w.cross(a_dot).dot(d));
}

void at_distance(const MarkerView& A, const MarkerView& B, double length, ConstraintRows& rows) {
  const Vector3 d = B.p - A.p, d_dot = B.v - A.v;
  if (rows.stiffness()) {
    const Matrix3 l = rows.multiplier() * Matrix3::Identity();
    add(rows, A.index, 0, A.index, 0, l);
    add(rows, B.index, 0, B.index, 0, l);
    add(rows, A.index, 0, B.index, 0, -l);
    add(rows, B.index, 0, A.index, 0, -l);
  }
  Wrench* W = rows.open();
  W[A.index].force = -d;
  W[B.index].force += d;
  rows.finish(0.5 * (d.squaredNorm() - length * length), d_dot.squaredNorm());
}

void at_point(const MarkerView& A, const Vector3& c, const MarkerView& B, ConstraintRows& rows) {
  const Vector3 r = A.R * c, d = B.p - A.p - r;
  const Vector3 bias = -A.w.cross(A.w.cross(r));
  for (int i = 0; i < 3; ++i) {
    const Vector3 e = Vector3::Unit(i);
    if (rows.stiffness()) add(rows, A.index, 3, A.index, 3, rows.multiplier() * skew(e) * -skew(r));
    Wrench* W = rows.open();
    W[A.index] = {-e, e.cross(r)};
    W[B.index].force += e;
    rows.finish(d[i], bias[i]);
  }
}

}  // namespace lithe
