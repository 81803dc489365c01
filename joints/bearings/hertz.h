#pragma once

namespace lithe {

/// Isotropic elastic material of rings and rolling elements; the defaults are those of bearing steel.
struct BearingMaterial {
  double youngs_modulus = 2.07e11;  // E, Pa
  double poissons_ratio = 0.3;      // ν
};

/// Two elastic bodies of the same material that touch in a point (Hertz 1881; Harris & Kotzalas, Essential Concepts of
/// Bearing Technology, ch. 6), by complete elliptic integrals K(m), E(m), m = 1 - 1/κ²:
///   (κ² E - K) / (K - E) = ρ_b / ρ_a,   δ* = (2 K/π) (π / (2 κ² E))^(1/3)
///   Q = k δ^(3/2),   k = (2 Σρ / 3 η) (2 / (δ* Σρ))^(3/2),   η = 2 (1 - ν²) / E
/// ρ_a, ρ_b: relative curvatures in the two principal planes, 1/m, positive.
struct HertzPoint {
  double ellipticity = 1;  // κ, the longer semi-axis of the ellipse of contact over the shorter one
  double stiffness = 0;    // k, N/m^(3/2)
  HertzPoint(double curvature_a, double curvature_b, const BearingMaterial& material);
};

}  // namespace lithe
