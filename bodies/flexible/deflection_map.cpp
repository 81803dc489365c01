#include "bodies/flexible/deflection_map.h"

namespace lithe {
namespace {

using ConstVector = Eigen::Map<const VectorX>;

int pairs_of(int modes) { return modes * (modes + 1) / 2; }

/// w = ½ x xᵀ, packed.
void pack(const ConstVector& x, VectorX& w) {
  Eigen::Index p = 0;
  for (Eigen::Index l = 0; l < x.size(); ++l) {
    for (Eigen::Index k = 0; k < l; ++k) w[p++] = x[k] * x[l];
    w[p++] = 0.5 * x[l] * x[l];
  }
}

}  // namespace

DeflectionTerms::DeflectionTerms(int fields, int modes)
    : xi(VectorX::Zero(fields)),
      xi_rate(VectorX::Zero(fields)),
      xi_bias(VectorX::Zero(fields)),
      P(MatrixX::Identity(fields, modes)),
      P_rate(MatrixX::Zero(fields, modes)),
      force(VectorX::Zero(modes)),
      stiffness(MatrixX::Zero(modes, modes)),
      loaded(MatrixX::Zero(modes, modes)),
      pairs(VectorX::Zero(pairs_of(modes))),
      rate_pairs(VectorX::Zero(pairs_of(modes))),
      pair_force(VectorX::Zero(pairs_of(modes))),
      acceleration(VectorX::Zero(fields)),
      Ct(Matrix3X::Zero(3, modes)),
      Cr(Matrix3X::Zero(3, modes)),
      G_omega(Matrix3X::Zero(3, modes)),
      u(Matrix3X::Zero(3, modes)),
      Cr_rate(Matrix3X::Zero(3, modes)) {}

DeflectionMap::DeflectionMap(const QuadraticDeflection& deflection, int modes)
    : modes_(modes), curvature_(deflection.curvature.leftCols(pairs_of(modes))) {
  if (deflection.quartic.size() == 0) return;
  quartic_ = deflection.quartic.topLeftCorner(pairs_of(modes), pairs_of(modes));
}

void DeflectionMap::evaluate(const double* eta_data, const double* rate_data, Level level, DeflectionTerms& t) const {
  const ConstVector eta(eta_data, modes_), rate(rate_data, modes_);
  pack(eta, t.pairs);
  t.xi.noalias() = curvature_ * t.pairs;
  t.xi.head(modes_) += eta;
  t.P.setIdentity();
  add_pair_columns(curvature_, eta_data, t.P);
  if (level != Level::position) {
    pack(rate, t.rate_pairs);
    t.P_rate.setZero();
    add_pair_columns(curvature_, rate_data, t.P_rate);
    t.xi_rate.noalias() = t.P * rate;
    t.xi_bias.noalias() = t.P_rate * rate;
  }
  if (quartic_.size() == 0) return;

  // V = ⅙ wᵀ Q w: force ⅓ (Q w)_kl η_l, stiffness (Q w)_kl.
  t.pair_force.noalias() = quartic_ * t.pairs;
  t.force.setZero();
  t.energy = t.pairs.dot(t.pair_force) / 6;
  Eigen::Index p = 0;
  for (int l = 0; l < modes_; ++l)
    for (int k = 0; k <= l; ++k, ++p) {
      t.force[k] += t.pair_force[p] * eta[l] / 3;
      if (k != l) t.force[l] += t.pair_force[p] * eta[k] / 3;
      t.stiffness(k, l) = t.stiffness(l, k) = t.pair_force[p];
    }
}

VectorX DeflectionMap::coordinates(const VectorX& eta) const {
  VectorX w(pairs_of(modes_));
  pack(ConstVector(eta.data(), modes_), w);
  VectorX xi = curvature_ * w;
  xi.head(modes_) += eta;
  return xi;
}

void DeflectionMap::geometric_stiffness(const VectorX& force, MatrixX& stiffness) const {
  Eigen::Index p = 0;
  for (int l = 0; l < modes_; ++l)
    for (int k = 0; k <= l; ++k, ++p) {
      const double value = curvature_.col(p).dot(force);
      stiffness(k, l) = stiffness(l, k) = value;
    }
}

}  // namespace lithe
