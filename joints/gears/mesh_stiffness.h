#pragma once

#include <string>
#include <vector>

#include "engine/base/spline.h"
#include "joints/gears/gear_geometry.h"

namespace lithe {

/// How stiff teeth are.
enum class ToothStiffness {
  weber_banaschek,  // bending, shear and compression of the tooth, its foundation, Hertz's contact
  iso_6336,         // c' and c_γα of ISO 6336-1 method B: a parabola along the path of contact
  table             // given over the mesh cycle
};

/// What the teeth of both gears are made of, for their stiffness.
struct ToothMaterial {
  double youngs_modulus = 2.06e11, poisson_ratio = 0.3;  // E, Pa; ν
  double line_load = 3e5;                                // F/b at which Hertz's contact is linearised, N/m
};

/// What repeats with every pair of teeth, as a function of the phase in mesh cycles (periods of 1): a periodic cubic
/// spline through values at equal distances, the first at phase 0; one value is a constant.
class MeshCycle {
 public:
  /// `what` is named in errors. Throws SceneError for no values, two or three, and one that is not finite.
  MeshCycle(const std::vector<double>& values, const std::string& what);
  /// With derivatives by the phase.
  CubicSpline::Value operator()(double phase) const;

 private:
  CubicSpline spline_;
};

/// Stiffness of one pair of teeth for a line load, N/m², normal section, where it touches `along` the path of contact
/// from the pitch point, m (> 0: recess), per length of the line of contact: 1/c = (δ_A + δ_B + δ_H) b/F with
///   δ_Z b E/(F cos²α') = 12 (1-ν²) ∫₀ᵘ (u-y)²/s³ dy + (2.4 (1+ν) + (1-ν²) tan²α') ∫₀ᵘ dy/s
///   δ_R b E/(F cos²α') = 18 (1-ν²)/π u²/s_f² + 2 (1-ν-2ν²) u/s_f + 4.8 (1-ν²)/π (1 + (1-ν)/2.4 tan²α')
///   δ_H b π E/(2 (1-ν²) F) = ln(4 t_A t_B/b_H²) - ν/(1-ν),   b_H² = 8 (1-ν²) ρ F/(π E b)
/// (Weber & Banaschek 1953). α': of the load against the normal of the tooth's middle line, u: height there over the
/// root, s(y): thickness, t: depth of the middle line under the contact. The root is the section whose fillet, a circle
/// of the basic rack's, leans by 30°; below the base circle flanks are radial.
double tooth_pair_stiffness(const GearGeometry& spur, const ToothMaterial& material, double along);

/// c' of ISO 6336-1:2019 section 8.3 for solid discs, N/m²; a ring gear or rack as one of infinite teeth.
double iso_single_stiffness(const GearGeometry& pair, const ToothMaterial& material);

/// Stiffness of the mesh over its cycle, N/m in the transverse plane along the line of action, at 256 phases; phase 0:
/// a pair at the pitch point. A pair enters and leaves within a twentieth of the cycle; of helical teeth the mean over
/// the face, by the overlap ratio. ISO: pairs of c' (1 - κ x²), x from -1 to 1 along the path, with κ such that the
/// mean is c_γα b = c' (0.75 ε_α + 0.25) b. Weber and Banaschek: helical teeth by their virtual spur gears.
std::vector<double> mesh_stiffness(const GearGeometry& pair, ToothStiffness model, const ToothMaterial& material);

}  // namespace lithe
