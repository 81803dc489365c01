#include "tests/support/motion.h"

namespace lithe::test {

VectorX SmoothMotion::position(double t) const {
  VectorX out(q.size());
  layout.retract(q, VectorX(t * v + 0.5 * t * t * a), out);
  return out;
}

VectorX SmoothMotion::velocity(double t) const {
  const VectorX d = t * v + 0.5 * t * t * a;
  VectorX out = v + t * a;
  for (const auto& b : layout.bodies())
    if (b.frame) {  // omega = Jr(psi) psi_dot, and Jr = Jlᵀ
      const Vector3 rate = out.segment<3>(b.v + 3);
      out.segment<3>(b.v + 3) = left_jacobian(d.segment<3>(b.v + 3)).transpose() * rate;
    }
  return out;
}

}  // namespace lithe::test
