#include "bodies/flexible/flexible_body.h"
#include "bodies/flexible/node_sets.h"
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

std::vector<int> FlexibleBody::indices_of(const std::vector<int>& ids) const {
  std::vector<int> indices;
  for (int id : ids) indices.push_back(basis().node_index(id));
  return indices;
}

Marker FlexibleBody::node(int id, const Matrix3& orientation) {
  require::at("'" + name() + "' of " + where(),
              [&] { require::rotation(orientation, "orientation of a node marker"); });
  const int i = basis().node_index(id);
  const Matrix3X Bi = modes_ > 0 ? Matrix3X(basis().node_modes(i).leftCols(modes_)) : Matrix3X(3, 0);
  return {this, add_marker(basis().nodes.col(i), Bi, Matrix3X(3, 0), basis().rotation.transpose() * orientation)};
}

Marker FlexibleBody::average(const std::vector<int>& ids, const Matrix3& orientation,
                             const std::vector<double>& weights) {
  require::at("'" + name() + "' of " + where(),
              [&] { require::rotation(orientation, "orientation of an average marker"); });
  const NodeAverage mean(basis().nodes, indices_of(ids), weights, "'" + name() + "' of " + where());
  Matrix3X Bm = Matrix3X::Zero(3, modes_), Theta = Matrix3X::Zero(3, modes_);
  for (size_t k = 0; k < ids.size() && modes_ > 0; ++k) {
    const auto column = static_cast<Eigen::Index>(k);
    const Matrix3X B = mean.weights[column] * basis().node_modes(mean.nodes[k]).leftCols(modes_);
    Bm += B;
    Theta += skew(mean.arms.col(column)) * B;
  }
  return {this, add_marker(mean.center, Bm, mean.spread_inverse * Theta, basis().rotation.transpose() * orientation)};
}

Marker FlexibleBody::rigid(const std::vector<int>& ids, const Matrix3& orientation) {
  const std::string place = "'" + name() + "' of " + where();
  if (NodeAverage(basis().nodes, indices_of(ids), {}, place).on_a_line)
    throw SceneError("the nodes of a rigid marker lie on one line and carry no rotation about it", place,
                     "add a node off the line, or use average()");
  Matrix3X nodes(3, static_cast<Eigen::Index>(ids.size()));
  MatrixX motion(nodes.size(), modes_);
  for (size_t k = 0; k < ids.size(); ++k) {
    const auto column = static_cast<Eigen::Index>(k);
    const int i = basis().node_index(ids[k]);
    nodes.col(column) = basis().nodes.col(i);
    if (modes_ > 0) motion.middleRows<3>(3 * column) = basis().node_modes(i).leftCols(modes_);
  }
  if (modes_ > 0) {
    // Round-off of a mode is that of its largest displacement.
    const VectorX size = basis().nodal ? VectorX(VectorX::Ones(modes_))
                                       : VectorX(basis().modes.leftCols(modes_).cwiseAbs().colwise().maxCoeff());
    if ((deformation(nodes, motion).array() > 1e-9 * size.array()).any())
      throw SceneError(
          "the basis '" + basis().name + "' deforms the " + std::to_string(ids.size()) + " nodes of a rigid marker",
          place, "tie them: make_basis(model, frame, modes, {.rigid = {nodes}}), or use average()");
  }
  return average(ids, orientation);
}

NodalLoad FlexibleBody::nodal_load(const std::vector<int>& ids, const Matrix3X& forces) {
  const std::string place = "'" + name() + "' of " + where();
  if (forces.cols() != static_cast<Eigen::Index>(ids.size()))
    throw SceneError(
        "a nodal load has " + std::to_string(forces.cols()) + " forces on " + std::to_string(ids.size()) + " nodes",
        place, "give a column of forces a node");
  if (!forces.allFinite())
    throw SceneError("a nodal load has a force that is no number", place, "look how the field was computed");
  const std::vector<int> nodes = indices_of(ids);
  NodalLoad load;
  for (int axis = 0; axis < 3; ++axis)
    for (double sign : {1.0, -1.0}) {
      const VectorX part = (sign * forces.row(axis)).cwiseMax(0).transpose();
      const double sum = part.sum();
      if (sum == 0) continue;
      Vector3 c = Vector3::Zero();
      Matrix3X Bm = Matrix3X::Zero(3, modes_);
      for (size_t k = 0; k < nodes.size(); ++k) {
        const double weight = part[static_cast<Eigen::Index>(k)] / sum;
        if (weight == 0) continue;
        c += weight * basis().nodes.col(nodes[k]);
        if (modes_ > 0) Bm += weight * basis().node_modes(nodes[k]).leftCols(modes_);
      }
      load.markers.push_back({this, add_marker(c, Bm, Matrix3X(3, 0), basis().rotation.transpose())});
      load.forces.push_back(sign * sum * Vector3::Unit(axis));
    }
  if (load.forces.empty()) throw SceneError("a nodal load is zero at every node", place, "leave it out");
  return load;
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
