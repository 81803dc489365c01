#include "bodies/flexible/inertia_integrals.h"

namespace lithe {
namespace {

/// D = <psi_k psi_lᵀ> for all k, l = 0..nm, block (k, l) of 3 x 3; psi_0 = r0. `fields` is n x 3(nm+1): column 3k +
/// axis.
template <typename Fields>
MatrixX products(const SparseMatrix& mass, const Fields& fields) {
  const Fields weighted = mass * fields;
  return MatrixX(fields.transpose() * weighted);
}

MatrixX modal_products(const ModalBasis& basis) {
  const Eigen::Index n = basis.nodes.cols(), nm = basis.modes.cols();
  MatrixX fields(n, 3 * (nm + 1));
  fields.leftCols<3>() = basis.nodes.transpose();
  for (Eigen::Index k = 0; k < nm; ++k)
    fields.middleCols<3>(3 * (k + 1)) = Eigen::Map<const Matrix3X>(basis.modes.col(k).data(), 3, n).transpose();
  return products(basis.nodal_mass, fields);
}

MatrixX nodal_products(const ModalBasis& basis) {
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < basis.nodes.cols(); ++i)
    for (int axis = 0; axis < 3; ++axis) entries.emplace_back(i, axis, basis.nodes(axis, i));
  int column = 3;
  for (int dof : basis.free_dofs) {
    entries.emplace_back(dof / 3, column + dof % 3, 1.0);
    column += 3;
  }
  SparseMatrix fields(basis.nodes.cols(), column);
  fields.setFromTriplets(entries.begin(), entries.end());
  return products(basis.nodal_mass, fields);
}

Vector6 symmetric(const Matrix3& a) {
  return (Vector6() << a(0, 0), a(1, 1), a(2, 2), a(0, 1), a(0, 2), a(1, 2)).finished();
}

/// <psi_k x psi_l> from D_kl.
Vector3 cross_sum(const Matrix3& D) { return {D(1, 2) - D(2, 1), D(2, 0) - D(0, 2), D(0, 1) - D(1, 0)}; }

/// Symmetric part of J_kl = tr(D_kl) E - D_klᵀ.
Matrix3 inertia(const Matrix3& D) { return D.trace() * Matrix3::Identity() - 0.5 * (D + D.transpose()); }

}  // namespace

InertiaIntegrals inertia_integrals(const ModalBasis& basis) {
  const Eigen::Index nm = basis.mode_count();
  const MatrixX D = basis.nodal ? nodal_products(basis) : modal_products(basis);
  const auto block = [&](Eigen::Index k, Eigen::Index l) -> Matrix3 { return D.block<3, 3>(3 * k, 3 * l); };

  // First moments weigh with the row sums k_i = sum_j m_ij.
  const VectorX k = basis.nodal_mass * VectorX::Ones(basis.nodal_mass.cols());
  InertiaIntegrals I;
  I.mass = k.sum();
  I.s0 = basis.nodes * k;
  I.Ct.resize(3, nm);
  if (basis.nodal) {
    I.Ct.setZero();
    for (Eigen::Index a = 0; a < nm; ++a) {
      const int dof = basis.free_dofs[static_cast<size_t>(a)];
      I.Ct(dof % 3, a) = k[dof / 3];
    }
  } else {
    for (Eigen::Index a = 0; a < nm; ++a)
      I.Ct.col(a) = Eigen::Map<const Matrix3X>(basis.modes.col(a).data(), 3, basis.nodes.cols()) * k;
  }

  I.J0 = symmetric(inertia(block(0, 0)));
  I.J1.resize(6, nm);
  I.C0.resize(3, nm);
  for (Eigen::Index a = 0; a < nm; ++a) {
    I.J1.col(a) = 2 * symmetric(inertia(block(0, a + 1)));  // J_k0 + J_0k
    I.C0.col(a) = cross_sum(block(0, a + 1));
  }

  // Symmetry in (k, l) and antisymmetry of C1 hold exactly, not to rounding: one half is computed, the other mirrored.
  I.J2.resize(6 * nm, nm);
  I.C1 = MatrixX::Zero(3 * nm, nm);
  for (Eigen::Index a = 0; a < nm; ++a)
    for (Eigen::Index b = a; b < nm; ++b) {
      const Matrix3 D_ab = block(a + 1, b + 1);
      const Vector6 J = symmetric(inertia(D_ab));
      I.J2.block<6, 1>(6 * a, b) = J;
      I.J2.block<6, 1>(6 * b, a) = J;
      if (a == b) continue;
      const Vector3 c = cross_sum(D_ab);
      I.C1.block<3, 1>(3 * a, b) = c;
      I.C1.block<3, 1>(3 * b, a) = -c;
    }
  I.Mff = MatrixX(basis.modal_mass);
  I.antisymmetric = true;
  return I;
}

InertiaIntegrals leading(const InertiaIntegrals& all, int modes) {
  InertiaIntegrals part = all;
  part.Ct = all.Ct.leftCols(modes).eval();
  part.J1 = all.J1.leftCols(modes).eval();
  part.J2 = all.J2.topLeftCorner(6 * modes, modes).eval();
  part.C0 = all.C0.leftCols(modes).eval();
  part.C1 = all.C1.topLeftCorner(3 * modes, modes).eval();
  part.Mff = all.Mff.topLeftCorner(modes, modes).eval();
  return part;
}

}  // namespace lithe
