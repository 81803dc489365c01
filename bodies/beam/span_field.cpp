#include "bodies/beam/span_field_internal.h"

namespace lithe {
namespace {

using Matrix6x12 = SpanField::Matrix6x12;

Matrix6 whole(const Matrix3& F, const Matrix3& G) {
  Matrix6 M;
  M << F, G, Matrix3::Zero(), F;
  return M;
}
Matrix6 whole(const se3::Rates& r) { return whole(r.D, r.E); }

/// ad(y): [w~, v~; 0, w~].
Matrix6 bracket(const Vector6& y) { return whole(skew(Vector3(y.tail<3>())), skew(Vector3(y.head<3>()))); }

/// How [F, G; 0, F] itself changes along z: its columns are ∂(… e_i) z.
Matrix6 change(const se3::Analytic& c, const Vector6& d, const Vector6& z) {
  Matrix6 out;
  for (int i = 0; i < 6; ++i) out.col(i) = whole(se3::rates(c, d, Vector6::Unit(i))) * z;
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
  carry_ = whole(back, -back * skew(here_.p));
  const auto [F, G] = se3::blocks(right_, along_);
  T_ = xi * whole(F, G);
  const auto [F_inverse, G_inverse] = se3::blocks(inverse_, d);
  P_ << -whole(F_inverse.transpose(), G_inverse.transpose()), whole(F_inverse, G_inverse);
  N_.noalias() = T_ * P_;
  N_.leftCols<6>() += carry_;
}

Vector6 SpanField::bias(const Vector12& v) const {
  const Vector6 v_A = v.head<6>(), v_B = v.tail<6>(), rate = P_ * v, y = carry_ * v_A;
  const Vector6 inner = whole(se3::rates(inverse_, d_, v_B)) * rate + whole(se3::rates(inverse_, -d_, v_A)) * rate;
  return bracket(y) * (T_ * rate) + (xi_ * xi_) * (whole(se3::rates(right_, along_, rate)) * rate) + T_ * inner;
}

Matrix6x12 SpanField::bias_rates(const Vector12& v) const {
  const Vector6 v_A = v.head<6>(), v_B = v.tail<6>(), rate = P_ * v, y = carry_ * v_A;
  const Matrix6 inner = whole(se3::rates(inverse_, d_, v_B)) + whole(se3::rates(inverse_, -d_, v_A));
  const Matrix6 outer = whole(se3::rates(right_, along_, rate)) + change(right_, along_, rate);
  Matrix6x12 out = (bracket(y) * T_ + (xi_ * xi_) * outer + T_ * inner) * P_;
  out.leftCols<6>() += T_ * change(inverse_, -d_, rate) - bracket(T_ * rate) * carry_;
  out.rightCols<6>() += T_ * change(inverse_, d_, rate);
  return out;
}

}  // namespace lithe
