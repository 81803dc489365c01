#include "bodies/beam/span_field_internal.h"

namespace lithe {
namespace {

using Matrix6x12 = SpanField::Matrix6x12;

/// ad(y): [w~, v~; 0, w~].
se3::Blocks bracket(const Vector6& y) { return {skew(Vector3(y.tail<3>())), skew(Vector3(y.head<3>()))}; }

/// How [F, G; 0, F] itself changes along z: its columns are ∂(… e_i) z.
Matrix6 change(const se3::Analytic& c, const Vector6& d, const Vector6& z) {
  Matrix6 out;
  for (int i = 0; i < 6; ++i) out.col(i) = se3::rates(c, d, Vector6::Unit(i)) * z;
  return out;
}

}  // namespace

SpanField::SpanField(double xi, const Vector6& d)
    : xi_(xi),
      d_(d),
      along_(xi * d),
      right_(se3::right_at(along_)),
      inverse_(se3::right_inverse_at(d)),
      here_(se3::exp(along_)) {
  const Matrix3 back = here_.R.transpose();
  carry_ = se3::Blocks{back, -back * skew(here_.p)}.matrix();
  T_ = xi * se3::blocks(right_, along_).matrix();
  const se3::Blocks inverse = se3::blocks(inverse_, d);
  P_ << -inverse.turned_back().matrix(), inverse.matrix();
  N_.noalias() = T_ * P_;
  N_.leftCols<6>() += carry_;
}

Vector6 SpanField::bias(const Vector12& v) const {
  const Vector6 v_A = v.head<6>(), v_B = v.tail<6>(), rate = P_ * v, y = carry_ * v_A;
  const Vector6 inner = se3::rates(inverse_, d_, v_B) * rate + se3::rates(inverse_, -d_, v_A) * rate;
  return bracket(y) * (T_ * rate) + (xi_ * xi_) * (se3::rates(right_, along_, rate) * rate) + T_ * inner;
}

Matrix6x12 SpanField::bias_rates(const Vector12& v) const {
  const Vector6 v_A = v.head<6>(), v_B = v.tail<6>(), rate = P_ * v, y = carry_ * v_A;
  const Matrix6 inner = se3::rates(inverse_, d_, v_B).matrix() + se3::rates(inverse_, -d_, v_A).matrix();
  const Matrix6 outer = se3::rates(right_, along_, rate).matrix() + change(right_, along_, rate);
  Matrix6x12 out = (bracket(y).matrix() * T_ + (xi_ * xi_) * outer + T_ * inner) * P_;
  out.leftCols<6>() += T_ * change(inverse_, -d_, rate) - bracket(T_ * rate).matrix() * carry_;
  out.rightCols<6>() += T_ * change(inverse_, d_, rate);
  return out;
}

}  // namespace lithe
