#include "bodies/flexible/reduction.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <numeric>

#include "bodies/flexible/eigen_modes.h"
#include "bodies/flexible/frames.h"
#include "bodies/flexible/inertia_integrals.h"
#include "bodies/flexible/node_sets.h"
#include "bodies/flexible/quadratic_deflection.h"
#include "engine/error.h"
#include "engine/log.h"

namespace lithe {
namespace {

using Triplets = std::vector<Eigen::Triplet<double>>;

double hertz(double eigenvalue) { return std::sqrt(std::max(eigenvalue, 0.0)) / (2 * std::numbers::pi); }

/// K in body axes, A^nT K_A A^n (18). Blocks of scalar mass do not change, K does.
SparseMatrix turned(const SparseMatrix& K, const Matrix3& rotation) {
  if (rotation.isIdentity(0)) return K;
  Triplets entries;
  const auto n = static_cast<int>(K.rows()) / 3;
  for (int i = 0; i < n; ++i)
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c)
        if (rotation(r, c) != 0) entries.emplace_back(3 * i + r, 3 * i + c, rotation(r, c));
  SparseMatrix A(K.rows(), K.cols());
  A.setFromTriplets(entries.begin(), entries.end());
  const SparseMatrix T = A.transpose();
  const SparseMatrix body = T * K * A;
  return 0.5 * (body + SparseMatrix(body.transpose()));
}

SparseMatrix diagonal_matrix(const VectorX& d) {
  SparseMatrix D(d.size(), d.size());
  D.reserve(Eigen::VectorXi::Ones(d.size()));
  for (Eigen::Index k = 0; k < d.size(); ++k) D.insert(k, k) = d[k];
  D.makeCompressed();
  return D;
}

SparseMatrix unit_matrix(Eigen::Index n) {
  SparseMatrix E(n, n);
  E.setIdentity();
  return E;
}

SupportedProblem supported(const SparseMatrix& K, const SparseMatrix& M, const SparseMatrix& T, const MatrixX& rigid) {
  const SparseMatrix transposed = T.transpose();
  return {T, transposed * K * T, transposed * M * T, transposed * rigid};
}

void require_held(const EigenModes& modes, const SupportedProblem& problem, const std::string& where) {
  if (modes.eigenvalues.size() == 0 || modes.eigenvalues[0] > eigenvalue_noise(problem.K, problem.M)) return;
  throw SceneError("the supported body still moves without stiffness: a mechanism.", where,
                   "hold every loose part: look for unconnected pieces, duplicate nodes, or nodes without elements.");
}

/// Nodal coordinates of a hinged body still contain its swing. One more condition for each free rigid motion takes it
/// out: the row where that motion is largest (the node farthest from the hinge axis, its component along the swing),
/// by QR with column pivoting.
std::vector<int> with_swing_held(const FramePlacement& placed) {
  std::vector<int> fixed = placed.fixed_dofs;
  const MatrixX motion = placed.rigid.transpose();
  const Eigen::ColPivHouseholderQR<MatrixX> qr(motion);
  for (Eigen::Index k = 0; k < placed.rigid.cols(); ++k)
    fixed.push_back(static_cast<int>(qr.colsPermutation().indices()[k]));
  std::sort(fixed.begin(), fixed.end());
  return fixed;
}

void fill_nodal(const FiniteElementModel& model, const BodyFrame& frame, FramePlacement placed, const SparseMatrix& K,
                const Reduction& interfaces, ModalBasis& basis) {
  if (std::holds_alternative<MeanAxisFrame>(frame))
    throw SceneError("mean axes are no selection of nodal coordinates.", placed.where,
                     "use a ThreeNodeFrame (or a tangent or hinge frame) with kAllNodal.");
  if (!interfaces.rigid.empty())
    throw SceneError("a body with all its nodal coordinates keeps no set of nodes rigid.", placed.where,
                     "ask for as many modes as there are coordinates instead of kAllNodal: it is the same body.");
  placed.fixed_dofs = with_swing_held(placed);
  const SupportedProblem problem = supported(K, model.mass, free_motions(placed, {}), MatrixX(K.rows(), 0));
  require_held(lowest_modes(problem.K, problem.M, problem.rigid, 1, placed.where), problem, placed.where);
  basis.nodal = true;
  for (Eigen::Index k = 0; k < problem.T.cols(); ++k)
    basis.free_dofs.push_back(static_cast<int>(SparseMatrix::InnerIterator(problem.T, k).row()));
  basis.stiffness = problem.K;
  basis.modal_mass = problem.M;
}

std::vector<std::vector<int>> indices_of(const FiniteElementModel& model, const std::vector<std::vector<int>>& sets) {
  std::vector<std::vector<int>> indices(sets.size());
  for (size_t s = 0; s < sets.size(); ++s)
    for (int id : sets[s]) indices[s].push_back(model.node_index(id));
  return indices;
}

/// Nodal forces of unit loads on the interfaces, body axes, 3n x 6 a interface.
MatrixX unit_loads(const FiniteElementModel& model, const FramePlacement& placed,
                   const std::vector<WeightedNodes>& interfaces) {
  const int n = model.node_count();
  MatrixX F(3 * n, 6 * static_cast<Eigen::Index>(interfaces.size()));
  for (size_t s = 0; s < interfaces.size(); ++s)
    F.middleCols<6>(6 * static_cast<Eigen::Index>(s)) =
        NodeAverage(placed.nodes, indices_of(model, {interfaces[s].ids})[0], interfaces[s].weights, placed.where)
            .unit_loads(n);
  return F;
}

void fill_modes(const FiniteElementModel& model, const FramePlacement& placed, const SparseMatrix& K, int mode_count,
                const Reduction& interfaces, ModalBasis& basis) {
  const SparseMatrix T = free_motions(placed, indices_of(model, interfaces.rigid));
  const SupportedProblem problem = supported(K, model.mass, T, placed.rigid);
  const auto available = static_cast<int>(T.cols() - placed.rigid.cols());
  if (mode_count > available)
    throw SceneError(std::to_string(mode_count) + " modes are asked for, but the frame leaves " +
                         std::to_string(available) + " elastic coordinates.",
                     placed.where, "ask for at most " + std::to_string(available) + ", or for kAllNodal.");
  EigenModes modes = lowest_modes(problem.K, problem.M, problem.rigid, mode_count, placed.where);
  require_held(modes, problem, placed.where);
  if (!interfaces.loaded.empty()) {
    require_held(lowest_modes(problem.K, problem.M, problem.rigid, 1, placed.where), problem, placed.where);
    const MatrixX loads = T.transpose() * unit_loads(model, placed, interfaces.loaded);
    modes = with_static_modes(problem.K, problem.M, problem.rigid, modes, loads, placed.where);
  }

  const auto count = static_cast<int>(modes.eigenvalues.size());
  basis.modes = T * modes.vectors;
  basis.stiffness = diagonal_matrix(modes.eigenvalues);
  basis.modal_mass = unit_matrix(count);
  basis.diagonal = true;
  basis.frequencies = modes.eigenvalues.unaryExpr([](double lambda) { return hertz(lambda); });
  if (interfaces.deflection != Deflection::linear && count > 0)
    basis.deflection = make_quadratic_deflection(model, basis, problem, interfaces, placed.where);
}

void log_basis(const ModalBasis& basis, const std::string& where) {
  char text[96];
  if (basis.nodal)
    std::snprintf(text, sizeof text, ": %d nodal coordinates", basis.mode_count());
  else if (basis.mode_count() == 0)
    std::snprintf(text, sizeof text, ": rigid");
  else
    std::snprintf(text, sizeof text, ": %d modes, %.6g to %.6g Hz", basis.mode_count(), basis.frequencies[0],
                  basis.frequencies[basis.mode_count() - 1]);
  log::info(where + text + (basis.free_swing_dropped ? ", the free swing left out" : ""));
}

}  // namespace

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

