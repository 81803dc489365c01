#pragma once

#include "bodies/flexible/reduction.h"
#include "engine/math.h"

namespace lithe {

/// The inertia invariants of a floating-frame body (EQUATIONS.md 2.3): all that M and f_v need, independent of the
/// number of nodes. Symmetric 3x3 matrices are stored as (xx yy zz xy xz yz). k, l run over modes.
struct InertiaIntegrals {
  double mass = 0;
  Vector3 s0 = Vector3::Zero();  // first moment, kg m
  Matrix3X Ct;                   // 3 x nm, Phiᵀ S B
  Vector6 J0 = Vector6::Zero();  // inertia about the frame origin
  Matrix6X J1;                   // 6 x nm, column k = J1_k
  MatrixX J2;                    // (6 nm) x nm, rows 6k..6k+5 of column l = J2_kl
  Matrix3X C0;                   // 3 x nm
  MatrixX C1;                    // (3 nm) x nm, rows 3k..3k+2 of column l = C1_k e_l
  MatrixX Mff;                   // nm x nm
  bool antisymmetric = true;     // C1_k e_l = -C1_l e_k (scalar interpolation)

  int mode_count() const { return static_cast<int>(Ct.cols()); }
};

/// From nodes, scalar mass m_ij and modes: sparse m times [r0 B], then (nm+1)² dot products.
InertiaIntegrals inertia_integrals(const ModalBasis& basis);

/// From any nodal mass S (3n x 3n) whose row sums obey eqs. (19)-(20), blocks S_ij not multiples of E
/// (EQUATIONS.md 2.4). nodes 3 x n and B 3n x nm in body axes. Dense in 3n x 3 (nm + 1): for small meshes.
InertiaIntegrals inertia_integrals(const Matrix3X& nodes, const SparseMatrix& S, const MatrixX& B);

}  // namespace lithe
