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

Vector6 rate_without_acceleration(const Vector6& twist) {
  Vector6 rate;
  rate << -twist.tail<3>().cross(twist.head<3>()), Vector3::Zero();
  return rate;
}

Matrix6 gyroscopic(const Matrix6& mass, const Vector6& twist) {
  Matrix6 G = Matrix6::Zero();
  if (twist.isZero(0)) return G;
  const auto force = [&](const Vector6& v) { return inertia_force(mass, v, rate_without_acceleration(v)); };
  for (int i = 0; i < 6; ++i)  // quadratic in the twist: differences have no error but round-off
    G.col(i) = 0.5 * (force(twist + Vector6::Unit(i)) - force(twist - Vector6::Unit(i)));
  return G;
}

}  // namespace lithe::rigid_piece
