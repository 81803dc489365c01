#include "engine/model/scalar_body.h"

namespace lithe {

void ScalarBody::marker_kinematics(const BodyState& state, int marker, Level, MarkerKinematics& k) const {
  static constexpr double kAlongX[6] = {1, 0, 0, 0, 0, 0};
  const bool moves = marker == 1;
  k.p = k.r = moves ? Vector3(state.q[0], 0, 0) : Vector3(0, 0, 0);
  k.v = moves ? Vector3(state.v[0], 0, 0) : Vector3(0, 0, 0);
  k.R = Matrix3::Identity();
  k.w = k.bias_v = k.bias_w = Vector3::Zero();
  k.A = &state.cache->A;
  k.elastic = moves ? kAlongX : nullptr;
}

}  // namespace lithe
