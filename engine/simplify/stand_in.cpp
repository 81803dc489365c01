#include "engine/simplify/stand_in.h"

#include "engine/assembly/batch_of.h"

namespace lithe {

// ---- a body in its plane ----

PlanarStandIn::Arm::Arm(const Matrix3& axes) : normal(axes.col(2)), at(Vector3::Zero()) {
  Eigen::Map<Eigen::Matrix<double, 6, 3>> J(columns);
  J << axes.leftCols<2>(), Vector3::Zero(), Vector3::Zero(), Vector3::Zero(), normal;
}

/// ∂/∂θ of (n × arm) · F + n · T, the arm turning with θ.
void PlanarStandIn::Arm::add_load_stiffness(const Vector3& force, const Vector3&, double* linear) const {
  linear[2] += normal.cross(normal.cross(at)).dot(force);
}

Marker PlanarStandIn::marker(const FramePose& pose) {
  markers_.push_back({pose.position - parameters_.reference.position, pose.axes});
  return new_marker();
}

Matrix3 PlanarStandIn::turn(double angle) const {
  const Vector3 n = plane().axes.col(2);
  return std::cos(angle) * Matrix3::Identity() + std::sin(angle) * skew(n) + (1 - std::cos(angle)) * n * n.transpose();
}

void PlanarStandIn::evaluate(const BodyState& state, Level) const {
  static_cast<Cache&>(*state.cache).turn = turn(state.q[2]);
}

void PlanarStandIn::add_residual(const BodyState&, const double* v_dot, const Vector3& gravity, double* r) const {
  for (int i = 0; i < 2; ++i) r[i] += plane().mass * (v_dot[i] - gravity.dot(plane().axes.col(i)));
  r[2] += plane().inertia * v_dot[2];
}

void PlanarStandIn::add_tangent(const BodyState&, const double*, const Vector3&, const TangentWeights& weights,
                                BodyTangent& S) const {
  S.linear[0] += weights.acceleration * plane().mass;
  S.linear[1] += weights.acceleration * plane().mass;
  S.linear[2] += weights.acceleration * plane().inertia;
}

void PlanarStandIn::marker_kinematics(const BodyState& state, int marker, Level level, MarkerKinematics& k) const {
  auto& cache = static_cast<Cache&>(*state.cache);
  const Matrix3& axes = plane().axes;
  const FramePose& m = markers_[marker];
  Arm& arm = cache.arms[marker];
  arm.at = cache.turn * m.position;
  const Vector3 sideways = arm.normal.cross(arm.at);
  Eigen::Map<Vector3>(arm.columns + 12) = sideways;
  k.p = center(state.q) + arm.at;
  k.r = k.p;
  k.R = cache.turn * m.axes;
  k.A = &cache.A;
  k.elastic = arm.columns;
  k.deflected = &arm;
  if (level == Level::position) return;
  k.w = state.v[2] * arm.normal;
  k.v = axes.col(0) * state.v[0] + axes.col(1) * state.v[1] + state.v[2] * sideways;
  if (level == Level::velocity) return;
  k.bias_v = state.v[2] * state.v[2] * arm.normal.cross(sideways);
  k.bias_w.setZero();
}

BodyEnergy PlanarStandIn::energy(const BodyState& state, const Vector3& gravity) const {
  const double mass = plane().mass, *v = state.v;
  BodyEnergy e;
  e.kinetic = 0.5 * (mass * (v[0] * v[0] + v[1] * v[1]) + plane().inertia * v[2] * v[2]);
  e.gravity = -mass * gravity.dot(center(state.q));
  return e;
}

// ---- connectors ----

void RowsInPlane::evaluate(double time, std::span<const MarkerView> markers, ConstraintRows& rows) const {
  ConstraintRows all(marker_count());
  all.recall(rows.quarter_turns());
  parameters_.whole->evaluate(time, markers, all);
  // Stiffness under load stays out: it has no place between bodies without frames.
  for (int r : parameters_.rows) {
    Wrench* wrench = all.on_velocity(r) ? rows.open_velocity() : rows.open();
    for (int m = 0; m < marker_count(); ++m) wrench[m] = all.wrench(r, m);
    rows.finish(all.residual(r), all.bias(r), all.rate(r));
  }
}

template std::unique_ptr<BodyBatch> make_body_batch<RigidStandIn>();
template std::unique_ptr<BodyBatch> make_body_batch<PlanarStandIn>();
template std::unique_ptr<ConstraintBatch> make_constraint_batch<RowsInPlane>();
template std::unique_ptr<ForceBatch> make_force_batch<MovedForce>();
template std::unique_ptr<ForceBatch> make_force_batch<TurnCount>();

}  // namespace lithe
