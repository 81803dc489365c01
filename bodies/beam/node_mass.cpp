#include "bodies/beam/node_mass_internal.h"

namespace lithe::rigid_piece {

Vector6 inertia_force(const Matrix6& mass, const Vector6& twist, const Vector6& rate) {
  const Vector6 momentum = mass * twist;
  const Vector3 v = twist.head<3>(), w = twist.tail<3>(), p = momentum.head<3>(), l = momentum.tail<3>();
  Vector6 f = mass * rate;
  f.head<3>() += w.cross(p);
  f.tail<3>() += w.cross(l) + v.cross(p);
  return f;
}

Matrix6 rate_by_twist(const Vector6& twist) {
  Matrix6 R = Matrix6::Zero();
  R.topLeftCorner<3, 3>() = -skew(Vector3(twist.tail<3>()));
  R.topRightCorner<3, 3>() = skew(Vector3(twist.head<3>()));
  return R;
}

Matrix6 momentum_rates(const Matrix6& mass, const Vector6& twist) {
  const Vector6 momentum = mass * twist;
  const Matrix3 v = skew(Vector3(twist.head<3>())), w = skew(Vector3(twist.tail<3>()));
  const Matrix3 p = skew(Vector3(momentum.head<3>())), l = skew(Vector3(momentum.tail<3>()));
  Matrix6 R;
  R.topRows<3>().noalias() = w * mass.topRows<3>();
  R.bottomRows<3>() = w * mass.bottomRows<3>() + v * mass.topRows<3>();
  R.topRightCorner<3, 3>() -= p;
  R.bottomLeftCorner<3, 3>() -= p;
  R.bottomRightCorner<3, 3>() -= l;
  return R;
}

Matrix6 gyroscopic(const Matrix6& mass, const Vector6& twist) {
  if (twist.isZero(0)) return Matrix6::Zero();
  return mass * rate_by_twist(twist) + momentum_rates(mass, twist);
}

}  // namespace lithe::rigid_piece
