#include "engine/assembly/batch_of.h"
#include "engine/base/checks.h"
#include "models/armature_internal.h"

namespace lithe {

Armature::Armature(Parameters parameters) : p_(parameters) {
  require::positive(p_.inertia, "armature");
  require::finite(p_.rate, "rate");
  set_marker_count(2);
}

void Armature::marker_kinematics(const BodyState& state, int marker, Level, MarkerKinematics& k) const {
  static constexpr double kAlongX[6] = {1, 0, 0, 0, 0, 0};
  const bool moves = marker == 1;
  k.p = k.r = moves ? Vector3(state.q[0], 0, 0) : Vector3(0, 0, 0);
  k.v = moves ? Vector3(state.v[0], 0, 0) : Vector3(0, 0, 0);
  k.R = Matrix3::Identity();
  k.w = k.bias_v = k.bias_w = Vector3::Zero();
  k.A = &state.cache->A;
  k.elastic = moves ? kAlongX : nullptr;
}

template std::unique_ptr<BodyBatch> make_body_batch<Armature>();

}  // namespace lithe
