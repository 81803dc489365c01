#pragma once

#include <functional>

#include "engine/model/motion_law.h"

namespace lithe::lab {

/// A geometrically exact beam in its plane (Reissner 1972; Simo & Vu-Quoc 1986), clamped to a hub of no radius that
/// turns as prescribed: shear, stretch and bending of any size. One spectral element (Gauss-Lobatto points, diagonal
/// mass) in the hub's axes, by classical Runge-Kutta.
struct ExactBeam {
  double length, axial, shear, bending;  // m; EA, GA_s in N; EI in N m²
  double line, rotary;                   // ρA in kg/m, ρI in kg m

  /// The smallest deflection of the tip across the hub's axis up to `end` (s), with elements of `degree`.
  double smallest_deflection(const std::function<Motion(double time)>& hub, double end, int degree) const;
};

}  // namespace lithe::lab
