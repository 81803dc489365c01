#pragma once

#include "bodies/rigid_body.h"
#include "tools/stability/bench.h"

namespace lithe::lab {

/// A free body without gravity, of 1 kg, with principal moments (kg m²) and angular velocity (body axes, rad/s).
class FreeBody : public Bench {
 public:
  FreeBody(const Vector3& inertia, const Vector3& omega)
      : Bench(Vector3::Zero(), [&](SystemGraph& graph) {
          graph.add<RigidBody>("body", {.mass = 1, .inertia = inertia, .angular_velocity = omega});
        }) {}
};

/// ω̇ of a body with principal moments.
inline Vector3 euler_rates(const Vector3& I, const Vector3& w) {
  return {(I[1] - I[2]) * w[1] * w[2] / I[0], (I[2] - I[0]) * w[2] * w[0] / I[1], (I[0] - I[1]) * w[0] * w[1] / I[2]};
}
/// ė = ½ e ∘ (0, ω).
inline Vector4 quaternion_rates(const Vector4& e, const Vector3& w) {
  return 0.5 * quaternion_product(e, Vector4(0, w[0], w[1], w[2]));
}

}  // namespace lithe::lab
