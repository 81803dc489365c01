#include "engine/base/rotations.h"

#include "engine/base/checks.h"

namespace lithe {

Matrix3 rotation_from_euler_313(double precession, double nutation, double spin) {
  const Vector3 x = Vector3::UnitX(), z = Vector3::UnitZ();
  return rotation_about(z, precession) * rotation_about(x, nutation) * rotation_about(z, spin);
}

Matrix3 rotation_from_euler_321(double yaw, double pitch, double roll) {
  return rotation_about(Vector3::UnitZ(), yaw) * rotation_about(Vector3::UnitY(), pitch) *
         rotation_about(Vector3::UnitX(), roll);
}

Matrix3 nearest_rotation(const Matrix3& printed) {
  constexpr double kPrinted = 1e-4;  // five digits round by 5e-6 an entry
  constexpr int kIterations = 3;     // of an error squared each time: 1e-4, 1e-8, 1e-16
  require::finite(printed.reshaped(), "the rotation matrix");
  const double off = (printed.transpose() * printed - Matrix3::Identity()).cwiseAbs().maxCoeff();
  if (off > kPrinted)
    throw SceneError(
        "a matrix is not a rotation: its columns depart from unit length and right angles by " + std::to_string(off),
        "nearest_rotation", "print it with five digits or more; columns are the rotated axes, without scale");
  if (printed.determinant() < 0)
    throw SceneError("a matrix is left-handed: it mirrors", "nearest_rotation",
                     "give right-handed axes: the third column is the first times the second");
  // Newton's iteration to the polar factor, X ← ½ (X + X⁻ᵀ); the columns of X⁻ᵀ are cross products over det X.
  Matrix3 X = printed;
  for (int i = 0; i < kIterations; ++i) {
    Matrix3 cofactors;
    cofactors << X.col(1).cross(X.col(2)), X.col(2).cross(X.col(0)), X.col(0).cross(X.col(1));
    X = (0.5 * (X + cofactors / X.col(0).dot(cofactors.col(0)))).eval();
  }
  return X;
}

Matrix3 axes_along(const Vector3& z, const Vector3& x) {
  const auto direction = [](const Vector3& v, const std::string& which) -> Vector3 {
    require::finite(v, which);
    if (v.stableNorm() == 0)
      throw SceneError(which + " has no direction: it is zero", "axes_along", "give a vector of any length but zero");
    return v.stableNormalized();
  };
  Matrix3 axes;
  axes.col(2) = direction(z, "the axis z");
  Vector3 near;
  if (x == Vector3::Zero()) {
    int farthest = 0;
    axes.col(2).cwiseAbs().minCoeff(&farthest);
    near = Vector3::Unit(farthest);
  } else {
    near = direction(x, "the axis x");
  }
  const Vector3 across = near - axes.col(2).dot(near) * axes.col(2);
  if (across.norm() < 1e-6)
    throw SceneError("the axis x points along z", "axes_along", "give an x at an angle to z, or none");
  axes.col(0) = across.normalized();
  axes.col(1) = axes.col(2).cross(axes.col(0));
  return axes;
}

}  // namespace lithe
