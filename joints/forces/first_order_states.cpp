#include "joints/forces/first_order_states.h"
#include "engine/assembly/batch_of.h"

namespace lithe {

FirstOrderStates::FirstOrderStates(Parameters parameters) : start_(std::move(parameters.start)) {
  set_marker_count(point_count());
}

void FirstOrderStates::initial_state(VectorRef q, VectorRef v) const {
  q.setZero(), v.setZero();
  for (int i = 0; i < point_count(); ++i) q[7 * i + 3] = 1;  // axes as the world's, for good
  for (int i = 0; i < start_.size(); ++i) v[place(i)] = start_[i];
}

void FirstOrderStates::add_residual(const BodyState&, const double* v_dot, const Vector3&, double* r) const {
  for (int i = 0; i < 6 * point_count(); ++i) r[i] += v_dot[i];
}

void FirstOrderStates::add_tangent(const BodyState&, const double*, const Vector3&, const TangentWeights& weights,
                                   BodyTangent& S) const {
  for (int i = 0; i < point_count(); ++i) S.frame_block(i).diagonal().array() += weights.acceleration;
}

void FirstOrderStates::marker_kinematics(const BodyState& state, int marker, Level level, MarkerKinematics& k) const {
  k.A = &state.cache->A;
  k.elastic = nullptr;
  k.deflected = nullptr;
  k.between = nullptr;
  k.frame = marker;
  k.r.setZero();
  k.p.setZero();  // of no meaning, and far from bodies: differences take steps of distances between markers
  k.R.setIdentity();
  if (level == Level::position) return;
  k.v = Eigen::Map<const Vector3>(state.v + 6 * marker);
  k.w.setZero();
  if (level == Level::velocity) return;
  k.bias_v.setZero();
  k.bias_w.setZero();
}

template std::unique_ptr<BodyBatch> make_body_batch<FirstOrderStates>();

}  // namespace lithe
