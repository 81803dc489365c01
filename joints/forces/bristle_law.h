#pragma once

#include "engine/base/math.h"
#include "joints/forces/friction_law.h"

namespace lithe {

/// Elastoplastic bristles (Dupont, Hayward, Armstrong, Altpeter 2002) between surfaces that slide with s (m/s). Their
/// deflection z is in parts of that at breakaway, δ: the force of a unit normal force is μ_s z, and
///   δ ż = s - α(|z| / e) (s·z)₊ z / (e |z|),   e = μ(|s|) / μ_s: of steady sliding
///   α = 0 below a of that, 1 above it, and half a sine wave between.
/// So bristles that bend back or less than a e are elastic, and do not drift under loads that go to and fro (LuGre
/// does); none bends beyond δ. Steps that do not resolve δ may leave z beyond it: there the force is bounded by 1.1
/// μ_s, b = |z| counts as 1 + (1 - exp((1 - b) / w)) w, w = 0.1. While they stick they are damped, by no more than 0.43
/// μ_s:
///   F / N = μ_s (z + (1 - α) (τ / δ) exp(-(|s| τ / δ)²) s)
class BristleLaw {
 public:
  struct Parameters {
    StribeckLaw::Parameters sliding;
    double breakaway_deflection;  // δ, m
    double damping_time;          // τ, s
    double elastic_share;         // a
  };
  /// Throws SceneError naming the parameter that is out of its bounds.
  explicit BristleLaw(const Parameters& p) : p_(p), level_(p.sliding) {
    require::positive(p.sliding.coefficient, "coefficient");
    if (p_.sliding.static_coefficient == 0) p_.sliding.static_coefficient = p_.sliding.coefficient;
    if (p_.sliding.static_coefficient < p_.sliding.coefficient)
      throw SceneError("static_coefficient is " + std::to_string(p_.sliding.static_coefficient) + ", below coefficient",
                       "",
                       "bristles stick by at least what they slide with: give at least " +
                           std::to_string(p_.sliding.coefficient) + ", or leave it out");
    require::positive(p.breakaway_deflection, "breakaway_deflection");
    require::not_negative(p.damping_time, "damping_time");
    if (!(p.elastic_share > 0 && p.elastic_share < 1))
      throw SceneError("elastic_share is " + std::to_string(p.elastic_share), "", "give one between 0 and 1, as 0.9");
  }

  struct Value {
    Vector3 rate, force;  // ż, 1/s; F / N
    double damping;       // ∂(F / N)/∂s along s, of what sticks; s/m
  };
  Value at(const Vector3& s, const Vector3& z) const {
    const double mu_s = p_.sliding.static_coefficient, delta = p_.breakaway_deflection;
    const double speed = s.norm(), bent = z.norm(), e = level_.at(speed).mu / mu_s;
    const double alpha = plastic(bent / e), slip = alpha > 0 ? alpha * std::max(s.dot(z), 0.0) / (e * bent) : 0;
    const double reach = speed * p_.damping_time / delta;
    const double damping = mu_s * (1 - alpha) * p_.damping_time / delta * std::exp(-reach * reach);
    return {(s - slip * z) / delta, mu_s * (bent > 1 ? bounded(bent) / bent : 1) * z + damping * s, damping};
  }
  /// Stored in bristles, over the normal force, m.
  double energy(const Vector3& z) const {
    const double bent = z.norm(), by_force = bent > 1
                                                 ? 1 + 2 * ((1 + kBeyond) * (bent - 1) - kBeyond * (bounded(bent) - 1))
                                                 : bent * bent;
    return p_.sliding.static_coefficient * p_.breakaway_deflection * by_force / 2;
  }

 private:
  static constexpr double kBeyond = 0.1;  // w
  static double bounded(double bent) { return 1 - kBeyond * std::expm1((1 - bent) / kBeyond); }
  double plastic(double share) const {
    const double a = p_.elastic_share;
    if (share <= a) return 0;
    if (share >= 1) return 1;
    return 0.5 + 0.5 * std::sin(M_PI * (share - (1 + a) / 2) / (1 - a));
  }

  Parameters p_;
  StribeckLaw level_;
};

}  // namespace lithe
