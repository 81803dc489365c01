#include "bodies/flexible/flexible_body.h"

namespace lithe {
namespace {

using ConstVector3 = Eigen::Map<const Vector3>;
using ConstVector = Eigen::Map<const VectorX>;

}  // namespace

FlexibleBody::NodalMotion FlexibleBody::nodal_motion(const BodyState& state, const double* v_dot) const {
  const Matrix3& A = state.cache->A;
  const int n = static_cast<int>(basis().nodes.cols());
  // B times η, η̇, η̈: 3 x n each
  const auto deform = [&](const double* x) {
    Matrix3X u = Matrix3X::Zero(3, n);
    if (modes_ == 0) return u;
    Eigen::Map<VectorX> all(u.data(), 3 * n);
    if (basis().nodal) {
      for (int k = 0; k < modes_; ++k) all[basis().free_dofs[k]] = x[k];
    } else if (deflection_) {
      const int linear = basis().mode_count();
      all = basis().modes.topRows(3 * n) * ConstVector(x, linear);
      all += basis().deflection->fields.topRows(3 * n) * ConstVector(x + linear, field_count() - linear);
    } else {
      all = basis().modes.topLeftCorner(3 * n, modes_) * ConstVector(x, modes_);
    }
    return u;
  };
  const DeflectionTerms& d = static_cast<const Cache&>(*state.cache).deflection;
  VectorX fields_acc;
  if (deflection_) fields_acc = d.P * ConstVector(v_dot + 6, modes_) + d.xi_bias;
  const ConstVector3 x(state.q), v(state.v), w(state.v + 3), a(v_dot), w_dot(v_dot + 3);
  const Matrix3 W = skew(w);
  const Matrix3X r = basis().nodes + deform(deflection_ ? d.xi.data() : state.q + 7),
                 rate = deform(deflection_ ? d.xi_rate.data() : state.v + 6),
                 acceleration = deform(deflection_ ? fields_acc.data() : v_dot + 6);
  NodalMotion motion;
  motion.position = (A * r).colwise() + Vector3(x);
  motion.velocity = (A * (W * r + rate)).colwise() + Vector3(v);
  motion.acceleration = (A * (skew(w_dot) * r + W * (W * r) + 2 * W * rate + acceleration)).colwise() + Vector3(a);
  return motion;
}

VectorX FlexibleBody::field_coordinates(const BodyState& state) const {
  const ConstVector eta(state.q + 7, modes_);
  return deflection_ ? deflection_->coordinates(eta) : VectorX(eta);
}

/// docs/equations.md section 9: P = A (m A^T ẋ + ω × s + Ct η̇), H = s × A^T ẋ + J ω + Cr η̇ about the frame origin.
Vector3 FlexibleBody::linear_momentum(const BodyState& state) const {
  const InertiaTerms& t = static_cast<const Cache&>(*state.cache).terms;
  const ConstVector3 v(state.v), w(state.v + 3);
  return inertia_->mass * v + state.cache->A * (w.cross(t.s) + t.s_rate);
}

Vector3 FlexibleBody::angular_momentum(const BodyState& state) const {
  const InertiaTerms& t = static_cast<const Cache&>(*state.cache).terms;
  const ConstVector3 x(state.q), v(state.v), w(state.v + 3);
  const Matrix3& A = state.cache->A;
  return x.cross(linear_momentum(state)) + A * (t.s.cross(Vector3(A.transpose() * v)) + t.J * w + t.h);
}

VectorX FlexibleBody::quadratic_velocity_force(const BodyState& state) const {
  const InertiaTerms& t = static_cast<const Cache&>(*state.cache).terms;
  const ConstVector3 w(state.v + 3);
  VectorX f(6 + modes_);
  f.head<3>() = -(state.cache->A * (w.cross(w.cross(t.s)) + 2 * w.cross(t.s_rate)));
  f.segment<3>(3) = -(t.J_rate * w + w.cross(Vector3(t.J * w + t.h)) + t.Cr_rate_h);
  if (!deflection_) {
    f.tail(modes_) = t.quadratic;
    return f;
  }
  const DeflectionTerms& d = static_cast<const Cache&>(*state.cache).deflection;
  f.head<3>() -= state.cache->A * (inertia_->Ct * d.xi_bias);
  f.segment<3>(3) -= t.Cr * d.xi_bias;
  f.tail(modes_) = d.P.transpose() * (t.quadratic - d.xi_bias);
  return f;
}

VectorX FlexibleBody::gravity_force(const BodyState& state, const Vector3& gravity) const {
  const InertiaTerms& t = static_cast<const Cache&>(*state.cache).terms;
  const Vector3 g = state.cache->A.transpose() * gravity;
  VectorX f(6 + modes_);
  f.head<3>() = inertia_->mass * gravity;
  f.segment<3>(3) = t.s.cross(g);
  const Matrix3X& Ct = deflection_ ? static_cast<const Cache&>(*state.cache).deflection.Ct : inertia_->Ct;
  f.tail(modes_) = Ct.transpose() * g;
  return f;
}

VectorX FlexibleBody::elastic_force(const BodyState& state) const {
  VectorX f = VectorX::Zero(6 + modes_);
  add_modal(0, 0, -1, state.q + 7, f.data() + 6);
  if (deflection_) f.tail(modes_) -= static_cast<const Cache&>(*state.cache).deflection.force;
  return f;
}

VectorX FlexibleBody::damping_force(const BodyState& state) const {
  VectorX f = VectorX::Zero(6 + modes_);
  add_modal(0, -1, 0, state.v + 6, f.data() + 6);
  return f;
}

MatrixX FlexibleBody::mass_matrix(const BodyState& state) const {
  const int n = 6 + modes_, entries = diagonal_ ? modes_ : static_cast<int>(pattern_.rows.size());
  Matrix6 frame = Matrix6::Zero();
  Matrix6X frame_linear = Matrix6X::Zero(6, modes_);
  MatrixX linear_frame = MatrixX::Zero(modes_, 6);
  VectorX linear = VectorX::Zero(entries), still = VectorX::Zero(n);
  BodyTangent S{Eigen::Map<Matrix6>(frame.data()), Eigen::Map<Matrix6X>(frame_linear.data(), 6, modes_),
                Eigen::Map<MatrixX>(linear_frame.data(), modes_, 6), Eigen::Map<VectorX>(linear.data(), entries)};
  add_tangent(state, still.data(), Vector3::Zero(), {0, 0, 1}, S);
  MatrixX M = MatrixX::Zero(n, n);
  M.topLeftCorner<6, 6>() = frame;
  M.topRightCorner(6, modes_) = frame_linear;
  M.bottomLeftCorner(modes_, 6) = linear_frame;
  for (int k = 0; k < entries; ++k) {
    const int i = diagonal_ ? k : pattern_.rows[k], j = diagonal_ ? k : pattern_.columns[k];
    M(6 + i, 6 + j) = M(6 + j, 6 + i) = linear[k];
  }
  return M;
}

}  // namespace lithe
