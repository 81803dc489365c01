#include "tests/support/marker_body.h"

#include <utility>

#include "engine/base/checks.h"

namespace lithe::test {

Vector3 ModalMarker::point(const VectorX& eta) const { return c + Bm * eta; }
Matrix3 ModalMarker::orientation(const VectorX& eta) const { return rotation_exp(Theta * eta) * R0; }

MarkerBody::Cache::Cache(const MarkerBody& body)
    : elastic(body.parameters_.markers.size(), Matrix6X(6, body.modes())) {}

MarkerBody::MarkerBody(Parameters parameters) : parameters_(std::move(parameters)) {
  require::rotation(parameters_.orientation, "orientation");
  set_marker_count(static_cast<int>(parameters_.markers.size()));
  for (const ModalMarker& m : parameters_.markers) require::rotation(m.R0, "R0");
}

std::unique_ptr<BodyCache> MarkerBody::make_cache() const { return std::make_unique<Cache>(*this); }

void MarkerBody::initial_state(VectorRef q, VectorRef v) const {
  q << parameters_.position, quaternion_of(parameters_.orientation), parameters_.eta;
  v.setZero();
}

void MarkerBody::evaluate(const BodyState& state, Level) const {
  auto& cache = static_cast<Cache&>(*state.cache);
  cache.A = rotation_matrix(Eigen::Map<const Vector4>(state.q + 3));
  for (int i = 0; i < marker_count(); ++i) {
    const ModalMarker& m = parameters_.markers[i];
    cache.elastic[i].topRows<3>() = m.Bm;
    cache.elastic[i].bottomRows<3>() = left_jacobian(m.Theta * eta(state)) * m.Theta;
  }
}

void MarkerBody::add_residual(const BodyState&, const double* v_dot, const Vector3& gravity, double* r) const {
  for (int i = 0; i < 6 + modes(); ++i) r[i] += v_dot[i];
  Eigen::Map<Vector3>(r) -= gravity;
}

void MarkerBody::add_tangent(const BodyState&, const double*, const Vector3&, const TangentWeights& weights,
                             BodyTangent& S) const {
  S.frame.diagonal().array() += weights.acceleration;
  S.linear.array() += weights.acceleration;
}

void MarkerBody::marker_kinematics(const BodyState& state, int marker, Level level, MarkerKinematics& k) const {
  const auto& cache = static_cast<const Cache&>(*state.cache);
  const ModalMarker& m = parameters_.markers[marker];
  const Matrix6X& elastic = cache.elastic[marker];
  const Vector3 phi = m.Theta * eta(state);
  k.r = m.point(eta(state));
  k.A = &cache.A;
  k.elastic = modes() > 0 ? elastic.data() : nullptr;
  k.p = Eigen::Map<const Vector3>(state.q) + cache.A * k.r;
  k.R = cache.A * m.orientation(eta(state));
  if (level == Level::position) return;
  const Eigen::Map<const Vector3> omega(state.v + 3);
  const Eigen::Map<const VectorX> eta_dot(state.v + 6, modes());
  const Vector3 r_dot = m.Bm * eta_dot, turn = elastic.bottomRows<3>() * eta_dot;
  k.v = Eigen::Map<const Vector3>(state.v) + cache.A * (omega.cross(k.r) + r_dot);
  k.w = cache.A * (omega + turn);
  if (level == Level::velocity) return;
  k.bias_v = cache.A * (omega.cross(omega.cross(k.r)) + 2 * omega.cross(r_dot));
  k.bias_w = cache.A * (omega.cross(turn) + left_jacobian_rate(phi, m.Theta * eta_dot));
}

BodyEnergy MarkerBody::energy(const BodyState& state, const Vector3& gravity) const {
  return {.kinetic = 0.5 * Eigen::Map<const VectorX>(state.v, 6 + modes()).squaredNorm(),
          .gravity = -gravity.dot(Eigen::Map<const Vector3>(state.q))};
}

}  // namespace lithe::test
