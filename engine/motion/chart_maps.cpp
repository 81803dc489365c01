#include "engine/motion/chart_maps.h"

namespace lithe {

void ChartMaps::at(const Layout& layout, const VectorX& d) {
  frames_.clear();
  for (const Layout::BodySlice& b : layout.bodies()) {
    if (!b.frame) continue;
    const Vector3 psi = d.segment<3>(b.v + 3);
    frames_.push_back({b.v + 3, rotation_exp(-psi), left_jacobian(psi).transpose(), right_jacobian_inverse(psi)});
  }
}

void ChartMaps::apply(Matrix3 Frame::*map, bool transposed, MatrixX& columns) const {
  for (const Frame& frame : frames_) {
    auto block = columns.middleRows<3>(frame.rotation);
    const Matrix3 A = transposed ? Matrix3((frame.*map).transpose()) : frame.*map;
    block = (A * block).eval();
  }
}

Vector3 right_jacobian_change(const Vector3& psi, const Vector3& by, const Vector3& x) {
  constexpr double h = 1e-3;
  const auto at = [&](double steps) -> Vector3 { return left_jacobian(-(psi + steps * h * by)) * x; };
  return (8 * (at(1) - at(-1)) - (at(2) - at(-2))) / (12 * h);
}

/// By v: Jr⁻ᵀ wanted; by ψ: δḋ = -Jr⁻¹ (δJr) ḋ.
void add_chart_rate_products(const Layout& layout, const VectorX& d, const VectorX& v, const MatrixX& wanted,
                             MatrixX& of_d, MatrixX& of_v) {
  for (const auto& b : layout.bodies()) {
    const int turn = b.v + 3, linear = b.v + (b.frame ? 6 : 0);
    if (b.frame) {
      const Vector3 psi = d.segment<3>(turn), omega = v.segment<3>(turn);
      const Matrix3 inverse = right_jacobian_inverse(psi);
      const Vector3 rate = inverse * omega;
      of_v.middleRows(b.v, 3) += wanted.middleRows(b.v, 3);
      of_v.middleRows(turn, 3) += inverse.transpose() * wanted.middleRows(turn, 3);
      Matrix3 by_psi;
      for (int k = 0; k < 3; ++k) by_psi.col(k) = -inverse * right_jacobian_change(psi, Vector3::Unit(k), rate);
      of_d.middleRows(turn, 3) += by_psi.transpose() * wanted.middleRows(turn, 3);
    }
    of_v.middleRows(linear, b.linear) += wanted.middleRows(linear, b.linear);
  }
}

}  // namespace lithe
