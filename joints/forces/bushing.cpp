#include "joints/forces/bushing.h"

#include <Eigen/Eigenvalues>

#include "engine/assembly/batch_of.h"
#include "engine/base/checks.h"
#include "engine/base/dense.h"

namespace lithe {

namespace {

Vector6 deformation(const MarkerView& A, const MarkerView& B) {
  Vector6 e;
  e << A.R.transpose() * (B.p - A.p), rotation_log(A.R.transpose() * B.R);
  return e;
}

void require_semidefinite(const Matrix6& M, const std::string& name) {
  require::finite(Eigen::Map<const VectorX>(M.data(), 36), name);
  const double size = M.cwiseAbs().maxCoeff();
  if ((M - M.transpose()).cwiseAbs().maxCoeff() > 1e-9 * size)
    throw SceneError(name + " is not symmetric", "", "give a symmetric 6 x 6 matrix");
  const double lowest = Eigen::SelfAdjointEigenSolver<MatrixX>(MatrixX(M)).eigenvalues()[0];
  if (lowest < -1e-9 * size)
    throw SceneError(name + " has the eigenvalue " + std::to_string(lowest) + ": it would give energy", "",
                     "give a positive semidefinite 6 x 6 matrix");
}

}  // namespace

Matrix6 Bushing::diagonal(const Vector3& translation, const Vector3& rotation) {
  Vector6 all;
  all << translation, rotation;
  return all.asDiagonal();
}

Bushing::Bushing(Parameters parameters) : relaxed_as_drawn_(parameters.relaxed_as_drawn) {
  require_semidefinite(parameters.stiffness, "stiffness");
  require_semidefinite(parameters.damping, "damping");
  // On the range of K + D, scaled to E there, K is turned to its axes.
  const Eigen::SelfAdjointEigenSolver<MatrixX> sum(MatrixX(parameters.stiffness + parameters.damping));
  const Vector6 size = sum.eigenvalues().cwiseMax(0);
  const double least = 1e-14 * size[5];
  Vector6 root = Vector6::Zero(), inverse_root = Vector6::Zero();
  for (int i = 0; i < 6; ++i)
    if (size[i] > least) root[i] = std::sqrt(size[i]), inverse_root[i] = 1 / root[i];
  const Matrix6 U = sum.eigenvectors();
  const Matrix6 scaled =
      inverse_root.asDiagonal() * U.transpose() * parameters.stiffness * U * inverse_root.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<MatrixX> turned(MatrixX(0.5 * (scaled + scaled.transpose())));
  rows_ = turned.eigenvectors().transpose() * root.asDiagonal() * U.transpose();
  stiffness_ = turned.eigenvalues().cwiseMax(0).cwiseMin(1);
  damping_ = Vector6::Ones() - stiffness_;
}

void Bushing::evaluate(double, std::span<const MarkerView> markers, ForceRows& rows) const {
  const auto &A = markers[0], &B = markers[1];
  const Vector3 d = B.p - A.p;
  const Vector6 e = deformation(A, B);
  // φ̇ = Jl⁻¹(φ) R_Aᵀ (w_B - w_A), and Jl⁻¹ is the transpose of Jr⁻¹.
  const Matrix3 turn = A.R * right_jacobian_inverse(e.tail<3>());
  Vector6 e_dot;
  e_dot << A.R.transpose() * (B.v - A.v - A.w.cross(d)), turn.transpose() * (B.w - A.w);
  for (int i = 0; i < 6; ++i) {
    const Vector3 F = A.R * rows_.row(i).head<3>().transpose(), T = turn * rows_.row(i).tail<3>().transpose();
    const double stretch = rows_.row(i).dot(e - offset_), speed = rows_.row(i).dot(e_dot);
    rows.add({{-F, -d.cross(F) - T}, {F, T}}, stiffness_[i] * stretch + damping_[i] * speed, stiffness_[i], damping_[i],
             0.5 * stiffness_[i] * stretch * stretch);
  }
}

void Bushing::initialize(std::span<const MarkerView> m) {
  if (relaxed_as_drawn_) offset_ = deformation(m[0], m[1]);
}

template std::unique_ptr<ForceBatch> make_force_batch<Bushing>();

}  // namespace lithe
