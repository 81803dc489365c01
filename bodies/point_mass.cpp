#include "bodies/point_mass.h"

#include "engine/assembly/batch_of.h"
#include "engine/base/checks.h"

namespace lithe {
namespace {

// Columns of a marker's Jacobian [E; 0], 6 x 3.
constexpr double kColumns[18] = {1, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0};

}  // namespace

PointMass::PointMass(Parameters parameters) : parameters_(std::move(parameters)) {
  require::positive(parameters_.mass, "mass");
  require::finite(parameters_.position, "position");
  require::finite(parameters_.velocity, "velocity");
}

Marker PointMass::marker(const Matrix3& orientation) {
  require::at("'" + name() + "' of " + where(), [&] { require::rotation(orientation, "marker orientation"); });
  axes_.push_back(orientation);
  return new_marker();
}

Marker PointMass::marker_at_world(const Point& point, const Matrix3& orientation) {
  const double off = (point.at - parameters_.position).norm();
  if (!(off <= 1e-9 * (1 + parameters_.position.norm())))
    throw SceneError("'" + name() + "' is drawn " + std::to_string(off) + " m from that point of the world", where(),
                     "a point mass has markers at its own place alone: draw it there, or use a RigidBody");
  return marker(orientation);
}

void PointMass::add_residual(const BodyState&, const double* v_dot, const Vector3& gravity, double* r) const {
  Eigen::Map<Vector3>(r) += parameters_.mass * (Eigen::Map<const Vector3>(v_dot) - gravity);
}

void PointMass::add_tangent(const BodyState&, const double*, const Vector3&, const TangentWeights& weights,
                            BodyTangent& S) const {
  S.linear.array() += weights.acceleration * parameters_.mass;
}

void PointMass::marker_kinematics(const BodyState& state, int marker, Level level, MarkerKinematics& k) const {
  k.p = k.r = Eigen::Map<const Vector3>(state.q);
  k.R = axes_[static_cast<std::size_t>(marker)];
  k.A = &state.cache->A;
  k.elastic = kColumns;
  k.deflected = nullptr;
  if (level == Level::position) return;
  k.v = Eigen::Map<const Vector3>(state.v);
  k.w.setZero();
  if (level == Level::velocity) return;
  k.bias_v.setZero();
  k.bias_w.setZero();
}

BodyEnergy PointMass::energy(const BodyState& state, const Vector3& gravity) const {
  BodyEnergy e;
  e.kinetic = 0.5 * parameters_.mass * Eigen::Map<const Vector3>(state.v).squaredNorm();
  e.gravity = -parameters_.mass * gravity.dot(Eigen::Map<const Vector3>(state.q));
  return e;
}

template std::unique_ptr<BodyBatch> make_body_batch<PointMass>();

}  // namespace lithe
