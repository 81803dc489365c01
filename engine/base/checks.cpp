#include "engine/base/checks.h"

#include <Eigen/Eigenvalues>

namespace lithe::require {
namespace {

[[noreturn]] void fail(const std::string& what, const std::string& fix) { throw SceneError(what, "", fix); }

}  // namespace

void finite(double value, const std::string& parameter) {
  if (!std::isfinite(value)) fail(parameter + " is " + std::to_string(value), "give a finite number in SI units");
}

void finite(ConstVectorRef value, const std::string& parameter) {
  for (double x : value) finite(x, parameter);
}

void positive(double value, const std::string& parameter) {
  finite(value, parameter);
  if (value <= 0) fail(parameter + " is " + std::to_string(value), "give a value above zero, in SI units");
}

void not_negative(double value, const std::string& parameter) {
  finite(value, parameter);
  if (value < 0) fail(parameter + " is " + std::to_string(value), "give zero or a positive value, in SI units");
}

void rotation(const Matrix3& value, const std::string& parameter) {
  if (!value.allFinite()) fail(parameter + " holds NaN or infinity", "give a rotation matrix");
  const double off = (value.transpose() * value - Matrix3::Identity()).cwiseAbs().maxCoeff();
  if (off > 1e-9 || value.determinant() < 0)
    fail(parameter + " is not a rotation matrix (|RᵀR - E| = " + std::to_string(off) + ", det " +
             std::to_string(value.determinant()) + ")",
         "build it with rotation_about(axis, angle), or orthonormalise its columns, right-handed");
}

void inertia(const Matrix3& value, const std::string& parameter) {
  if (!value.allFinite()) fail(parameter + " holds NaN or infinity", "give finite moments of inertia, kg m²");
  const double scale = value.cwiseAbs().maxCoeff();
  if ((value - value.transpose()).cwiseAbs().maxCoeff() > 1e-12 * scale)
    fail(parameter + " is not symmetric", "give J with J_ij = J_ji (products of inertia carry a minus sign)");
  const Vector3 principal = Eigen::SelfAdjointEigenSolver<Matrix3>(value, Eigen::EigenvaluesOnly).eigenvalues();
  if (!(principal[0] > 0))
    fail(parameter + " has the principal moment " + std::to_string(principal[0]),
         "every principal moment of inertia must be above zero");
  if (principal[2] > (principal[0] + principal[1]) * (1 + 1e-9))
    fail(parameter + " is of no real body: one principal moment exceeds the sum of the others",
         "check units and that the moments are about the centre of mass");
}

}  // namespace lithe::require
