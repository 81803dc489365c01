#pragma once

namespace lithe {

/// Hydraulic oil with some free air, at gauge pressures p (Pa above the atmosphere p₀). Its volume relative to that of
/// the oil at p = 0,
///   v(p) = exp(-p / E) + α (p₀ / (p + p₀))^(1/n),
/// gives the effective bulk modulus E' = -v / (dv/dp): E without air, far below it at low pressure with air (Jelali and
/// Kroll, Hydraulic Servo-systems, 2003, section 3.2). Below an absolute pressure of 1 kPa the air keeps the slope that
/// it has there.
struct HydraulicOil {
  double bulk_modulus = 1.4e9;    // E, Pa
  double density = 860;           // ρ, kg/m³
  double air = 0;                 // α: free air by volume at p = 0
  double polytropic = 1.4;        // n of the air, above 1
  double atmosphere = 1.01325e5;  // p₀, Pa

  /// Throws SceneError for what is not positive, an air content that is negative or not below 1, and n not above 1.
  void check() const;
  struct At {
    double modulus;  // E', Pa
    /// Energy that a volume of compressed oil holds, J/m³: v⁻¹ ∫ p (-dv/dp) dp, about p² / 2E'. A flow Q brings
    /// Q (p + stored) into a chamber.
    double stored;
  };
  At at(double pressure) const;
};

}  // namespace lithe
