#include "bodies/flexible/flexible_body.h"
#include "bodies/flexible/node_sets.h"
#include "engine/base/checks.h"
#include "engine/base/error.h"

namespace lithe {

/// The columns of a marker that turns, or follows a quadratic deflection: [r; φ] = elastic η + pairs w(η).
struct FlexibleBody::TurningMarker final : DeflectedMarker {
  Matrix6X columns;  // 6 x nm
  Matrix3 Jl = Matrix3::Identity();
  const MarkerShape& shape;

  explicit TurningMarker(const MarkerShape& marker) : columns(marker.elastic), shape(marker) {}

  void add_load_stiffness(const Vector3& force, const Vector3& torque, double* linear) const override {
    Vector6 load;
    load << force, Jl.transpose() * torque;
    for (Eigen::Index l = 0; l < columns.cols(); ++l)
      for (Eigen::Index k = l; k < columns.cols(); ++k) *linear++ += shape.pairs.col(k * (k + 1) / 2 + l).dot(load);
  }
};

FlexibleBody::Cache::Cache(const FlexibleBody& body)
    : terms(body.field_count()),
      deflection(body.deflection_ ? body.field_count() : 0, body.deflection_ ? body.mode_count() : 0) {}

FlexibleBody::Cache::Cache(Cache&&) noexcept = default;
FlexibleBody::Cache::~Cache() = default;

Marker FlexibleBody::add_marker(MarkerRecipe recipe) {
  markers_.push_back(recipe());
  recipes_.push_back(std::move(recipe));
  return new_marker();
}

FlexibleBody::MarkerShape FlexibleBody::shape(const Vector3& c, const Matrix3X& Bm, const Matrix3X& Theta,
                                              const Matrix3& R0, MarkerNodes nodes, const Matrix3X& Theta_pairs) const {
  MarkerShape shape{c, R0, Matrix6X(6, 0), MatrixX(6, 0), Theta.size() > 0 && !Theta.isZero(0), std::move(nodes)};
  if (!Bm.isZero(0) || shape.turns) {  // else the deformation never moves it: no columns at joints
    Matrix6X fields = Matrix6X::Zero(6, field_count());
    fields.topRows<3>() = Bm;
    if (shape.turns) fields.bottomRows<3>() = Theta;
    shape.elastic = fields.leftCols(modes_);
    if (deflection_) shape.pairs = fields * deflection_->curvature();
    if (deflection_ && Theta_pairs.cols() > 0) shape.pairs.bottomRows<3>() += Theta_pairs;
  }
  return shape;
}

Matrix3X FlexibleBody::node_fields(int node) const {
  if (modes_ == 0) return Matrix3X(3, 0);
  return basis().node_modes(node, deflection_ != nullptr).leftCols(field_count());
}

std::vector<int> FlexibleBody::indices_of(const std::vector<int>& ids) const {
  std::vector<int> indices;
  for (int id : ids) indices.push_back(basis().node_index(id));
  return indices;
}

Marker FlexibleBody::node(int id, const Matrix3& orientation) {
  require::at("'" + name() + "' of " + where(),
              [&] { require::rotation(orientation, "orientation of a node marker"); });
  const int node = basis().node_index(id);
  return add_marker([=, this] { return node_shape(node, orientation); });
}

Marker FlexibleBody::marker_at_world(const Point& point, const Matrix3& orientation) {
  const Coordinates c = coordinates();
  VectorX q(c.q_count()), v(c.v_count());
  initial_state(q, v);
  Cache cache(*this);
  const BodyState drawn{q.data(), v.data(), &cache};
  evaluate(drawn, Level::acceleration);
  const VectorX at_rest = VectorX::Zero(c.v_count());
  const Matrix3X nodes = nodal_motion(drawn, at_rest.data()).position;
  Eigen::Index nearest = 0;
  const double distance = (nodes.colwise() - point.at).colwise().norm().minCoeff(&nearest);
  const int id = basis().node_ids[static_cast<size_t>(nearest)];
  const double size = (nodes.rowwise().maxCoeff() - nodes.rowwise().minCoeff()).norm();
  if (!(distance <= 1e-6 * size))
    throw SceneError("'" + name() + "' has no node at that point of the world: the nearest, " + std::to_string(id) +
                         ", is " + std::to_string(distance) + " m away",
                     where(), "give the place of a node as drawn, or use node(id) or average({ids})");
  return node(id, parameters_.orientation.transpose() * orientation);
}

FlexibleBody::MarkerShape FlexibleBody::node_shape(int node, const Matrix3& orientation) const {
  Matrix3X Theta(3, 0);  // of a beam's or shell's node
  if (modes_ > 0 && !basis().rotations.empty()) {
    Theta = basis().node_rotation_modes(node, deflection_ != nullptr);
    if (Theta.cols() > 0) Theta = Theta.leftCols(field_count()).eval();
  }
  return shape(basis().nodes.col(node), node_fields(node), Theta, basis().rotation.transpose() * orientation,
               {{node}, {1.0}});
}

Marker FlexibleBody::average(const std::vector<int>& ids, const Matrix3& orientation,
                             const std::vector<double>& weights) {
  require::at("'" + name() + "' of " + where(),
              [&] { require::rotation(orientation, "orientation of an average marker"); });
  const NodeAverage mean(basis().nodes, indices_of(ids), weights, "'" + name() + "' of " + where());
  return add_marker([=, this] { return average_shape(mean, orientation); });
}

FlexibleBody::MarkerShape FlexibleBody::average_shape(const NodeAverage& mean, const Matrix3& orientation) const {
  Matrix3X Bm = Matrix3X::Zero(3, field_count()), Theta = Matrix3X::Zero(3, field_count());
  for (size_t k = 0; k < mean.nodes.size() && modes_ > 0; ++k) {
    const auto column = static_cast<Eigen::Index>(k);
    const Matrix3X B = mean.weights[column] * node_fields(mean.nodes[k]);
    Bm += B;
    Theta += skew(mean.arms.col(column)) * B;
  }
  Theta = (mean.spread_inverse * Theta).eval();
  return shape(mean.center, Bm, Theta, basis().rotation.transpose() * orientation,
               {mean.nodes, {mean.weights.begin(), mean.weights.end()}},
               deflection_ ? mean_turns(mean, Theta) : Matrix3X(3, 0));
}

/// Second order of the rotation R that leaves Rᵀ Σ w (ρ + u) ρᵀ symmetric, R = E + φ~ + ½ φ~²:
///   D φ₂ = ax(U₂ - φ₁~ U₁ + ½ φ₁~² S),   U = Σ w u ρᵀ, S = Σ w ρ ρᵀ, ax(X) the axis of X - Xᵀ, D φ = ax(φ~ S).
/// U₂, of the displacements of second order, is with the fields already.
Matrix3X FlexibleBody::mean_turns(const NodeAverage& mean, const Matrix3X& Theta) const {
  std::vector<Matrix3> U(static_cast<size_t>(modes_), Matrix3::Zero()), turn(U);
  Matrix3 S = Matrix3::Zero();
  for (size_t i = 0; i < mean.nodes.size(); ++i) {
    const Vector3 arm = mean.arms.col(static_cast<Eigen::Index>(i));
    const double weight = mean.weights[static_cast<Eigen::Index>(i)];
    const Matrix3X B = node_fields(mean.nodes[i]);
    S += weight * arm * arm.transpose();
    for (int k = 0; k < modes_; ++k) U[static_cast<size_t>(k)] += weight * B.col(k) * arm.transpose();
  }
  for (int k = 0; k < modes_; ++k) turn[static_cast<size_t>(k)] = skew(Theta.col(k));
  const auto second = [&](size_t k, size_t l) -> Vector3 {
    const Matrix3 X = -turn[k] * U[l] + 0.5 * turn[k] * turn[l] * S;
    return {X(2, 1) - X(1, 2), X(0, 2) - X(2, 0), X(1, 0) - X(0, 1)};
  };
  Matrix3X turns(3, deflection_->pair_count());
  Eigen::Index p = 0;
  for (size_t l = 0; l < static_cast<size_t>(modes_); ++l)
    for (size_t k = 0; k <= l; ++k) turns.col(p++) = mean.spread_inverse * (second(k, l) + second(l, k));
  return turns;
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
    throw SceneError("a nodal load has a force that is not finite", place, "look how the field was computed");
  const std::vector<int> nodes = indices_of(ids);
  NodalLoad load;
  for (int axis = 0; axis < 3; ++axis)
    for (double sign : {1.0, -1.0}) {
      const VectorX part = (sign * forces.row(axis)).cwiseMax(0).transpose();
      const double sum = part.sum();
      if (sum == 0) continue;
      MarkerNodes loaded;
      for (size_t k = 0; k < nodes.size(); ++k) {
        const double weight = part[static_cast<Eigen::Index>(k)] / sum;
        if (weight == 0) continue;
        loaded.nodes.push_back(nodes[k]);
        loaded.weights.push_back(weight);
      }
      load.markers.push_back(add_marker([=, this] {
        Vector3 c = Vector3::Zero();
        Matrix3X Bm = Matrix3X::Zero(3, field_count());
        for (size_t k = 0; k < loaded.nodes.size(); ++k) {
          c += loaded.weights[k] * basis().nodes.col(loaded.nodes[k]);
          if (modes_ > 0) Bm += loaded.weights[k] * node_fields(loaded.nodes[k]);
        }
        return shape(c, Bm, Matrix3X(3, 0), basis().rotation.transpose(), loaded);
      }));
      load.forces.push_back(sign * sum * Vector3::Unit(axis));
    }
  if (load.forces.empty()) throw SceneError("a nodal load is zero at every node", place, "leave it out");
  return load;
}

Marker FlexibleBody::frame(const Matrix3& orientation) {
  require::at("'" + name() + "' of " + where(),
              [&] { require::rotation(orientation, "orientation of the frame marker"); });
  return add_marker([=, this] {
    return shape(Vector3::Zero(), Matrix3X::Zero(3, field_count()), Matrix3X(3, 0),
                 basis().rotation.transpose() * orientation);
  });
}

Marker FlexibleBody::modal_marker(const Vector3& c, const Matrix3X& Bm, const Matrix3X& Theta, const Matrix3& R0) {
  require::at("'" + name() + "' of " + where(), [&] {
    require::finite(c, "position of a modal marker");
    require::rotation(R0, "orientation of a modal marker");
  });
  if (Bm.cols() != field_count() || (Theta.size() > 0 && Theta.cols() != field_count()))
    throw SceneError("a modal marker on '" + name() + "' has " + std::to_string(Bm.cols()) + " columns for " +
                         std::to_string(field_count()) + " displacement fields",
                     where(), "give Bm and Theta one column a mode (and field of a quadratic deflection)");
  if (fields_.size() > 0)
    throw SceneError("a modal marker was made after set_fidelity() of '" + name() + "'", where(),
                     "make modal markers first: their columns are those of the basis as given");
  modal_columns_ = std::min(modal_columns_, field_count());
  return add_marker([=, this] {
    if (fields_.size() == 0) return shape(c, Bm, Theta, R0);
    const auto fields = fields_.topRows(Bm.cols());  // the modes drawn may be the leading ones
    return shape(c, Bm * fields, Theta.size() > 0 ? Matrix3X(Theta * fields) : Theta, R0);
  });
}

/// docs/equations.md 7.1: r = c + Bm η, orientation A exp(φ~) R0 with φ = Θ η.
void FlexibleBody::marker_kinematics(const BodyState& state, int marker, Level level, MarkerKinematics& k) const {
  auto& cache = static_cast<Cache&>(*state.cache);
  const MarkerShape& m = markers_[marker];
  const Matrix3& A = cache.A;
  k.A = &A;
  k.r = m.c;
  k.elastic = nullptr;
  const bool moves = m.elastic.cols() > 0;
  const DeflectionTerms& d = cache.deflection;
  const Eigen::Map<const VectorX> eta(state.q + 7, modes_), rate(state.v + 6, modes_);
  Vector3 phi = Vector3::Zero(), phi_dot = Vector3::Zero(), deform = Vector3::Zero(), turn_rate = Vector3::Zero();
  Matrix3 Jl;
  if (moves) {
    k.r.noalias() += m.elastic.topRows<3>().lazyProduct(eta);
    if (deflection_) k.r.noalias() += m.pairs.topRows<3>().lazyProduct(d.pairs);
    k.elastic = m.elastic.data();
  }
  if (moves && (m.turns || deflection_)) {
    if (static_cast<int>(cache.markers.size()) <= marker) cache.markers.resize(markers_.size());
    auto& turning = cache.markers[static_cast<size_t>(marker)];
    if (!turning) turning = std::make_unique<TurningMarker>(m);
    Matrix6X& columns = turning->columns;
    columns = m.elastic;
    if (deflection_) add_pair_columns(m.pairs, state.q + 7, columns);
    if (m.turns) {
      phi.noalias() = m.elastic.bottomRows<3>().lazyProduct(eta);
      if (deflection_) phi.noalias() += m.pairs.bottomRows<3>().lazyProduct(d.pairs);
      phi_dot.noalias() = columns.bottomRows<3>().lazyProduct(rate);
      Jl = turning->Jl = left_jacobian(phi);
      for (int c = 0; c < modes_; ++c) columns.col(c).tail<3>() = (Jl * columns.col(c).tail<3>()).eval();
    }
    k.elastic = columns.data();
    k.deflected = deflection_ ? turning.get() : nullptr;
  }
  if (m.turns)
    k.R = A * rotation_exp(phi) * m.R0;
  else
    k.R = A * m.R0;
  const Vector3 arm = A * k.r;
  k.p = Eigen::Map<const Vector3>(state.q) + arm;
  if (level == Level::position) return;

  const Eigen::Map<const Vector3> w(state.v + 3);
  if (moves) deform.noalias() = Eigen::Map<const Matrix6X>(k.elastic, 6, modes_).topRows<3>().lazyProduct(rate);
  if (m.turns) turn_rate = Jl * phi_dot;
  k.v = Eigen::Map<const Vector3>(state.v) + A * (w.cross(k.r) + deform);
  k.w = A * (w + turn_rate);
  if (level == Level::velocity) return;
  Vector3 bias = w.cross(w.cross(k.r)) + 2 * w.cross(deform), turn_bias = Vector3::Zero();
  if (m.turns) turn_bias = w.cross(turn_rate) + left_jacobian_rate(phi, phi_dot);
  if (moves && deflection_) {
    const Vector6 squares = 2 * m.pairs.lazyProduct(d.rate_pairs);
    bias += squares.head<3>();
    if (m.turns) turn_bias += Jl * squares.tail<3>();
  }
  k.bias_v = A * bias;
  k.bias_w = A * turn_bias;
}

}  // namespace lithe
