#include "bodies/flexible/flexible_inertia.h"

namespace lithe {
namespace {

using ConstVector = Eigen::Map<const VectorX>;

Matrix3 full(const Vector6& s) {
  Matrix3 J;
  J << s[0], s[3], s[4], s[3], s[1], s[5], s[4], s[5], s[2];
  return J;
}

}  // namespace

InertiaTerms::InertiaTerms(int modes)
    : Cr(Matrix3X::Zero(3, modes)),
      quadratic(VectorX::Zero(modes)),
      G_omega(Matrix3X::Zero(3, modes)),
      u(Matrix3X::Zero(3, modes)),
      Cr_rate(Matrix3X::Zero(3, modes)),
      modal_scratch(VectorX::Zero(6 * modes)) {}

ModalInertia::ModalInertia(InertiaIntegrals integrals) : I_(std::move(integrals)) {
  mass = I_.mass;
  Ct = I_.Ct;
}

void ModalInertia::evaluate(const double* eta_data, const double* rate_data, const Vector3& w, Level level,
                            InertiaTerms& t) const {
  const int nm = I_.mode_count();
  const ConstVector eta(eta_data, nm), rate(rate_data, nm);
  // ∂J/∂η_k = G_k = J1_k + 2 η_l J2_kl, as 6-vectors; J = J0 + ½ η_k (J1_k + G_k).
  Eigen::Map<VectorX> G(t.modal_scratch.data(), 6 * nm);
  const ConstVector J1(I_.J1.data(), 6 * nm);
  G = J1;
  G.noalias() += 2 * (I_.J2 * eta);
  const Eigen::Map<const Matrix6X> Gk(G.data(), 6, nm);

  t.s = I_.s0;
  t.s.noalias() += Ct * eta;
  Vector6 J = I_.J0;
  for (int k = 0; k < nm; ++k) J += 0.5 * eta[k] * (I_.J1.col(k) + Gk.col(k));
  t.J = full(J);
  Eigen::Map<VectorX> Cr(t.Cr.data(), 3 * nm);
  Cr = ConstVector(I_.C0.data(), 3 * nm);
  if (I_.antisymmetric) {
    Cr.noalias() -= I_.C1 * eta;  // η_k C1_k e_l = -C1_l η
  } else {
    for (int l = 0; l < nm; ++l)
      for (int k = 0; k < nm; ++k) t.Cr.col(l) += eta[k] * I_.C1.block<3, 1>(3 * k, l);
  }
  if (level == Level::position) return;

  t.s_rate.noalias() = Ct * rate;
  Vector6 J_rate = Vector6::Zero();
  for (int k = 0; k < nm; ++k) J_rate += rate[k] * Gk.col(k);
  t.J_rate = full(J_rate);
  t.h.noalias() = t.Cr * rate;
  Eigen::Map<VectorX>(t.u.data(), 3 * nm).noalias() = I_.C1 * rate;
  if (I_.antisymmetric) {
    t.Cr_rate = -t.u;
  } else {
    t.Cr_rate.setZero();
    for (int l = 0; l < nm; ++l)
      for (int k = 0; k < nm; ++k) t.Cr_rate.col(l) += rate[k] * I_.C1.block<3, 1>(3 * k, l);
    t.Cr_rate_h.noalias() = t.Cr_rate * rate;
  }
  for (int k = 0; k < nm; ++k) {
    const double* g = Gk.data() + 6 * k;
    Vector3 gw(g[0] * w[0] + g[3] * w[1] + g[4] * w[2], g[3] * w[0] + g[1] * w[1] + g[5] * w[2],
               g[4] * w[0] + g[5] * w[1] + g[2] * w[2]);
    t.G_omega.col(k) = gw;
    t.quadratic[k] = w.dot(0.5 * gw + t.u.col(k) - t.Cr_rate.col(k));
  }
}

NodalInertia::NodalInertia(std::shared_ptr<const ModalBasis> basis) : basis_(std::move(basis)) {
  const VectorX rows = basis_->nodal_mass * VectorX::Ones(basis_->nodal_mass.cols());
  mass = rows.sum();
  const auto& free = basis_->free_dofs;
  Ct.setZero(3, static_cast<int>(free.size()));
  for (std::size_t k = 0; k < free.size(); ++k) Ct(free[k] % 3, static_cast<int>(k)) = rows[free[k] / 3];
}

void NodalInertia::evaluate(const double* eta, const double* rate, const Vector3& w, Level level,
                            InertiaTerms& t) const {
  const auto& free = basis_->free_dofs;
  const auto& m = basis_->nodal_mass;
  const int n = static_cast<int>(m.rows());
  if (t.r.rows() != n) t.r.resize(n, 3), t.u_nodal.setZero(n, 3), t.mr.resize(n, 3), t.mu.resize(n, 3);  // once
  t.r = basis_->nodes.transpose();
  for (std::size_t k = 0; k < free.size(); ++k) {
    t.r(free[k] / 3, free[k] % 3) += eta[k];
    t.u_nodal(free[k] / 3, free[k] % 3) = rate[k];
  }
  t.mr.noalias() = m * t.r;
  const Matrix3 D = t.r.transpose() * t.mr;
  t.s = t.mr.colwise().sum();
  t.J = D.trace() * Matrix3::Identity() - D;
  for (std::size_t k = 0; k < free.size(); ++k)
    t.Cr.col(k) = Vector3(t.mr.row(free[k] / 3)).cross(Vector3::Unit(free[k] % 3));
  if (level == Level::position) return;

  t.mu.noalias() = m * t.u_nodal;
  const Matrix3 D_rate = t.u_nodal.transpose() * t.mr + t.r.transpose() * t.mu;
  t.s_rate = t.mu.colwise().sum();
  t.J_rate = D_rate.trace() * Matrix3::Identity() - 0.5 * (D_rate + D_rate.transpose());
  t.h.setZero();
  for (int i = 0; i < n; ++i) t.h += Vector3(t.mr.row(i)).cross(Vector3(t.u_nodal.row(i)));
  for (std::size_t k = 0; k < free.size(); ++k) {
    const int i = free[k] / 3, a = free[k] % 3;
    const Vector3 e = Vector3::Unit(a), p = t.mr.row(i), p_rate = t.mu.row(i);
    t.quadratic[k] = -(w.cross(w.cross(p)) + 2 * w.cross(p_rate))[a];
    t.G_omega.col(k) = 2 * p[a] * w - p.dot(w) * e - w[a] * p;
    t.u.col(k) = e.cross(p_rate);
  }
  t.Cr_rate = -t.u;
}

}  // namespace lithe
