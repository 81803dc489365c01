#pragma once

#include <array>

#include "bodies/material.h"
#include "engine/base/math.h"

namespace lithe {

/// A cross-section of a beam: stiffness and mass per length. Section axes: 1 along the beam, 2 and
/// 3 in the section, origin on the beam's axis, SI units.
///   strains ε = (Γ1, Γ2, Γ3, K1, K2, K3): axial, two shears; torsion, two bendings, from the drawn shape
///   stress resultants (n, m) = stiffness · (ε + damping ∘ ε̇)        N, N m
///   momenta per length = mass · (velocity, angular velocity) of the section, in its axes
/// Matrices are full: offsets of centroid, shear and mass centre, and couplings of a composite, are their
/// off-diagonals.
struct BeamSection {
  Matrix6 stiffness = Matrix6::Zero();  // N (translations), N m, N m² (rotations); symmetric positive definite
  Matrix6 mass = Matrix6::Zero();       // kg/m, kg, kg m: [μ E, -μ c~; μ c~, J], c mass centre, J about the origin
  Vector6 damping = Vector6::Zero();    // Kelvin-Voigt times, s, one a strain

  /// Uncoupled: (EA, GA2, GA3, GJ, EI2, EI3), mass per length (kg/m), mass moments per length about axes 1, 2, 3 (kg
  /// m). EI2 resists rotation about axis 2, so displacement along 3. GA with the shear factor in it.
  static BeamSection diagonal(const Vector6& stiffness, double mass, const Vector3& inertia);

  // Shapes, centred, of one material (Young's modulus, Poisson's ratio and density); sizes in m. Each throws SceneError
  // for a size, modulus or density that is not above zero and for a Poisson's ratio outside [0, 0.5]. Shear factors:
  // Cowper, J. Appl. Mech. 33 (1966) 335.

  /// Full edges along axes 2 and 3; torsion by Saint-Venant's series (Timoshenko & Goodier, art. 109).
  static BeamSection rectangle(double edge_2, double edge_3, const Material& material);
  static BeamSection circle(double radius, const Material& material);
  /// 0 < inner < outer radius.
  static BeamSection tube(double inner, double outer, const Material& material);
  /// Half axes along 2 and 3.
  static BeamSection ellipse(double half_axis_2, double half_axis_3, const Material& material);
  struct I {
    double height;  // along axis 3, outside
    double width;   // of both flanges, along axis 2
    double web;     // thickness, along axis 2
    double flange;  // thickness, along axis 3
  };
  /// Thin-walled formulas: torsion Σ b t³/3 without warping; shear along the flanges is carried by these alone.
  static BeamSection i_beam(const I& size, const Material& material);

  /// Its origin at (offset_2, offset_3) from the beam's axis, in section axes, m.
  BeamSection moved(double offset_2, double offset_3) const;
  /// Turned about axis 1, from 2 towards 3, rad.
  BeamSection turned(double angle) const;
  /// The same with one Kelvin-Voigt time for all strains, s.
  BeamSection damped(double time) const;

  /// Throws SceneError for values that are not finite, a stiffness that is not symmetric positive definite, a mass of
  /// another form than above or of no real section (mass per length <= 0, negative inertia about the mass centre), and
  /// a negative damping time. `which` names the section in the message.
  void check(const std::string& which) const;

  double mass_per_length() const { return mass(0, 0); }
  Vector3 mass_center() const;  // in section axes, m
  /// Edges along axes 2 and 3 (m) of the rectangle with its mass and inertia about the mass centre, to draw it; at
  /// least `thinnest`.
  std::array<double, 2> edges(double thinnest) const;
};

/// Between two sections, linear in every entry: `share` of the second.
BeamSection between(const BeamSection& first, const BeamSection& second, double share);

}  // namespace lithe
