#include <Eigen/Eigenvalues>

#include "bodies/flexible/flexible_body.h"
#include "engine/checks.h"
#include "engine/error.h"

namespace lithe {

int FlexibleBody::add_marker(const Vector3& c, const Matrix3X& Bm, const Matrix3X& Theta, const Matrix3& R0) {
  MarkerShape shape{c, R0, Matrix6X(6, 0), Theta.size() > 0 && !Theta.isZero(0)};
  if (!Bm.isZero(0) || shape.turns) {  // else the deformation never moves it: no columns at joints
    shape.elastic.setZero(6, modes_);
    shape.elastic.topRows<3>() = Bm;
    if (shape.turns) shape.elastic.bottomRows<3>() = Theta;
  }
  markers_.push_back(std::move(shape));
  return marker_count() - 1;
}

Marker FlexibleBody::node(int id, const Matrix3& orientation) {
  require::at("'" + name() + "' of " + where(),
              [&] { require::rotation(orientation, "orientation of a node marker"); });
  const int i = basis().node_index(id);
  const Matrix3X Bi = modes_ > 0 ? Matrix3X(basis().node_modes(i).leftCols(modes_)) : Matrix3X(3, 0);
  return {this, add_marker(basis().nodes.col(i), Bi, Matrix3X(3, 0), basis().rotation.transpose() * orientation)};
}

Marker FlexibleBody::average(const std::vector<int>& ids, const Matrix3& orientation) {
  if (ids.empty())
    throw SceneError("an average marker on '" + name() + "' has no nodes", where(), "name at least one node");
  require::at("'" + name() + "' of " + where(),
              [&] { require::rotation(orientation, "orientation of an average marker"); });
  const double weight = 1.0 / static_cast<double>(ids.size());
  Vector3 c = Vector3::Zero();
  Matrix3X Bm = Matrix3X::Zero(3, modes_), Theta = Matrix3X::Zero(3, modes_);
  for (int id : ids) c += weight * basis().nodes.col(basis().node_index(id));
  Matrix3 D = Matrix3::Zero();
  for (int id : ids) {
    const int i = basis().node_index(id);
    const Vector3 rho = basis().nodes.col(i) - c;
    D += weight * (rho.squaredNorm() * Matrix3::Identity() - rho * rho.transpose());
    if (modes_ == 0) continue;
    const Matrix3X Bi = basis().node_modes(i).leftCols(modes_);
    Bm += weight * Bi;
    Theta += weight * (skew(rho) * Bi);
  }
  // D is singular about the line of collinear nodes: there the marker keeps to the body frame.
  const Eigen::SelfAdjointEigenSolver<Matrix3> eigen(D);
  Matrix3 inverse = Matrix3::Zero();
  for (int a = 0; a < 3; ++a)
    if (eigen.eigenvalues()[a] > 1e-9 * eigen.eigenvalues()[2])
      inverse += eigen.eigenvectors().col(a) * eigen.eigenvectors().col(a).transpose() / eigen.eigenvalues()[a];
  return {this, add_marker(c, Bm, inverse * Theta, basis().rotation.transpose() * orientation)};
}

Marker FlexibleBody::frame(const Matrix3& orientation) {
  require::at("'" + name() + "' of " + where(),
              [&] { require::rotation(orientation, "orientation of the frame marker"); });
  return {this, add_marker(Vector3::Zero(), Matrix3X::Zero(3, modes_), Matrix3X(3, 0),
                           basis().rotation.transpose() * orientation)};
}

Marker FlexibleBody::modal_marker(const Vector3& c, const Matrix3X& Bm, const Matrix3X& Theta, const Matrix3& R0) {
  require::at("'" + name() + "' of " + where(), [&] {
    require::finite(c, "position of a modal marker");
    require::rotation(R0, "orientation of a modal marker");
  });
  if (Bm.cols() != modes_ || (Theta.size() > 0 && Theta.cols() != modes_))
    throw SceneError("a modal marker on '" + name() + "' has " + std::to_string(Bm.cols()) + " columns for " +
                         std::to_string(modes_) + " modes",
                     where(), "give Bm and Theta one column a mode");
  return {this, add_marker(c, Bm, Theta, R0)};
}

/// EQUATIONS.md 7.1: r = c + Bm η, orientation A exp(φ~) R0 with φ = Θ η.
void FlexibleBody::marker_kinematics(const BodyState& state, int marker, Level level, MarkerKinematics& k) const {
  auto& cache = static_cast<Cache&>(*state.cache);
  const MarkerShape& m = markers_[marker];
  const Matrix3& A = cache.A;
  k.A = &A;
  k.r = m.c;
  k.elastic = nullptr;
  const bool moves = m.elastic.cols() > 0;
  const Eigen::Map<const VectorX> eta(state.q + 7, modes_), rate(state.v + 6, modes_);
  Vector3 phi = Vector3::Zero();
  Matrix3 Jl;
  if (moves) {
    k.r.noalias() += m.elastic.topRows<3>().lazyProduct(eta);
    k.elastic = m.elastic.data();
  }
  if (m.turns) {
    phi.noalias() = m.elastic.bottomRows<3>().lazyProduct(eta);
    Jl = left_jacobian(phi);
    if (static_cast<int>(cache.elastic.size()) <= marker) cache.elastic.resize(marker_count());
    Matrix6X& turned = cache.elastic[marker];
    if (turned.cols() != modes_) turned = m.elastic;
    turned.bottomRows<3>() = Jl.lazyProduct(m.elastic.bottomRows<3>());
    k.elastic = turned.data();
    k.R = A * rotation_exp(phi) * m.R0;
  } else {
    k.R = A * m.R0;
  }
  const Vector3 arm = A * k.r;
  k.p = Eigen::Map<const Vector3>(state.q) + arm;
  if (level == Level::position) return;

  const Eigen::Map<const Vector3> w(state.v + 3);
  Vector3 deform = Vector3::Zero(), turn_rate = Vector3::Zero();  // Bm η̇, Jl φ̇
  if (moves) deform.noalias() = m.elastic.topRows<3>().lazyProduct(rate);
  Vector3 phi_dot = Vector3::Zero();
  if (m.turns) {
    phi_dot.noalias() = m.elastic.bottomRows<3>().lazyProduct(rate);
    turn_rate = Jl * phi_dot;
  }
  k.v = Eigen::Map<const Vector3>(state.v) + A * (w.cross(k.r) + deform);
  k.w = A * (w + turn_rate);
  if (level == Level::velocity) return;
  k.bias_v = A * (w.cross(w.cross(k.r)) + 2 * w.cross(deform));
  k.bias_w.setZero();
  if (m.turns) k.bias_w = A * (w.cross(turn_rate) + left_jacobian_rate(phi, phi_dot));
}

}  // namespace lithe
