#pragma once

#include <memory>
#include <string>
#include <vector>

#include "bodies/flexible/modal_basis.h"

namespace lithe {

/// A reduced flexible body as Standard Input Data: the text that FEMBS, Abaqus and Simpack exchange (.SID_FEM;
/// O. Wallrapp, Standardization of flexible body modeling in multibody system codes, Mech. Struct. Mach. 22, 1994).
/// Tables of Taylor series, m0(row, column) and m1(row, mode, column), in the axes of the body frame, against the
/// inertia integrals of docs/equations.md 2.3 and the terms of 3.2 (k, l modes; all else zero):
///   mdCM = s0 + η_k Ct_k   J = J0 + η_k J1_k   Ct = Ctᵀ   Cr = C0ᵀ + η_k C1_kᵀ   Me = Mff   Ke = K^   De
///   Gr_k = J1_k - C0_k~    row l of Ge_k = (C1_k e_l - C1_l e_k)ᵀ
///   row k of Oe = -½ J1_k - η_l J2_kl as coefficients of ω_x², ω_y², ω_z², ω_x ω_y, ω_y ω_z, ω_x ω_z
/// Columns of Gr and Ge go by axes (column nm axis + k), as FEMBS and Abaqus write them, or by modes (3 k + axis), as
/// scripts after Schwertassek & Wallrapp do: whichever agrees with the other tables; written by axes.
/// Nodes: origin, phi = B_i, psi = rotations, AP.
struct SidBody {
  std::shared_ptr<const ModalBasis> basis;  // nodal_mass has no entry: the file does not tell it
  std::vector<std::string> mode_names;      // "Eigen Mode 7 : 51.626 Hz"
  std::vector<std::string> notes;           // what was left out, and tables that contradict each other a little
};

/// J2 is what Oe holds, so that centrifugal stiffening a writer has put there is kept. FileError naming file:line for
/// what is malformed, incomplete, or given twice; for entries outside their table; for tables that contradict each
/// other by more than 2 % of their largest entry (lumped and consistent inertia in one file differ by some 0.5 %; those
/// differences become notes); for a mass matrix that is not positive definite, a preload (ksigma), K^ indefinite.
SidBody read_sid(const std::string& path);

/// Seventeen digits: reading gives the same numbers. SceneError for a nodal basis, one without integrals, or one with a
/// quadratic deflection, which the format cannot say; FileError if the file cannot be written.
void write_sid(const std::string& path, const ModalBasis& basis);

}  // namespace lithe
