#pragma once

#include <algorithm>
#include <cmath>

#include "lithe/lithe.h"

/// What machines/wind_turbine.cpp needs beside the library: air on its blades, and the drive that turns them.
namespace turbine {

/// Lift and drag of a strip of that area (m²) in a wind (m/s, world axes), by one polar of a thin airfoil with stall.
/// Axis 2 of the section points to the suction side, axis 3 to the trailing edge.
inline lithe::Wrench air(const lithe::Vector3& wind, const lithe::MarkerView& section, double area) {
  const lithe::Vector3 flow = wind - section.v;
  const double across = flow.dot(section.y()), along = flow.dot(section.z()), speed = std::hypot(across, along);
  const double attack = std::atan2(across, along);
  const double lift = std::clamp(6.3 * (attack + 0.075), -1.0, 1.4), drag = 0.01 + 1.3 * std::pow(std::sin(attack), 2);
  const double pressure = 0.5 * 1.225 * speed * area;  // of air, kg/m³; times another speed
  return lithe::force(pressure *
                      ((lift * along + drag * across) * section.y() + (drag * along - lift * across) * section.z()));
}

/// Turns a blade to the pitch that PI control of the speed asks for, by a stiff actuator:
///   θ = θ_0 + k_p (Ω - Ω_0) + k_i ∫(Ω - Ω_0) dt,   torque = k (θ - pitch) - c · pitch rate
/// Coordinates: the pitch, and the angle of the rotor, whose turns less Ω_0 t are the integral.
class PitchDrive final : public lithe::Force</*markers=*/4, /*rows=*/1> {
 public:
  struct Parameters {
    double pitch = 0;                   // θ_0, rad
    double speed = 0;                   // Ω_0, rad/s
    double proportional = 0;            // k_p, s
    double integral = 0;                // k_i
    double stiffness = 0, damping = 0;  // k, N m/rad; c, N m s/rad
  };
  PitchDrive(lithe::CoordinateSet coordinates, const Parameters& parameters)
      : coordinates_(std::move(coordinates)), p_(parameters) {}
  std::vector<lithe::MeasuredAngle> angles() const override { return coordinates_.angles(); }
  void evaluate(double time, std::span<const lithe::MarkerView> markers, lithe::ForceRows& rows) const override {
    const lithe::MeasuredCoordinate pitch = coordinates_.measure(0, markers, rows),
                                    rotor = coordinates_.measure(1, markers, rows);
    const double wanted =
        p_.pitch + p_.proportional * (rotor.rate - p_.speed) + p_.integral * (rotor.value - p_.speed * time);
    const lithe::Wrench none{lithe::Vector3::Zero(), lithe::Vector3::Zero()};
    rows.add({pitch.on_A, pitch.on_B, none, none}, p_.stiffness * (pitch.value - wanted) + p_.damping * pitch.rate,
             p_.stiffness, p_.damping, 0);
  }

 private:
  const lithe::CoordinateSet coordinates_;
  const Parameters p_;
};

}  // namespace turbine
