#pragma once

#include "bodies/beam/beam_section.h"
#include "engine/assembly/batch.h"
#include "engine/model/appearance.h"
#include "engine/model/force_element.h"

namespace lithe {

/// A stretch of geometrically exact (Simo-Reissner) beam between two frames whose axes are those of the section: 1
/// along the beam. Its axis is the helix from one to the other, the geodesic of SE(3); its strain is constant along it:
///   ε = (log(H_A⁻¹ H_B) - that of the drawing) / L,   V = ½ L εᵀ C ε
/// Rigid motions drop out of H_A⁻¹ H_B, so strains are objective; pure bending, torsion and stretch are exact at any
/// length; nothing locks. As drawn it is free of stress: drawn curvature and twist are those of the undeformed beam.
/// Its error is of second order in L. It turns by less than half a turn from end to end.
/// C = Uᵀ D U (U unit upper triangular) gives six compliant rows with the lengths L U ε and stiffnesses D / L; Kelvin-
/// Voigt damping acts row by row, that is, strain by strain where C is diagonal.
/// V. Sonneville, A. Cardona, O. Brüls, Comput. Methods Appl. Mech. Engrg. 268 (2014) 451; docs/equations.md section
/// 4.6. It has no mass: Beam (bodies/beam/beam.h) makes the bodies that it ties.
class BeamElement final : public Force</*markers=*/2, /*rows=*/6>, public DrawableConnector {
 public:
  struct Parameters {
    BeamSection section;
    double length = 0;  // m, along the axis; 0: that of the helix drawn
  };
  /// Throws SceneError for a section that is none (BeamSection::check) and a negative length; assemble() throws for a
  /// length that differs from that of the helix by more than 5 %, for axes 1 that do not point from A to B, and for
  /// ends turned against each other by more than a right angle.
  explicit BeamElement(Parameters parameters);

  bool depends_on_time() const override { return false; }
  void evaluate(double time, std::span<const MarkerView> markers, ForceRows& rows) const override;
  void initialize(std::span<const MarkerView> markers) override;

  /// (Γ, K): axial strain, shears; torsion, curvatures (1/m), with the drawn ones subtracted.
  Vector6 strain(const MarkerView& A, const MarkerView& B) const;
  /// (n, m) = C ε: what the part behind B does to the part before A, N and N m, axes of the section half-way.
  Vector6 resultants(const MarkerView& A, const MarkerView& B) const { return section_.stiffness * strain(A, B); }
  /// Half of it at either end: the solid bar whose mass and inertia are those of the section.
  std::vector<DrawnShape> drawn_shapes(int marker) const override;
  const BeamSection& section() const { return section_; }
  double length() const { return length_; }  // after assemble()

 private:
  const BeamSection section_;
  double length_;
  Matrix6 rows_;       // U
  Vector6 stiffness_;  // D, without 1 / L
  Vector6 reference_ = Vector6::Zero();
};

extern template std::unique_ptr<ForceBatch> make_force_batch<BeamElement>();

}  // namespace lithe
