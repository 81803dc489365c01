#include "bodies/flexible/flexible_inertia.h"

#include "engine/base/lanes.h"

namespace lithe {
namespace {

using ConstVector = Eigen::Map<const VectorX>;

/// A symmetric matrix as (xx yy zz xy xz yz).
struct Six {
  Lanes four = lanes::none();
  lanes::Pair two{0, 0};

  Six() = default;
  explicit Six(const double* x) : four(lanes::load4(x)), two{x[4], x[5]} {}
  void add(double factor, const Six& x) { four += factor * x.four, two += factor * x.two; }
  void write(Matrix3& J) const { J << four[0], four[3], two[0], four[3], four[1], two[1], two[0], two[1], four[2]; }
};

}  // namespace

InertiaTerms::InertiaTerms(int modes)
    : Cr(Matrix3X::Zero(3, modes)),
      quadratic(VectorX::Zero(modes)),
      G_omega(Matrix3X::Zero(3, modes)),
      G_omega_dot(Matrix3X::Zero(3, modes)),
      u(Matrix3X::Zero(3, modes)),
      Cr_rate(Matrix3X::Zero(3, modes)),
      slopes(VectorX::Zero(6 * modes)) {}

ModalInertia::ModalInertia(InertiaIntegrals integrals) : I_(std::move(integrals)) {
  mass = I_.mass;
  Ct = I_.Ct;
}

void ModalInertia::evaluate(const double* eta_data, const double* rate_data, const Vector3& w, Level level,
                            InertiaTerms& t) const {
  using namespace lanes;
  const int nm = I_.mode_count();
  const ConstVector eta(eta_data, nm), rate(rate_data, nm);
  // ∂J/∂η_k = G_k = J1_k + 2 η_l J2_kl, as 6-vectors; J = J0 + ½ η_k (J1_k + G_k).
  t.slopes = ConstVector(I_.J1.data(), 6 * nm);
  t.slopes.noalias() += 2 * (I_.J2 * eta);
  const double *ct = Ct.data(), *j1 = I_.J1.data(), *g = t.slopes.data();
  Lanes first = load3(I_.s0.data());
  Six J(I_.J0.data());
  for (int k = 0; k < nm; ++k) {
    first += eta[k] * load3(ct + 3 * k);
    J.add(0.5 * eta[k], Six(j1 + 6 * k));
    J.add(0.5 * eta[k], Six(g + 6 * k));
  }
  store3(first, t.s.data());
  J.write(t.J);
  // Cr = C0 + η_k C1_k, Ċr = η̇_k C1_k.
  const bool moving = level != Level::position;
  t.Cr = I_.C0;
  if (moving) t.Cr_rate.setZero();
  if (!I_.antisymmetric) {
    for (int l = 0; l < nm; ++l)
      for (int k = 0; k < nm; ++k) {
        t.Cr.col(l) += eta[k] * I_.C1.block<3, 1>(3 * k, l);
        if (moving) t.Cr_rate.col(l) += rate[k] * I_.C1.block<3, 1>(3 * k, l);
      }
  } else {  // C1_k e_l = -C1_l e_k
    Eigen::Map<VectorX>(t.Cr.data(), 3 * nm).noalias() -= I_.C1 * eta;
    if (moving) Eigen::Map<VectorX>(t.Cr_rate.data(), 3 * nm).noalias() -= I_.C1 * rate;
  }
  if (!moving) return;

  Lanes first_rate = none(), h = none();
  Six J_rate;
  for (int k = 0; k < nm; ++k) {
    first_rate += rate[k] * load3(ct + 3 * k);
    h += rate[k] * load3(t.Cr.data() + 3 * k);
    J_rate.add(rate[k], Six(g + 6 * k));
  }
  store3(first_rate, t.s_rate.data());
  store3(h, t.h.data());
  J_rate.write(t.J_rate);
  if (I_.antisymmetric) {
    t.u = -t.Cr_rate;
  } else {
    Eigen::Map<VectorX>(t.u.data(), 3 * nm).noalias() = I_.C1 * rate;
    t.Cr_rate_h.noalias() = t.Cr_rate * rate;
  }
  inertia_slopes(t, w, t.G_omega);
  const Lanes omega = of(w);
  for (int k = 0; k < nm; ++k)
    t.quadratic[k] =
        dot(omega, 0.5 * load3(t.G_omega.data() + 3 * k) + load3(t.u.data() + 3 * k) - load3(t.Cr_rate.data() + 3 * k));
}

void ModalInertia::inertia_slopes(const InertiaTerms& t, const Vector3& x, Matrix3X& columns) const {
  using namespace lanes;
  // G x of G = (xx yy zz xy xz yz), row by row: three products each.
  const Lanes a = of(x), b = of(x[1], x[0], x[0]), c = of(x[2], x[2], x[1]);
  const double* g = t.slopes.data();
  double* to = columns.data();
  for (int k = 0; k < I_.mode_count(); ++k, g += 6, to += 3) {
    const Lanes sides = load3(g + 3);
    store3(a * load3(g) + b * __builtin_shufflevector(sides, sides, 0, 0, 1, 3) +
               c * __builtin_shufflevector(sides, sides, 1, 2, 2, 3),
           to);
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
    t.u.col(k) = e.cross(p_rate);
  }
  t.Cr_rate = -t.u;
  inertia_slopes(t, w, t.G_omega);
}

void NodalInertia::inertia_slopes(const InertiaTerms& t, const Vector3& x, Matrix3X& columns) const {
  const auto& free = basis_->free_dofs;
  for (std::size_t k = 0; k < free.size(); ++k) {
    const int a = free[k] % 3;
    const Vector3 p = t.mr.row(free[k] / 3);
    columns.col(k) = 2 * p[a] * x - p.dot(x) * Vector3::Unit(a) - x[a] * p;
  }
}

}  // namespace lithe
