#pragma once

#include <cmath>
#include <limits>
#include <optional>

namespace lithe {

/// What a pair of involute gears is cut by: one basic rack for both, in their normal section. Lengths with "factor" are
/// in modules.
struct GearDesign {
  double module = 0;                           // m_n, normal, m
  double teeth_A = 0, teeth_B = 0;             // z; of a ring gear negative (B alone); of a rack kRackTeeth (B alone)
  double pressure_angle = 0.3490658503988659;  // α_n, rad: 20°
  double helix_angle = 0;                      // β, rad; > 0: A is right-handed
  double shift_A = 0, shift_B = 0;             // profile shift factors x
  double shortening_A = 0, shortening_B = 0;   // of the tips, factors: a ring's tips want some 0.2 to 0.5
  double face_width = 0;                       // b in common, m
  std::optional<double> centre_distance{};     // a, m; none: without backlash by the shifts. Of a rack: its datum line
  double backlash = 0;                         // thinner teeth: play along the line of action in addition, m
  double addendum = 1, dedendum = 1.25;        // factors of the basic rack
};
inline constexpr double kRackTeeth = std::numeric_limits<double>::infinity();

/// One gear of a pair, transverse section. Radii of a ring gear are negative, as its number of teeth; those of a rack
/// are not finite.
struct InvoluteGear {
  double teeth = 0, shift = 0;
  double pitch_radius = 0, base_radius = 0, tip_radius = 0, root_radius = 0;  // r, r_b, r_a, r_f, m
  double working_radius = 0;                                                  // r_w: pitch circle at work, m
  double tooth_thickness = 0, tip_thickness = 0;                              // along the working and the tip circle, m
  double undercut_teeth = 0;  // z below which a tooth of this shift is undercut
};

/// Geometry of an involute pair, spur or helical, external or internal, or of a gear on a rack; a value, checked.
///   inv α_w0 = inv α_t + 2 (x_A + x_B)/(z_A + z_B) tan α_n   without backlash,   cos α_w = (r_bA + r_bB)/a
///   j_bt = 2 (r_bA + r_bB) (inv α_w - inv α_w0) + backlash        inv α = tan α - α
/// (DIN 3960:1987, ISO 21771:2007; signs of z, r and a of a ring gear as there)
class GearGeometry {
 public:
  /// Throws SceneError, with the figure and the fix, for parameters out of bounds, undercut or pointed teeth, centres
  /// too near (teeth overlap), a contact ratio below one, and tips that meet the fillets or, of an internal pair, each
  /// other.
  explicit GearGeometry(const GearDesign& design);

  const GearDesign& design() const { return design_; }
  InvoluteGear A, B;
  double transverse_module = 0, transverse_pressure_angle = 0;  // m_t, m; α_t, rad
  double working_pressure_angle = 0;                            // α_wt, rad
  double base_helix_angle = 0;                                  // β_b, rad
  double base_pitch = 0;                                        // p_bt, m
  double centre_distance = 0;                                   // a, m; of an internal pair negative
  double backlash = 0;                                          // j_bt, along the line of action, m
  double approach = 0, recess = 0;              // path of contact before and behind the pitch point where A drives, m
  double contact_ratio = 0, overlap_ratio = 0;  // ε_α, ε_β

  /// Half the play between flanks along the line of action where the centres are `apart`, m (> 0); negative: they
  /// overlap. S: a number, or one with derivatives.
  template <class S>
  S half_play(const S& apart) const {
    using std::acos, std::tan;
    if (is_rack())
      return (apart - (A.pitch_radius + A.shift * design_.module)) * std::sin(transverse_pressure_angle) +
             0.5 * design_.backlash;
    const double r_b = A.base_radius + B.base_radius;
    const S angle = acos(std::abs(r_b) / apart);
    return r_b * (tan(angle) - angle - tight_involute_) + 0.5 * design_.backlash;
  }
  bool is_rack() const { return B.teeth == kRackTeeth; }
  bool is_internal() const { return B.teeth < 0; }
  /// Of the circle of radius r (signed, as the gear's), m.
  double tooth_thickness(const InvoluteGear& gear, double r) const;

 private:
  void place_centres();
  void check_teeth() const;
  void check_mesh() const;

  GearDesign design_;
  double tight_involute_ = 0;  // inv α_w0
};

double involute(double angle);  // inv α = tan α - α

}  // namespace lithe