std::shared_ptr<const ModalBasis> make_basis(const FiniteElementModel& model, const BodyFrame& frame, int mode_count,
                                             const Reduction& interfaces) {
  require_sound(model);
  const FramePlacement placed = place_frame(model, frame);
  if (mode_count < kAllNodal)
    throw SceneError("the mode count is " + std::to_string(mode_count) + ".", placed.where,
                     "give 0 (rigid), a number of modes, or kAllNodal.");
  auto basis = std::make_shared<ModalBasis>();
  basis->name = model.name;
  basis->origin = placed.origin;
  basis->rotation = placed.rotation;
  basis->node_ids = model.node_ids;
  basis->node_sets = model.node_sets;
  basis->elements = model.elements;
  basis->nodes = placed.nodes;
  basis->nodal_mass = scalar_mass(model.mass);
  basis->free_swing_dropped = std::holds_alternative<HingeFrame>(frame) && placed.rigid.cols() > 0;

  const SparseMatrix K = turned(model.stiffness, placed.rotation);
  if (mode_count == kAllNodal)
    fill_nodal(model, frame, placed, K, interfaces, *basis);
  else
    fill_modes(model, placed, K, mode_count, interfaces, *basis);
  if (!basis->nodal) basis->integrals = inertia_integrals(*basis);
  log_basis(*basis, placed.where);
  return basis;
}

