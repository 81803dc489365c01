#pragma once

#include "engine/model/contact_element.h"

namespace lithe {

/// What happens to the energy of an impact. F = k δⁿ (1 + D δ̇), never below zero; D from the restitution e and the
/// speed v with which the surfaces met:
///   hunt_crossley       D = 3/2 (1 - e) / v                  (1975; e near 1)
///   lankarani_nikravesh D = 3/4 (1 - e²) / v                 (1990; e near 1)
///   flores              D = 8/5 (1 - e) / (e v)              (2011; any e above zero)
///   fixed               D = `damping`, s/m
///   exact               D that achieves e (any e above zero)
/// The restitution r that such a law achieves follows from D v alone, for any k, n and masses:
///   (1 + r) D v = ln((1 + D v) / (1 - r D v)).
enum class Dissipation { fixed, hunt_crossley, lankarani_nikravesh, flores, exact };

/// A compliant normal law. With `stiffness` zero it is Hertz's of two elastic bodies: k = 4/3 E* / sqrt(curvature),
/// n = 3/2, 1/E* = Σ (1 - ν²)/E.
struct Compliance {
  double stiffness = 0;          // k, N/mⁿ
  double exponent = 1.5;         // n >= 1
  double effective_modulus = 0;  // E*, Pa
  double flat_radius = 0;        // m: of Hertz where both surfaces are flat; 0: flat on flat is an error
  double restitution = 1;        // e
  Dissipation dissipation = Dissipation::exact;
  double damping = 0;         // D, s/m: fixed
  double least_speed = 1e-3;  // m/s: D is no larger than at this approach speed
};

/// 1/E* = (1 - ν_a²)/E_a + (1 - ν_b²)/E_b, Pa. Throws SceneError unless E > 0 and -1 < ν <= 0.5.
double effective_modulus(double young_a, double poisson_a, double young_b, double poisson_b);

/// Coulomb friction under the normal force N, with Stribeck's μ(v) = μ_k + (μ_s - μ_k) exp(-(v/v_s)²). Without bristles
/// it is regularised: force N (μ(v) tanh(3 |v| / creep_speed) v/|v| + σ₂ v), which creeps instead of sticking. With
/// `bristle_stiffness` it is LuGre's (Canudas de Wit et al. 1995), which sticks:
///   ż = v - σ₀ |v| z / μ(v),   force N (σ₀ z + σ₁ ż + σ₂ v),   z in m across the contact.
struct ContactFriction {
  double coefficient = 0;         // μ_k
  double static_coefficient = 0;  // μ_s; 0: μ_k
  double stribeck_speed = 1e-3;   // v_s, m/s
  double creep_speed = 1e-3;      // of the regularised law, m/s
  double bristle_stiffness = 0;   // σ₀, 1/m; 0: regularised
  double bristle_damping = 0;     // σ₁, s/m
  double viscous = 0;             // σ₂, s/m
  double rolling = 0;             // m: rolling moment over normal force
  double spinning = 0;            // m: moment about the normal over normal force
  double creep_spin = 1e-2;       // rad/s: of these moments, regularised
};

/// Throws SceneError naming the parameter.
void check(const Compliance& normal);
void check(const ContactFriction& friction);

/// The load of a compliant contact on B; nothing where the gap is positive. `energy` is that of the normal law, k δⁿ⁺¹
/// / (n + 1), without the energy stored in the bristles, at most N μ_s² / (2 σ₀). The deflection is that at the end of
/// `slip`, a straight path at the present μ(v): exact at steady speed, whatever the step. Throws SimulationError where
/// Hertz's law meets flat on flat without `flat_radius`.
ContactLoad compliant_load(const Compliance& normal, const ContactFriction& friction, const ContactMotion& motion);

}  // namespace lithe
