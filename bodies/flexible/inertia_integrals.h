#pragma once

#include "bodies/flexible/modal_basis.h"
#include "engine/base/math.h"

namespace lithe {

/// From nodes, scalar mass m_ij and modes: sparse m times [r0 B], then (nm+1)² dot products.
InertiaIntegrals inertia_integrals(const ModalBasis& basis);

/// From any nodal mass S (3n x 3n) whose row sums obey eqs. (19)-(20), blocks S_ij not multiples of E
/// (docs/equations.md 2.4). nodes 3 x n and B 3n x nm in body axes. Dense in 3n x 3 (nm + 1): for small meshes.
InertiaIntegrals inertia_integrals(const Matrix3X& nodes, const SparseMatrix& S, const MatrixX& B);

/// The same of the first `modes` modes alone.
InertiaIntegrals leading(const InertiaIntegrals& all, int modes);

}  // namespace lithe
