#include "joints/gears/gear_geometry.h"

#include <numbers>
#include <string>

#include "engine/base/checks.h"

namespace lithe {
namespace {

std::string millimetres(double length) { return std::to_string(1e3 * length) + " mm"; }

void check_gear_bounds(const GearDesign& d) {
  require::positive(d.module, "module");
  require::positive(d.face_width, "face_width");
  require::positive(d.addendum, "addendum");
  require::not_negative(d.backlash, "backlash");
  require::not_negative(d.shortening_A, "shortening_A");
  require::not_negative(d.shortening_B, "shortening_B");
  require::finite(d.shift_A, "shift_A");
  require::finite(d.shift_B, "shift_B");
  if (d.centre_distance) require::positive(*d.centre_distance, "centre_distance");
  if (!(d.dedendum > d.addendum))
    throw SceneError("dedendum is " + std::to_string(d.dedendum) + ", which leaves no clearance at an addendum of " +
                         std::to_string(d.addendum),
                     "", "give a larger one, such as 1.25 for an addendum of 1");
  if (!(d.pressure_angle > 0.1 && d.pressure_angle < 0.8))
    throw SceneError("pressure_angle is " + std::to_string(d.pressure_angle) + " rad", "",
                     "give one from 0.1 to 0.8 rad, such as 0.349 for 20 degrees");
  if (!(std::abs(d.helix_angle) < 1.2))
    throw SceneError("helix_angle is " + std::to_string(d.helix_angle) + " rad", "", "give one below 1.2 rad");
  if (!(d.teeth_A >= 4) || std::isinf(d.teeth_A))
    throw SceneError("teeth_A is " + std::to_string(d.teeth_A), "",
                     "give four teeth or more; a ring gear or rack is B");
  if (!(std::abs(d.teeth_B) >= 4) || d.teeth_B == -kRackTeeth)
    throw SceneError("teeth_B is " + std::to_string(d.teeth_B), "",
                     "give four teeth or more, those of a ring gear negative");
  if (d.teeth_B < 0 && !(-d.teeth_B > d.teeth_A))
    throw SceneError(
        "a ring gear of " + std::to_string(-d.teeth_B) + " teeth does not take in one of " + std::to_string(d.teeth_A),
        "", "give the ring more teeth");
  if (d.teeth_B == kRackTeeth && d.shift_B != 0)
    throw SceneError("shift_B is that of a rack", "", "leave it out and move the rack: centre_distance");
}

/// α of inv α = y.
double inverse_involute(double y) {
  double angle = std::cbrt(3 * y);
  for (int i = 0; i < 50; ++i) {
    const double tangent = std::tan(angle), change = (tangent - angle - y) / (tangent * tangent);
    angle -= change;
    if (std::abs(change) < 1e-15) break;
  }
  return angle;
}

InvoluteGear cut_gear(const GearDesign& d, double teeth, double shift, double shortening, double m_t, double alpha_t) {
  InvoluteGear g;
  g.teeth = teeth, g.shift = shift;
  g.pitch_radius = 0.5 * m_t * teeth;
  g.base_radius = g.pitch_radius * std::cos(alpha_t);
  g.tip_radius = g.pitch_radius + d.module * (d.addendum + shift - shortening);
  g.root_radius = g.pitch_radius - d.module * (d.dedendum - shift);
  g.undercut_teeth = 2 * (d.addendum - shift) * std::cos(d.helix_angle) / std::pow(std::sin(alpha_t), 2);
  return g;
}

}  // namespace

double involute(double angle) { return std::tan(angle) - angle; }

GearGeometry::GearGeometry(const GearDesign& design) : design_(design) {
  check_gear_bounds(design);
  const double beta = design.helix_angle;
  transverse_module = design.module / std::cos(beta);
  transverse_pressure_angle = std::atan(std::tan(design.pressure_angle) / std::cos(beta));
  base_helix_angle = std::atan(std::tan(beta) * std::cos(transverse_pressure_angle));
  base_pitch = std::numbers::pi * transverse_module * std::cos(transverse_pressure_angle);
  overlap_ratio = design.face_width * std::abs(std::tan(base_helix_angle)) / base_pitch;
  A = cut_gear(design, design.teeth_A, design.shift_A, design.shortening_A, transverse_module,
               transverse_pressure_angle);
  B = cut_gear(design, design.teeth_B, design.shift_B, design.shortening_B, transverse_module,
               transverse_pressure_angle);
  check_teeth();
  place_centres();

  const double sine = std::sin(working_pressure_angle);
  const auto roll = [](double r, double r_b) { return std::copysign(std::sqrt(r * r - r_b * r_b), r); };
  recess = roll(A.tip_radius, A.base_radius) - A.working_radius * sine;
  approach = is_rack()
                 ? (design.module * (design.addendum - design.shortening_B) - (centre_distance - A.pitch_radius)) / sine
                 : roll(B.tip_radius, B.base_radius) - B.working_radius * sine;
  contact_ratio = (approach + recess) / base_pitch;
  backlash = 2 * half_play(std::abs(centre_distance));
  for (InvoluteGear* g : {&A, &B}) {
    if (std::isinf(g->teeth)) {
      g->tooth_thickness = 0.5 * std::numbers::pi * transverse_module - 0.5 * design.backlash;
      g->tip_thickness = g->tooth_thickness - 2 * design.module * design.addendum * std::tan(transverse_pressure_angle);
      continue;
    }
    g->tooth_thickness = tooth_thickness(*g, g->working_radius);
    g->tip_thickness = tooth_thickness(*g, g->tip_radius);
  }
  check_mesh();
}

double GearGeometry::tooth_thickness(const InvoluteGear& gear, double r) const {
  const double angle = std::acos(std::min(1.0, gear.base_radius / r));
  const double half = (0.5 * std::numbers::pi + 2 * gear.shift * std::tan(design_.pressure_angle)) / gear.teeth +
                      involute(transverse_pressure_angle) - involute(angle) - design_.backlash / (4 * gear.base_radius);
  return 2 * r * half;
}

/// Centre distance, working circles and tips, shortened where shifts bring them near the other's root.
void GearGeometry::place_centres() {
  if (is_rack()) {
    working_pressure_angle = transverse_pressure_angle;
    A.working_radius = A.pitch_radius;
    centre_distance = design_.centre_distance.value_or(A.pitch_radius + A.shift * design_.module);
    return;
  }
  const double z = A.teeth + B.teeth, r_b = A.base_radius + B.base_radius, sign = z < 0 ? -1 : 1;
  tight_involute_ =
      involute(transverse_pressure_angle) + 2 * (A.shift + B.shift) / z * std::tan(design_.pressure_angle);
  if (!(tight_involute_ > 0))
    throw SceneError("the shifts " + std::to_string(A.shift) + " and " + std::to_string(B.shift) +
                         " let these gears mesh at no centre distance",
                     "", "give shifts of a larger sum (of an internal pair: of a smaller one)");
  const double tight = std::abs(r_b) / std::cos(inverse_involute(tight_involute_));
  const double apart = design_.centre_distance.value_or(tight);
  if (apart <= std::abs(r_b) || half_play(apart) < -1e-9 * design_.module)
    throw SceneError("the centre distance of " + millimetres(apart) + " makes teeth overlap: without backlash it is " +
                         millimetres(tight),
                     "",
                     is_internal() ? "bring the centres nearer, or give a backlash or other shifts"
                                   : "move the centres apart, or give a backlash or smaller shifts");
  centre_distance = sign * apart;
  working_pressure_angle = std::acos(std::abs(r_b) / apart);
  for (InvoluteGear* g : {&A, &B}) g->working_radius = g->base_radius / std::cos(working_pressure_angle);
  if (is_internal()) return;
  const double shorter = centre_distance - A.pitch_radius - B.pitch_radius - design_.module * (A.shift + B.shift);
  for (InvoluteGear* g : {&A, &B}) g->tip_radius += std::min(0.0, shorter);
}

void GearGeometry::check_teeth() const {
  const auto check = [&](const InvoluteGear& g, const std::string& name) {
    if (g.teeth < 0 || std::isinf(g.teeth)) return;  // shaped by another tool
    if (g.teeth < std::floor(g.undercut_teeth))
      throw SceneError(
          "teeth_" + name + " is " + std::to_string(g.teeth) + ": below " + std::to_string(g.undercut_teeth) +
              " the rack undercuts teeth of the shift " + std::to_string(g.shift),
          "",
          "give shift_" + name + " of at least " +
              std::to_string(design_.addendum - 0.5 * g.teeth * std::pow(std::sin(transverse_pressure_angle), 2) /
                                                    std::cos(design_.helix_angle)) +
              ", or more teeth");
    const double thickness = tooth_thickness(g, g.tip_radius);
    if (thickness <= 0)
      throw SceneError("teeth of " + name + " are pointed: " + millimetres(thickness) + " thick at their tips", "",
                       "give a smaller shift_" + name + ", a larger shortening_" + name + " or more teeth");
  };
  check(A, "A"), check(B, "B");
  if (is_internal() && std::abs(B.tip_radius) < std::abs(B.base_radius))
    throw SceneError("the ring's tips reach within its base circle: " + millimetres(-B.tip_radius) + " of " +
                         millimetres(-B.base_radius),
                     "", "give the ring more teeth, a larger shortening_B or a smaller shift_B");
}

void GearGeometry::check_mesh() const {
  if (backlash < -1e-9 * design_.module)
    throw SceneError(
        "teeth overlap by " + millimetres(-backlash) + " at a centre distance of " +
            millimetres(std::abs(centre_distance)),
        "", "move the rack away by at least " + millimetres(-0.5 * backlash / std::sin(working_pressure_angle)));
  if (!(contact_ratio >= 1))
    throw SceneError("the contact ratio is " + std::to_string(contact_ratio) + ": teeth part before the next ones meet",
                     "", "give more teeth, a larger addendum, or a centre distance nearer to that without backlash");
  // The other's tip must not come below the involute, which the rack's straight flank ends at.
  const double sine_t = std::sin(transverse_pressure_angle), sine = std::sin(working_pressure_angle);
  const auto check_fillet = [&](const InvoluteGear& g, double reach, const std::string& name, const std::string& tip) {
    const double lowest = g.working_radius * sine - reach;
    const double form = g.pitch_radius * sine_t - (design_.addendum - g.shift) * design_.module / sine_t;
    if (lowest < std::max(0.0, form) - 1e-3 * design_.module)
      throw SceneError("tips of " + tip + " meet the fillets of " + name + ": contact would begin " +
                           millimetres(std::max(0.0, form) - lowest) + " below the involute",
                       "", "give " + name + " more teeth or a larger shift, or a shortening_" + tip);
  };
  check_fillet(A, approach, "A", "B");
  if (!is_internal() && !is_rack()) check_fillet(B, recess, "B", "A");
  if (!is_internal()) return;
  // Where the tip circles cross, the pinion's tip must not have met the ring's (Colbourne 1987, section 5.4).
  const double a = -centre_distance, r_A = A.tip_radius, r_B = -B.tip_radius;
  const double cosine = (r_B * r_B - r_A * r_A - a * a) / (2 * a * r_A);
  if (cosine >= 1) return;  // they do not cross
  const double at_A = std::acos(cosine), at_B = std::acos((a * a + r_B * r_B - r_A * r_A) / (2 * a * r_B));
  const double inv = involute(working_pressure_angle), inv_A = involute(std::acos(A.base_radius / r_A)),
               inv_B = involute(std::acos(-B.base_radius / r_B));
  const double play = A.teeth / -B.teeth * (at_A + inv_A - inv) + inv - inv_B - at_B;
  if (play < 0)
    throw SceneError(
        "the tips of A and of the ring meet off the line of action: they overlap by " + millimetres(-play * r_B), "",
        "give the ring more teeth than A, by about ten at least, or a larger shortening of its tips");
}

}  // namespace lithe
