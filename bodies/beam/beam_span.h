#pragma once

#include "bodies/beam/beam_section.h"

namespace lithe {

/// A stretch of geometrically exact (Simo-Reissner) beam between two frames whose axes are those of the section: 1
/// along the beam. Its axis is the helix from one to the other, the geodesic H(ξ) = H_A exp(ξ d) of SE(3), 0 <= ξ <= 1:
///   strain   ε = (d - d_0) / L, constant along it,   d = log(H_A⁻¹ H_B)
///   twist    V(ξ) = N_A v_A + N_B v_B = Ad(exp(-ξ d)) v_A + ξ T(ξ d) d_dot,   d_dot = T⁻¹(d) v_B - T⁻¹(-d) v_A
///   energy   ½ L εᵀ C ε + ½ L ∫ Vᵀ M V dξ (Gauss's two points)
/// Rigid motions cancel in d, so strains are objective; pure bending, torsion and stretch are exact at any length;
/// there is no locking. Its error is of second order in L. The same N carries loads to the ends, so that weight,
/// inertia and markers between the ends are consistent with each other.
/// V. Sonneville, A. Cardona, O. Brüls, Comput. Methods Appl. Mech. Engrg. 268 (2014) 451; docs/equations.md 4.6.
/// Twists and wrenches are (translation, rotation) in section axes.
class BeamSpan {
 public:
  using Vector12 = Eigen::Matrix<double, 12, 1>;
  using Matrix12 = Eigen::Matrix<double, 12, 12>;

  /// Throws SceneError, as drawn: ends turned against each other by more than a right angle, a helix between them that
  /// differs from `length` (m) by more than 5 %, axes 1 that do not point from the first to the second.
  BeamSpan(const BeamSection& section, double length, const Vector6& drawn);

  const BeamSection& section() const { return section_; }
  double length() const { return length_; }

  Vector6 strain(const Vector6& d) const { return (d - drawn_) / length_; }
  /// (n, m) = C (ε + damping ∘ ε̇) for an uncoupled section; of a coupled one, row by row of its factor C = Uᵀ D U.
  /// v_A, v_B: the twists of the ends.
  Vector6 resultants(const Vector6& d, const Vector6& v_A, const Vector6& v_B) const;
  double elastic_energy(const Vector6& strain) const { return 0.5 * length_ * strain.dot(section_.stiffness * strain); }

  /// What resultants do at the ends: Pᵀ σ, P = [-T⁻¹(-d), T⁻¹(d)].
  Vector12 internal_forces(const Vector6& d, const Vector6& sigma) const;
  /// Its derivative by small motions of the ends, twists in their axes: stiffness and damping as weighted, and what the
  /// resultants themselves contribute.
  Matrix12 tangent(const Vector6& d, const Vector6& sigma, double position, double velocity) const;

  /// Inertia and weight: ∫ Nᵀ (M V_dot - ad(V)ᵀ M V - M g) dm. gravity_A: in the axes of the first end, m/s².
  Vector12 inertia_forces(const Vector6& d, const Vector6& v_A, const Vector6& v_B, const Vector6& rate_A,
                          const Vector6& rate_B, const Vector3& gravity_A) const;
  Matrix12 mass(const Vector6& d) const;
  /// The derivative of inertia_forces by the twists of the ends, where the ends' frames have no acceleration.
  Matrix12 gyroscopic(const Vector6& d, const Vector6& v_A, const Vector6& v_B) const;
  double kinetic_energy(const Vector6& d, const Vector6& v_A, const Vector6& v_B) const;
  /// ∫ r dm from the first end, in its axes, kg m.
  Vector3 first_moment(const Vector6& d) const;

 private:
  BeamSection section_;
  double length_;
  Vector6 drawn_;    // d as drawn
  Matrix6 damping_;  // Uᵀ D τ U
};

}  // namespace lithe
