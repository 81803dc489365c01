#pragma once

#include <vector>

#include "bodies/beam/beam_section.h"

namespace lithe {

/// Stress at a point of a section, Pa, section axes.
struct SectionStress {
  double normal = 0;                // σ11
  double shear_2 = 0, shear_3 = 0;  // σ12, σ13
  double von_mises() const;
};

/// The shape of a section of one isotropic material, centred on the beam's axis: its stiffness and mass, and the stress
/// at any of its points from the resultants of a beam.
///   const SectionShape tube = SectionShape::tube(0.04, 0.05);
///   auto& mast = graph.add<Beam>("mast", {.axis = line, .sections = {{0, tube.section(steel)}}});
///   tube.stress(mast.resultants(state, 0), 0, 0.05).von_mises();
/// Normal stress: Navier. Shear by torsion: Saint-Venant (Timoshenko & Goodier, Theory of Elasticity, ch. 10), of an I
/// the thin-walled formula. Shear by a transverse force: in equilibrium with the bending stress and along the rim;
/// Poisson's ratio is left out of it. Far from supports and loads.
class SectionShape {
 public:
  // Sizes as in BeamSection, m; SceneError for one that is not above zero.
  static SectionShape rectangle(double edge_2, double edge_3);
  static SectionShape circle(double radius) { return ellipse(radius, radius); }
  static SectionShape tube(double inner, double outer);
  static SectionShape ellipse(double half_axis_2, double half_axis_3);
  static SectionShape i_beam(const BeamSection::I& size);

  BeamSection section(const Material& material) const;
  /// From (n, m), N and N m, at the point (x_2, x_3), m. SceneError for a point outside the section.
  SectionStress stress(const Vector6& resultants, double x_2, double x_3) const;
  bool contains(double x_2, double x_3) const;
  /// Corners along the rim, from axis 2 to axis 3; of a round one as many as given, and of a tube the outer rim alone.
  std::vector<std::array<double, 2>> outline(int corners) const;
  /// Points where the stress may be largest: of the rim, and of the web.
  std::vector<std::array<double, 2>> critical_points() const;
  /// Largest von Mises stress at these, Pa.
  double largest_von_mises(const Vector6& resultants) const;

 private:
  enum class Kind { rectangle, ellipse, tube, i_beam };
  SectionShape(Kind kind, double a, double b, const BeamSection::I& size = {});
  SectionStress torsion(double moment, double x_2, double x_3) const;
  SectionStress shear(double force_2, double force_3, double x_2, double x_3) const;

  Kind kind_;
  double a_, b_;  // edges; half axes; inner and outer radius
  BeamSection::I size_;
  double area_, I2_, I3_, torsion_constant_;
};

}  // namespace lithe