std::shared_ptr<const ModalBasis> basis_from_modes(std::string name, const Matrix3X& nodes,
                                                   const SparseMatrix& nodal_mass, const SparseMatrix& modal_stiffness,
                                                   const MatrixX& modes) {
  const Eigen::Index n = nodes.cols(), nm = modes.cols();
  const std::string where = "basis '" + name + "'";
  const auto refuse = [&](const std::string& problem, const std::string& mend) {
    throw SceneError(problem, where, mend);
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
    basis->frequencies = pairs.eigenvalues().unaryExpr([](double lambda) { return hertz(lambda); });
  }
  basis->integrals = inertia_integrals(*basis);
  return basis;
}

VectorX frequencies(const FiniteElementModel& model, const std::vector<int>& fixed_dofs, int count) {
  require_sound(model);
  const int dofs = 3 * model.node_count();
  const std::string where = "model '" + model.name + "', " + std::to_string(fixed_dofs.size()) + " fixed dofs";
  for (int dof : fixed_dofs)
    if (dof < 0 || dof >= dofs)
      throw SceneError("degree of freedom " + std::to_string(dof) + " of " + std::to_string(dofs) + " is fixed.", where,
                       "count 3 * node index + axis from 0.");
  const MatrixX rigid = rigid_motions_left(model.nodes, fixed_dofs);
  const FramePlacement placed{.nodes = model.nodes, .fixed_dofs = fixed_dofs, .rigid = rigid, .where = where};
  const SupportedProblem problem = supported(model.stiffness, model.mass, free_motions(placed, {}), rigid);
  if (count < 0 || count > problem.T.cols())
    throw SceneError(
        std::to_string(count) + " frequencies of " + std::to_string(problem.T.cols()) + " free degrees of freedom.",
        where, "ask for fewer.");
  VectorX hz = VectorX::Zero(count);
  const int zero = static_cast<int>(rigid.cols());
  if (count <= zero) return hz;
  const EigenModes modes = lowest_modes(problem.K, problem.M, problem.rigid, count - zero, where);
  const double noise = eigenvalue_noise(problem.K, problem.M);
  for (int k = zero; k < count; ++k) {
    const double lambda = modes.eigenvalues[k - zero];
    hz[k] = lambda > noise ? hertz(lambda) : 0.0;
  }
  return hz;
}

}  // namespace lithe
