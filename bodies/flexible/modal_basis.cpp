#include "bodies/flexible/modal_basis.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "bodies/flexible/inertia_integrals.h"
#include "bodies/flexible/reduction.h"
#include "engine/base/error.h"

namespace lithe {

Matrix3X ModalBasis::node_modes(int node, bool all_fields) const {
  if (!nodal && all_fields && deflection) {
    Matrix3X rows(3, mode_count() + deflection->field_count());
    rows << modes.middleRows<3>(3 * node), deflection->fields.middleRows<3>(3 * node);
    return rows;
  }
  if (!nodal) return modes.middleRows<3>(3 * node);
  Matrix3X rows = Matrix3X::Zero(3, mode_count());
  for (int axis = 0; axis < 3; ++axis) {
    const auto found = std::lower_bound(free_dofs.begin(), free_dofs.end(), 3 * node + axis);
    if (found != free_dofs.end() && *found == 3 * node + axis) rows(axis, found - free_dofs.begin()) = 1;
  }
  return rows;
}

Matrix3X ModalBasis::node_rotation_modes(int node, bool all_fields) const {
  const bool wide = all_fields && deflection;
  Matrix3X rows(3, 0);
  for (size_t k = 0; k < rotations.size(); ++k) {
    if (rotations[k].node != node) continue;
    if (rows.cols() == 0) rows.setZero(3, mode_count() + (wide ? deflection->field_count() : 0));
    const Eigen::Index row = 3 * nodes.cols() + static_cast<Eigen::Index>(k);
    rows.row(rotations[k].axis).head(mode_count()) = modes.row(row);
    if (wide) rows.row(rotations[k].axis).tail(deflection->field_count()) = deflection->fields.row(row);
  }
  return rows;
}

int ModalBasis::node_index(int id) const { return find_node_index(name, node_ids, id); }

const std::vector<int>& ModalBasis::node_set(const std::string& set) const {
  return find_node_set(name, node_sets, set);
}

std::shared_ptr<const ModalBasis> basis_from_modes(std::string name, const Matrix3X& nodes,
                                                   const SparseMatrix& nodal_mass, const SparseMatrix& modal_stiffness,
                                                   const MatrixX& modes) {
  const Eigen::Index n = nodes.cols(), nm = modes.cols();
  const std::string where = "basis '" + name + "'";
  const auto refuse = [&](const std::string& problem, const std::string& fix) {
    throw SceneError(problem, where, fix);
  };
  if (modes.rows() != 3 * n || nodal_mass.rows() != n || nodal_mass.cols() != n)
    refuse("the modes have " + std::to_string(modes.rows()) + " rows and the mass " +
               std::to_string(nodal_mass.rows()) + ", for " + std::to_string(n) + " nodes.",
           "give modes of 3 n rows and the scalar mass m_ij, n x n.");
  const bool reduced = modal_stiffness.rows() == nm && modal_stiffness.cols() == nm;
  if (!reduced && (modal_stiffness.rows() != 3 * n || modal_stiffness.cols() != 3 * n))
    refuse("the stiffness is " + std::to_string(modal_stiffness.rows()) + " x " +
               std::to_string(modal_stiffness.cols()) + " for " + std::to_string(nm) + " modes.",
           "give K^ = B' K B, nm x nm, or the nodal K, 3n x 3n.");

  // K^ and Mff = Bᵀ S B, S = m ⊗ E: three components with the same scalar mass.
  MatrixX K = reduced ? MatrixX(modal_stiffness) : MatrixX(modes.transpose() * (modal_stiffness * modes));
  MatrixX Mff = MatrixX::Zero(nm, nm);
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const MatrixX component = modes(Eigen::seqN(axis, n, 3), Eigen::all);
    Mff += component.transpose() * (nodal_mass * component);
  }
  if (!K.allFinite() || !Mff.allFinite() || !nodes.allFinite())
    refuse("nodes, mass, stiffness or modes have a NaN or infinite entry.", "compute the modes again.");
  if (nm > 0 && (K - K.transpose()).cwiseAbs().maxCoeff() > 1e-10 * K.cwiseAbs().maxCoeff())
    refuse("the stiffness is not symmetric within 1e-10.", "give a symmetric stiffness.");
  if (nm > 0 && Eigen::LLT<MatrixX>(Mff).info() != Eigen::Success)
    refuse("the modal mass B' S B is not positive definite.", "give linearly independent modes and positive mass.");
  K = (0.5 * (K + K.transpose())).eval();
  Mff = (0.5 * (Mff + Mff.transpose())).eval();

  auto basis = std::make_shared<ModalBasis>();
  basis->name = std::move(name);
  basis->node_ids.resize(static_cast<size_t>(n));
  std::iota(basis->node_ids.begin(), basis->node_ids.end(), 1);
  basis->nodes = nodes;
  basis->nodal_mass = nodal_mass;
  basis->modes = modes;
  basis->stiffness = K.sparseView(0.0, 0.0);
  basis->modal_mass = Mff.sparseView(0.0, 0.0);
  basis->diagonal = Mff.isIdentity(1e-12) && K.isDiagonal(1e-14);
  if (nm > 0) {
    const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixX> pairs(K, Mff, Eigen::EigenvaluesOnly);
    basis->frequencies = pairs.eigenvalues().unaryExpr(
        [](double lambda) { return std::sqrt(std::max(lambda, 0.0)) / (2 * std::numbers::pi); });
  }
  basis->integrals = inertia_integrals(*basis);
  return basis;
}

}  // namespace lithe
