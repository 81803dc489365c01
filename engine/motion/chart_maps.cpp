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

}  // namespace lithe
