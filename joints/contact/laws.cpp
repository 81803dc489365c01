#include "joints/contact/laws.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "engine/base/checks.h"

namespace lithe {

namespace contact_laws {
namespace {

/// The part of a vector across the normal.
Vector3 across(const Vector3& x) { return {0, x[1], x[2]}; }

/// tanh(3 |x| / scale) / |x|: what makes x a unit vector, but smoothly through zero.
double softened(double magnitude, double scale) {
  const double ratio = 3 * magnitude / scale;
  return ratio < 1e-4 ? 3 / scale * (1 - ratio * ratio / 3) : std::tanh(ratio) / magnitude;
}

double power(double base, double exponent) {
  if (exponent == 1.5) return base * std::sqrt(base);
  return exponent == 1 ? base : std::pow(base, exponent);
}

double stiffness(const Compliance& normal, double curvature) {
  if (normal.stiffness > 0) return normal.stiffness;
  const bool flat = curvature <= 0;
  if (flat && normal.flat_radius == 0)
    throw SimulationError("Hertz's law gives a flat surface on a flat one no stiffness", "a compliant contact",
                          "give .flat_radius, of the area in touch, or .stiffness instead of .effective_modulus");
  return 4.0 / 3.0 * normal.effective_modulus * std::sqrt(flat ? normal.flat_radius : 1 / curvature);
}

/// x = D v that reaches e: (1 + e) x = ln((1 + x) / (1 - e x)), between 0 and 1/e. In y = 1 - e x, by Newton from the
/// side on which it converges monotonically.
double damping_number(double e) {
  if (e == 1) return 0;
  double x = std::min(1.6 * (1 - e), 1 - 1e-9) / e;  // f > 0, and convex beyond the root: Flores' is above it
  for (int k = 0; k < 60; ++k) {
    const double f = std::log1p(x) - std::log1p(-e * x) - (1 + e) * x;
    const double slope = 1 / (1 + x) + e / (1 - e * x) - (1 + e);
    const double next = x - f / slope;
    if (!(next < x) || x - next < 1e-15 * x) break;
    x = next;
  }
  return x;
}

/// D, s/m.
double damping(const Compliance& normal, const ContactMotion& motion) {
  const double met = motion.impact_speed == 0 ? -motion.velocity[0] : motion.impact_speed;
  const double v = std::max(met, normal.least_speed), e = normal.restitution;
  switch (normal.dissipation) {
    case Dissipation::fixed:
      return normal.damping;
    case Dissipation::hunt_crossley:
      return 1.5 * (1 - e) / v;
    case Dissipation::lankarani_nikravesh:
      return 0.75 * (1 - e * e) / v;
    case Dissipation::flores:
      return 1.6 * (1 - e) / (e * v);
    case Dissipation::exact:
      return damping_number(e) / v;
  }
  return 0;
}

double stribeck(const ContactFriction& friction, double speed) {
  const double kinetic = friction.coefficient, still = std::max(kinetic, friction.static_coefficient);
  if (still == kinetic) return kinetic;
  const double ratio = speed / friction.stribeck_speed;
  return kinetic + (still - kinetic) * std::exp(-ratio * ratio);
}

/// Where a straight slip takes the bristles: dz/ds = ŝ - z / most, most = g / σ₀ the deflection of steady sliding.
///   z = z₀ exp(-a) + s (1 - exp(-a)) / a,   a = |s| / most
Vector3 dragged(const Vector3& deflection, const Vector3& slip, double most) {
  const double a = slip.norm() / most;
  const double share = a > 0 ? -std::expm1(-a) / a : 1;
  return std::exp(-a) * deflection + share * slip;
}

/// `numbers` may not be negative.
void check_numbers(std::initializer_list<std::pair<double, const char*>> numbers) {
  for (const auto& [value, name] : numbers) require::not_negative(value, name);
}

}  // namespace
}  // namespace contact_laws

double effective_modulus(double young_a, double poisson_a, double young_b, double poisson_b) {
  require::positive(young_a, "young_a");
  require::positive(young_b, "young_b");
  for (double poisson : {poisson_a, poisson_b})
    if (!(poisson > -1 && poisson <= 0.5))
      throw SceneError("Poisson's ratio is " + std::to_string(poisson), "", "give one above -1, at most 0.5");
  return 1 / ((1 - poisson_a * poisson_a) / young_a + (1 - poisson_b * poisson_b) / young_b);
}

void check(const Compliance& normal) {
  contact_laws::check_numbers({{normal.stiffness, "stiffness"},
                               {normal.effective_modulus, "effective_modulus"},
                               {normal.flat_radius, "flat_radius"},
                               {normal.restitution, "restitution"},
                               {normal.damping, "damping"}});
  require::positive(normal.least_speed, "least_speed");
  require::finite(normal.exponent, "exponent");
  if (normal.exponent < 1)
    throw SceneError("exponent is " + std::to_string(normal.exponent), "", "give 1 (linear), 1.5 (Hertz) or more");
  if ((normal.stiffness > 0) == (normal.effective_modulus > 0))
    throw SceneError("a compliant contact needs one of stiffness and effective_modulus", "",
                     "give .stiffness in N/mⁿ, or .effective_modulus = effective_modulus(E_a, ν_a, E_b, ν_b)");
  if (normal.stiffness == 0 && normal.exponent != 1.5)
    throw SceneError("exponent is " + std::to_string(normal.exponent) + ", but Hertz's is 1.5", "",
                     "leave it out, or give .stiffness instead of .effective_modulus");
  if (normal.restitution > 1)
    throw SceneError("restitution is " + std::to_string(normal.restitution), "", "give a value from 0 to 1");
  const bool any = normal.dissipation == Dissipation::flores || normal.dissipation == Dissipation::exact;
  if (any && normal.restitution == 0)
    throw SceneError("restitution is 0, which needs infinite damping", "",
                     "give a small value such as 0.05, or .dissipation = Dissipation::fixed and .damping");
  if (normal.dissipation != Dissipation::fixed && normal.damping > 0)
    throw SceneError("damping is given, but the law takes its own from the restitution", "",
                     "give .dissipation = Dissipation::fixed too, or leave .damping out");
}

void check(const ContactFriction& friction) {
  contact_laws::check_numbers({{friction.coefficient, "coefficient"},
                               {friction.static_coefficient, "static_coefficient"},
                               {friction.bristle_stiffness, "bristle_stiffness"},
                               {friction.bristle_damping, "bristle_damping"},
                               {friction.viscous, "viscous"},
                               {friction.rolling, "rolling"},
                               {friction.spinning, "spinning"}});
  require::positive(friction.stribeck_speed, "stribeck_speed");
  require::positive(friction.creep_speed, "creep_speed");
  require::positive(friction.creep_spin, "creep_spin");
  if (friction.static_coefficient > 0 && friction.static_coefficient < friction.coefficient)
    throw SceneError("static_coefficient is below coefficient", "", "give at least as much, or zero: the same");
  if (friction.bristle_stiffness > 0 && friction.coefficient == 0)
    throw SceneError("bristles without friction", "", "give .coefficient, or leave .bristle_stiffness out");
  if (friction.bristle_damping > 0 && friction.bristle_stiffness == 0)
    throw SceneError("bristle_damping without bristles", "", "give .bristle_stiffness, or leave it out");
}

ContactLoad compliant_load(const Compliance& normal, const ContactFriction& friction, const ContactMotion& motion) {
  using namespace contact_laws;
  ContactLoad load{.force = Vector3::Zero(), .moment = Vector3::Zero(), .energy = 0, .bristle = Vector3::Zero()};
  if (motion.gap >= 0) return load;

  // along the normal: elastic part, and its share that motion takes; surfaces do not pull
  const double depth = -motion.gap;
  const double elastic = stiffness(normal, motion.curvature) * power(depth, normal.exponent);
  const double pushed = elastic * (1 - damping(normal, motion) * motion.velocity[0]);
  const double N = pushed < 0 ? 0 : pushed;  // NaN stays NaN
  load.force[0] = N;
  load.energy = elastic * depth / (normal.exponent + 1);

  // across it
  const Vector3 v = across(motion.velocity);
  const double speed = v.norm(), mu = stribeck(friction, speed);
  if (friction.bristle_stiffness > 0) {
    const double most = mu / friction.bristle_stiffness;
    load.bristle = dragged(across(motion.bristle), across(motion.slip), most);
    const Vector3 rate = v - speed / most * load.bristle;
    load.force -= N * (friction.bristle_stiffness * load.bristle + friction.bristle_damping * rate);
  } else {
    load.force -= N * mu * softened(speed, friction.creep_speed) * v;
  }
  load.force -= N * friction.viscous * v;

  // against rolling and spinning
  const Vector3 rolling = across(motion.spin);
  load.moment = -N * friction.rolling * softened(rolling.norm(), friction.creep_spin) * rolling;
  load.moment[0] = -N * friction.spinning * std::tanh(3 * motion.spin[0] / friction.creep_spin);
  return load;
}

}  // namespace lithe
