#pragma once

#include "bodies/flexible/modal_basis.h"

namespace lithe {

// Columns of Oe are ω_x², ω_y², ω_z², ω_x ω_y, ω_y ω_z, ω_x ω_z; ours are xx yy zz xy xz yz. Off the diagonal ω·Jω
// counts each entry twice.
inline constexpr int kOeColumn[] = {0, 1, 2, 3, 5, 4};
inline constexpr double kOeWeight[] = {0.5, 0.5, 0.5, 1, 1, 1};

/// xx yy zz xy xz yz and the matrix; packing takes the symmetric part.
Matrix3 full_inertia(const Vector6& s);
Vector6 packed_inertia(const Matrix3& a);

/// Gr (3 x 3nm), Ge (nm x 3nm), both by modes, and m0 of Oe (nm x 6) as the integrals imply them (sid.h).
MatrixX gyroscopic_of_rotation(const InertiaIntegrals& I);
MatrixX gyroscopic_of_modes(const InertiaIntegrals& I);
/// Gr and Ge are stored by axes, column nm axis + k, in files of FEMBS and Abaqus; by modes, column 3 k + axis, in
/// others and above.
MatrixX by_axes(const MatrixX& by_modes);
MatrixX by_modes(const MatrixX& by_axes);
MatrixX centrifugal(const InertiaIntegrals& I);

}  // namespace lithe
