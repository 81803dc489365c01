#include "bodies/flexible/inertia_integrals.h"

namespace lithe {

/// docs/equations.md 2.2, 2.4: with Y_k the stack of -psi_k,i~ and psi_0 = r0,
///   J_kl = Y_kᵀ S Y_l,  C0 = Y_0ᵀ S B,  C1_k = Y_kᵀ S B.
InertiaIntegrals inertia_integrals(const Matrix3X& nodes, const SparseMatrix& S, const MatrixX& B) {
  const Eigen::Index n = nodes.cols(), nm = B.cols();
  MatrixX Y(3 * n, 3 * (nm + 1)), Phi(3 * n, 3);
  for (Eigen::Index i = 0; i < n; ++i) {
    Phi.middleRows<3>(3 * i).setIdentity();
    Y.block<3, 3>(3 * i, 0) = -skew(nodes.col(i));
    for (Eigen::Index k = 0; k < nm; ++k) Y.block<3, 3>(3 * i, 3 * (k + 1)) = -skew(B.block<3, 1>(3 * i, k));
  }
  const Eigen::Map<const VectorX> r0(nodes.data(), 3 * n);
  const MatrixX SB = S * B, SPhi = S * Phi, J = Y.transpose() * (S * Y), C = Y.transpose() * SB;
  const auto packed = [](const Matrix3& a) {
    const Matrix3 s = 0.5 * (a + a.transpose());
    return (Vector6() << s(0, 0), s(1, 1), s(2, 2), s(0, 1), s(0, 2), s(1, 2)).finished();
  };

  InertiaIntegrals I;
  I.mass = Phi.col(0).dot(SPhi.col(0));
  I.s0 = SPhi.transpose() * r0;
  I.Ct = SPhi.transpose() * B;
  I.Mff = B.transpose() * SB;
  I.J0 = packed(J.topLeftCorner<3, 3>());
  I.C0 = C.topRows<3>();
  I.C1 = C.bottomRows(3 * nm);
  I.J1.resize(6, nm);
  I.J2.resize(6 * nm, nm);
  for (Eigen::Index k = 0; k < nm; ++k) {
    I.J1.col(k) = 2 * packed(J.block<3, 3>(3 * (k + 1), 0));
    for (Eigen::Index l = 0; l < nm; ++l) I.J2.block<6, 1>(6 * k, l) = packed(J.block<3, 3>(3 * (k + 1), 3 * (l + 1)));
  }
  I.antisymmetric = false;
  return I;
}

}  // namespace lithe
