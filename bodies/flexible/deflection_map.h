#pragma once

#include "bodies/flexible/modal_basis.h"
#include "engine/marker.h"

namespace lithe {

/// Where the coordinates of all displacement fields are for given modal coordinates, ξ(η), and what follows from it.
struct DeflectionTerms {
  VectorX xi, xi_rate;  // ξ, ξ̇ = P η̇
  VectorX xi_bias;      // ξ̈ = P η̈ + xi_bias
  MatrixX P;            // ∂ξ/∂η, fields x nm
  VectorX force;        // ∂V/∂η beyond K^ η
  MatrixX stiffness;    // ∂²V/∂η² beyond K^
  MatrixX loaded;       // scratch: geometric stiffness under the fields' loads
  double energy = 0;    // V beyond ½ ηᵀ K^ η

  VectorX pairs, pair_force;             // w; Q w
  VectorX acceleration;                  // scratch: ξ̈, then the generalized force on ξ
  Matrix3X Ct, Cr, G_omega, u, Cr_rate;  // InertiaTerms' columns times P

  DeflectionTerms(int fields, int modes);
};

/// The map η → ξ of a quadratic deflection, for the first modes of a basis. No allocation in its evaluation.
class DeflectionMap {
 public:
  /// Modes beyond the first `modes` stay as fields: they only move with the square of η.
  DeflectionMap(const QuadraticDeflection& deflection, int modes);
  int field_count() const { return static_cast<int>(curvature_.rows()); }
  int mode_count() const { return modes_; }

  void evaluate(const double* eta, const double* eta_rate, Level level, DeflectionTerms& terms) const;
  /// ξ(η) alone.
  VectorX coordinates(const VectorX& eta) const;
  /// Σ_j force_j C_j: what loads on the fields add to the tangent.
  void geometric_stiffness(const VectorX& force, MatrixX& stiffness) const;

 private:
  int modes_;
  MatrixX curvature_, quartic_;
};

}  // namespace lithe
