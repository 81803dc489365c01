#pragma once

#include "bodies/flexible/modal_basis.h"
#include "engine/model/marker.h"

namespace lithe {

/// columns += A ∂w/∂η for A of one column a pair; A ∂w/∂η is linear in η.
template <class Columns>
void add_pair_columns(const MatrixX& A, const double* eta, Columns& columns) {
  Eigen::Index p = 0;  // ∂w_kl/∂η_k = η_l, ∂w_kk/∂η_k = η_k
  for (Eigen::Index l = 0; l < columns.cols(); ++l) {
    for (Eigen::Index k = 0; k < l; ++k, ++p) {
      columns.col(k) += eta[l] * A.col(p);
      columns.col(l) += eta[k] * A.col(p);
    }
    columns.col(l) += eta[l] * A.col(p++);
  }
}

/// Where the coordinates of all displacement fields are for given modal coordinates, ξ(η), and what follows from it.
struct DeflectionTerms {
  VectorX xi, xi_rate;  // ξ, ξ̇ = P η̇
  VectorX xi_bias;      // ξ̈ = P η̈ + xi_bias
  MatrixX P, P_rate;    // ∂ξ/∂η, fields x nm, and its rate
  VectorX force;        // ∂V/∂η beyond K^ η
  MatrixX stiffness;    // ∂²V/∂η² beyond K^
  MatrixX loaded;       // scratch: geometric stiffness under the fields' loads
  double energy = 0;    // V beyond ½ ηᵀ K^ η

  VectorX pairs, rate_pairs;             // w of η and of η̇
  VectorX pair_force;                    // Q w
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
  int pair_count() const { return static_cast<int>(curvature_.cols()); }
  const MatrixX& curvature() const { return curvature_; }

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
