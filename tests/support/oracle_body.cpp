#include "tests/support/oracle_body.h"

#include <functional>

#include "tests/support/oracle.h"

namespace lithe::oracle {
namespace {

SparseMatrix sparse(const MatrixX& dense) { return dense.sparseView(); }

Vector6 packed(const MatrixX& J) {
  Vector6 s;
  s << J(0, 0), J(1, 1), J(2, 2), J(0, 1), J(0, 2), J(1, 2);
  return s;
}

InertiaIntegrals listed(const nlohmann::json& d) {
  InertiaIntegrals I;
  I.mass = d.at("m");
  I.s0 = matrix(d.at("s0"));
  I.Ct = matrix(d.at("Ct"));
  I.J0 = packed(matrix(d.at("J0")));
  const int nm = static_cast<int>(I.Ct.cols());
  I.J1.resize(6, nm);
  I.J2.resize(6 * nm, nm);
  I.C1.resize(3 * nm, nm);
  for (int k = 0; k < nm; ++k) {
    I.J1.col(k) = packed(matrix(d.at("J1")[k]));
    I.C1.middleRows<3>(3 * k) = matrix(d.at("C1")[k]);
    for (int l = 0; l < nm; ++l) I.J2.block<6, 1>(6 * k, l) = packed(matrix(d.at("J2")[k][l]));
  }
  I.C0 = matrix(d.at("C0"));
  I.Mff = matrix(d.at("Mff"));
  I.antisymmetric = false;
  return I;
}

std::shared_ptr<const ModalBasis> basis_of(const nlohmann::json& data) {
  if (data.contains("mass_scalar"))
    return basis_from_modes(data.at("name"), matrix(data.at("nodes")).transpose(),
                            sparse(matrix(data.at("mass_scalar"))), sparse(matrix(data.at("K_modal"))),
                            matrix(data.at("B")));
  // Invariants alone, or a full S: nodes and modes serve the nodal motion only.
  auto basis = std::make_shared<ModalBasis>();
  basis->name = data.at("name");
  const MatrixX Mff = matrix(data.at("invariants").at("Mff"));
  basis->modal_mass = sparse(Mff);
  basis->stiffness =
      sparse(data.contains("K_modal") ? matrix(data.at("K_modal")) : MatrixX::Identity(Mff.rows(), Mff.cols()));
  if (data.contains("nodes")) {
    basis->nodes = matrix(data.at("nodes")).transpose();
    basis->modes = matrix(data.at("B"));
    for (int i = 0; i < basis->nodes.cols(); ++i) basis->node_ids.push_back(i + 1);
  }
  return basis;
}

}  // namespace

MatrixX matrix3(const nlohmann::json& nested) {
  std::vector<double> values;
  int columns = 1;
  const std::function<void(const nlohmann::json&)> walk = [&](const nlohmann::json& j) {
    if (j.is_number()) {
      values.push_back(j.get<double>());
      return;
    }
    if (!j.empty() && j[0].is_number()) columns = static_cast<int>(j.size());
    for (const auto& child : j) walk(child);
  };
  walk(nested);
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  return Eigen::Map<RowMajor>(values.data(), static_cast<int>(values.size()) / columns, columns);
}

InertiaIntegrals integrals_of(const nlohmann::json& data) {
  if (data.contains("mass_scalar")) return inertia_integrals(*basis_of(data));
  if (data.contains("S"))
    return inertia_integrals(matrix(data.at("nodes")).transpose(), sparse(matrix(data.at("S"))), matrix(data.at("B")));
  return listed(data.at("invariants"));
}

Motion::Motion(const nlohmann::json& state) {
  const auto get = [&](const char* key) { return VectorX(matrix(state.at(key))); };
  const VectorX eta = get("eta");
  const auto nm = eta.size();
  q.resize(7 + nm), v.resize(6 + nm), v_dot.setZero(6 + nm);
  q << get("x0"), get("quat").normalized(), eta;
  v << get("xdot"), get("omega"), get("etadot");
  if (state.contains("xddot")) v_dot << get("xddot"), get("omegadot"), get("etaddot");
  if (state.contains("acceleration")) v_dot = get("acceleration");
}

Evaluated::Evaluated(const nlohmann::json& data, InertiaIntegrals integrals) {
  FlexibleBody::Parameters parameters{.basis = basis_of(data)};
  if (data.contains("rayleigh"))
    parameters.damping = {.mass_proportional = data.at("rayleigh").at("alpha"),
                          .stiffness_proportional = data.at("rayleigh").at("beta")};
  body_ = &graph_.add<FlexibleBody>("body", parameters, std::move(integrals));
  if (!data.contains("marker")) return;
  const auto& m = data.at("marker");
  marker_ = body_->modal_marker(matrix(m.at("c")), matrix(m.at("Bm")), matrix(m.at("Theta")), matrix(m.at("R0")));
}

void Evaluated::set(const nlohmann::json& state) {
  motion_ = std::make_unique<Motion>(state);
  cache_ = body_->make_cache();
  body_->evaluate(this->state(), Level::acceleration);
}

Marker Evaluated::node_marker(int node) { return body_->node(body_->basis().node_ids.at(node)); }

MarkerKinematics Evaluated::kinematics(Marker marker) const {
  MarkerKinematics k;
  body_->marker_kinematics(state(), marker.index, Level::acceleration, k);
  return k;
}

/// 6 x (6 + nm), as the documentation of MarkerKinematics writes it.
MatrixX Evaluated::jacobian(const MarkerKinematics& k) const {
  const int nm = body_->mode_count();
  MatrixX J = MatrixX::Zero(6, 6 + nm);
  J.topLeftCorner<3, 3>().setIdentity();
  J.block<3, 3>(0, 3) = -*k.A * skew(k.r);
  J.block<3, 3>(3, 3) = *k.A;
  if (k.elastic) {
    const Eigen::Map<const Matrix6X> E(k.elastic, 6, nm);
    J.topRightCorner(3, nm) = *k.A * E.topRows<3>();
    J.bottomRightCorner(3, nm) = *k.A * E.bottomRows<3>();
  }
  return J;
}

VectorX Evaluated::generalized(Marker marker, const Vector3& force, const Vector3& torque) const {
  Vector6 w;
  w << force, torque;
  return jacobian(kinematics(marker)).transpose() * w;
}

Vector6 Evaluated::acceleration(Marker marker) const {
  const MarkerKinematics k = kinematics(marker);
  Vector6 bias;
  bias << k.bias_v, k.bias_w;
  return jacobian(k) * motion_->v_dot + bias;
}

NodalForm::NodalForm(const nlohmann::json& data, const nlohmann::json& state) {
  const MatrixX B = matrix(data.at("B"));
  auto basis = std::make_shared<ModalBasis>();
  basis->nodes = matrix(data.at("nodes")).transpose();
  basis->nodal_mass = sparse(matrix(data.at("mass_scalar")));
  basis->nodal = true;
  const int n = static_cast<int>(B.rows());
  for (int i = 0; i < n; ++i) basis->free_dofs.push_back(i);
  std::vector<Eigen::Triplet<double>> entries;
  for (int j = 0; j < basis->nodal_mass.outerSize(); ++j)
    for (SparseMatrix::InnerIterator it(basis->nodal_mass, j); it; ++it)
      for (int a = 0; a < 3; ++a)
        entries.emplace_back(3 * static_cast<int>(it.row()) + a, 3 * static_cast<int>(it.col()) + a, it.value());
  basis->modal_mass.resize(n, n);
  basis->modal_mass.setFromTriplets(entries.begin(), entries.end());
  basis->stiffness = basis->modal_mass;

  const Motion motion(state);
  VectorX q(7 + n), v(6 + n);
  q << motion.q.head<7>(), B * motion.q.tail(B.cols());
  v << motion.v.head<6>(), B * motion.v.tail(B.cols());
  const FlexibleBody body({.basis = basis});
  const auto cache = body.make_cache();
  const BodyState s{q.data(), v.data(), cache.get()};
  body.evaluate(s, Level::velocity);
  MatrixX T = MatrixX::Zero(6 + n, 6 + B.cols());
  T.topLeftCorner<6, 6>().setIdentity();
  T.bottomRightCorner(n, B.cols()) = B;
  M = T.transpose() * body.mass_matrix(s) * T;
  f_v = T.transpose() * body.quadratic_velocity_force(s);
  f_gravity = T.transpose() * body.gravity_force(s, matrix(data.at("gravity")));
}

}  // namespace lithe::oracle
