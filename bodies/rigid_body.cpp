#include "bodies/rigid_body.h"

#include "engine/assembly/batch_of.h"
#include "engine/base/checks.h"

namespace lithe {

RigidBody::RigidBody(Parameters parameters) : parameters_(std::move(parameters)) {
  require::positive(parameters_.mass, "mass");
  require::inertia(parameters_.inertia.matrix, "inertia");
  require::finite(parameters_.position, "position");
  require::rotation(parameters_.orientation, "orientation");
  require::finite(parameters_.velocity, "velocity");
  require::finite(parameters_.angular_velocity, "angular_velocity");
}

Marker RigidBody::marker(const Point& position, const Matrix3& orientation) {
  require::at("'" + name() + "' of " + where(), [&] {
    require::finite(position.at, "marker position");
    require::rotation(orientation, "marker orientation");
  });
  markers_.push_back({position.at, orientation != Matrix3::Identity(), orientation});
  return {this, marker_count() - 1};
}

Marker RigidBody::marker_at_world(const Point& point, const Matrix3& orientation) {
  const Matrix3 to_body = parameters_.orientation.transpose();
  return marker(to_body * (point.at - parameters_.position), to_body * orientation);
}

void RigidBody::initial_state(VectorRef q, VectorRef v) const {
  q << parameters_.position, quaternion_of(parameters_.orientation);
  v << parameters_.velocity, parameters_.angular_velocity;
}

void RigidBody::evaluate(const BodyState& state, Level level) const {
  auto& cache = static_cast<Cache&>(*state.cache);
  cache.A = rotation_matrix(Eigen::Map<const Vector4>(state.q + 3));
  if (level != Level::position) cache.omega_world = cache.A * Eigen::Map<const Vector3>(state.v + 3);
}

void RigidBody::add_residual(const BodyState& state, const double* v_dot, const Vector3& gravity, double* r) const {
  const Eigen::Map<const Vector3> w(state.v + 3), a(v_dot), w_dot(v_dot + 3);
  const Matrix3& J = parameters_.inertia.matrix;
  Eigen::Map<Vector3>(r) += parameters_.mass * (a - gravity);
  Eigen::Map<Vector3>(r + 3) += J * w_dot + w.cross(Vector3(J * w));
}

void RigidBody::add_tangent(const BodyState& state, const double*, const Vector3&, const TangentWeights& weights,
                            BodyTangent& S) const {
  const Matrix3& J = parameters_.inertia.matrix;
  for (int i = 0; i < 3; ++i) S.frame(i, i) += weights.acceleration * parameters_.mass;
  S.frame.bottomRightCorner<3, 3>() += weights.acceleration * J;
  if (weights.velocity == 0) return;
  // ∂(ω × J ω)/∂ω = ω~ J - (J ω)~
  const Eigen::Map<const Vector3> w(state.v + 3);
  S.frame.bottomRightCorner<3, 3>() += weights.velocity * (skew(w) * J - skew(J * w));
}

void RigidBody::marker_kinematics(const BodyState& state, int marker, Level level, MarkerKinematics& k) const {
  const auto& cache = static_cast<const Cache&>(*state.cache);
  const Pose& m = markers_[marker];
  const Vector3 arm = cache.A * m.position;
  k.p = Eigen::Map<const Vector3>(state.q) + arm;
  if (m.turned)
    k.R = cache.A * m.orientation;
  else
    k.R = cache.A;
  k.r = m.position;
  k.A = &cache.A;
  k.elastic = nullptr;
  if (level == Level::position) return;
  k.w = cache.omega_world;
  const Vector3 swing = k.w.cross(arm);
  k.v = Eigen::Map<const Vector3>(state.v) + swing;
  if (level == Level::velocity) return;
  k.bias_v = k.w.cross(swing);
  k.bias_w.setZero();
}

BodyEnergy RigidBody::energy(const BodyState& state, const Vector3& gravity) const {
  const Eigen::Map<const Vector3> p(state.q), v(state.v), w(state.v + 3);
  BodyEnergy e;
  e.kinetic = 0.5 * parameters_.mass * v.squaredNorm() + 0.5 * w.dot(parameters_.inertia.matrix * w);
  e.gravity = -parameters_.mass * gravity.dot(p);
  return e;
}

template std::unique_ptr<BodyBatch> make_body_batch<RigidBody>();

}  // namespace lithe
