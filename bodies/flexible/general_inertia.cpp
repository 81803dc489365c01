#include "bodies/flexible/general_inertia.h"

#include <Eigen/QR>
#include <array>

#include "bodies/flexible/inertia_integrals.h"
#include "engine/base/error.h"

namespace lithe {
namespace {

/// The vector a of a cross-product matrix a~, from its antisymmetric part.
Vector3 axial(const Matrix3& a) { return 0.5 * Vector3(a(2, 1) - a(1, 2), a(0, 2) - a(2, 0), a(1, 0) - a(0, 1)); }

}  // namespace

bool is_scalar_interpolation(const FiniteElementModel& model, const ModelCheck& sheet) {
  return model.rotations.empty() && sheet.mass_isotropy <= kIsotropyBound;
}

SparseMatrix translations(const SparseMatrix& A, int node_count) {
  const int n = 3 * node_count;
  if (A.rows() == n) return A;
  SparseMatrix block = A.leftCols(n);
  block.prune([n](Eigen::Index row, Eigen::Index, double) { return row < n; });
  block.conservativeResize(n, n);
  return block;
}

SparseMatrix lumped_mass(const SparseMatrix& S, int node_count) {
  const MatrixX unit = Matrix3::Identity().replicate(node_count, 1);
  const MatrixX sums = S.leftCols(3 * node_count) * unit;  // block i = Σ_j S_ij
  SparseMatrix m(node_count, node_count);
  m.reserve(Eigen::VectorXi::Ones(node_count));
  for (int i = 0; i < node_count; ++i) m.insert(i, i) = sums.block<3, 3>(3 * i, 0).trace() / 3;
  m.makeCompressed();
  return m;
}

MatrixX rigid_motions(const Matrix3X& nodes, const std::vector<RotationalDof>& rotations, const Vector3& center) {
  MatrixX R = MatrixX::Zero(3 * nodes.cols() + static_cast<Eigen::Index>(rotations.size()), 6);
  R.topRows(3 * nodes.cols()) = rigid_motions(nodes, center);
  for (size_t k = 0; k < rotations.size(); ++k)
    R(3 * nodes.cols() + static_cast<Eigen::Index>(k), 3 + rotations[k].axis) = 1;
  return R;
}

RigidMass rigid_mass(const FiniteElementModel& model) {
  // Rᵀ M R about the mesh origin: [m E, -m c~; m c~, J].
  const MatrixX R = rigid_motions(model.nodes, model.rotations, Vector3::Zero());
  const Matrix6 all = R.transpose() * (model.mass * R);
  RigidMass found;
  found.mass = all.topLeftCorner<3, 3>().trace() / 3;
  if (!(found.mass > 0)) return found;
  found.center = axial(all.bottomLeftCorner<3, 3>()) / found.mass;
  const Matrix3 c = skew(found.center);
  found.inertia = all.bottomRightCorner<3, 3>() + found.mass * c * c;
  return found;
}

SparseMatrix axes_turn(const FiniteElementModel& model, const Matrix3& rotation) {
  const int n = model.node_count();
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < n; ++i)
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c)
        if (rotation(r, c) != 0) entries.emplace_back(3 * i + r, 3 * i + c, rotation(r, c));
  std::map<int, std::array<int, 3>> rows;  // of the rotations, by node
  for (size_t k = 0; k < model.rotations.size(); ++k) {
    auto& places = rows.try_emplace(model.rotations[k].node, std::array<int, 3>{-1, -1, -1}).first->second;
    places[model.rotations[k].axis] = 3 * n + static_cast<int>(k);
  }
  for (const auto& [node, places] : rows)
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) {
        if (rotation(r, c) == 0) continue;
        if (places[r] < 0 || places[c] < 0)
          throw SceneError("node " + std::to_string(model.node_ids[node]) +
                               " has one or two rotations as degrees of freedom, and the frame turns its axes.",
                           "model '" + model.name + "'",
                           "export all three rotations of a node, or use a frame with the axes of the mesh.");
        entries.emplace_back(places[r], places[c], rotation(r, c));
      }
  SparseMatrix A(model.dof_count(), model.dof_count());
  A.setFromTriplets(entries.begin(), entries.end());
  return A;
}

InertiaIntegrals general_inertia_integrals(const ModalBasis& basis, const SparseMatrix& S) {
  const Eigen::Index n = basis.nodes.cols();
  const MatrixX R = rigid_motions(basis.nodes, basis.rotations, Vector3::Zero()), SR = S * R;
  const Matrix6 rigid = R.transpose() * SR;
  const MatrixX coupling = SR.transpose() * basis.modes;

  // The lumped masses see another rigid part in a mode than S does: moved rigidly until both agree. A mode without
  // momentum then leaves J unchanged at first order as it should.
  ModalBasis lumped;
  lumped.nodes = basis.nodes;
  lumped.nodal_mass = basis.nodal_mass;
  lumped.stiffness = basis.stiffness;
  lumped.modal_mass = basis.modal_mass;
  lumped.modes = basis.modes.topRows(3 * n);
  const MatrixX translations = R.topRows(3 * n);
  const VectorX m = basis.nodal_mass.diagonal().transpose().replicate(3, 1).reshaped();
  const MatrixX mR = m.asDiagonal() * translations;
  Eigen::CompleteOrthogonalDecomposition<MatrixX> rigid_lumped(6, 6);
  rigid_lumped.setThreshold(1e-9);
  rigid_lumped.compute(mR.transpose() * translations);
  lumped.modes += translations * rigid_lumped.solve(MatrixX(coupling - mR.transpose() * lumped.modes));

  InertiaIntegrals I = inertia_integrals(lumped);
  I.mass = rigid.topLeftCorner<3, 3>().trace() / 3;
  I.s0 = axial(rigid.bottomLeftCorner<3, 3>());
  const Matrix3 J = 0.5 * (rigid.bottomRightCorner<3, 3>() + rigid.bottomRightCorner<3, 3>().transpose());
  I.J0 << J(0, 0), J(1, 1), J(2, 2), J(0, 1), J(0, 2), J(1, 2);
  I.Ct = coupling.topRows<3>();
  I.C0 = coupling.bottomRows<3>();
  return I;
}

}  // namespace lithe
