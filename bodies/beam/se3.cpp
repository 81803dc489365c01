#include "bodies/beam/se3_internal.h"

namespace lithe::se3 {

Vector6 log_between(const Vector3& p_A, const Matrix3& R_A, const Vector3& p_B, const Matrix3& R_B) {
  const Vector3 phi = rotation_log(R_A.transpose() * R_B), d = R_A.transpose() * (p_B - p_A);
  const Vector3 turned = phi.cross(d);
  Vector6 out;
  out << d - 0.5 * turned + chart_coefficient(phi.squaredNorm()) * phi.cross(turned), phi;
  return out;
}

}  // namespace lithe::se3
