#pragma once

#include "engine/assembly/batch.h"
#include "engine/model/appearance.h"
#include "engine/model/force_element.h"
#include "engine/observe/sensors.h"
#include "joints/aerodynamics/airfoil.h"

namespace lithe {

/// Lift, drag and moment on a strip of a wing by steady strip theory. The marker has its x axis along the span, y
/// towards the leading edge, z to the upper side; twist turns the chord nose up. With the air's velocity u relative to
/// the section at three quarters of the chord, of which the part across the span counts, W = |u|, α = ∠(u, chord):
///   F = ½ ρ c b W (c_l u × e_span + c_d u),   M = ½ ρ c² b W (W c_m - (π/8) c ω_span) e_span
/// at the aerodynamic centre. That point and the last term are thin-airfoil theory of a section that turns steadily:
/// its motion is a flow with camber. No wake, induced flow or apparent mass; unsteady lift and dynamic stall:
/// DynamicAirfoilStrip. J. Katz, A. Plotkin, Low-Speed Aerodynamics, ch. 5 and 13.
///   graph.add<AirfoilStrip>("fin", {glider.marker({-2, 0, 0.4}, upright)}, {.width = 0.6, .chord = 0.3, .airfoil =
///   law});
class AirfoilStrip final : public Force</*markers=*/1, /*rows=*/0>, public DrawableConnector {
 public:
  struct Parameters {
    double width = 0;        // b, m, along the span
    double chord = 0;        // c, m
    double twist = 0;        // rad
    double ahead = 0;        // m: of the aerodynamic centre before the marker, along the chord
    AirfoilLaw airfoil{};    // airfoil_table(), linear_airfoil(), any function
    WindField wind{};        // none: still air
    double density = 1.225;  // ρ, kg/m³
  };
  /// Throws SceneError for a width, chord or density that is not positive, no airfoil, and what is not finite.
  explicit AirfoilStrip(Parameters parameters);

  bool depends_on_time() const override { return static_cast<bool>(parameters_.wind); }
  void evaluate(double time, std::span<const MarkerView> markers, ForceRows& rows) const override;
  /// α, rad, -π to π; positive where the air comes from below. 0 without flow.
  double angle_of_attack(double time, const MarkerView& marker) const;

  /// The flow across the span: along the chord (to the leading edge) and along its normal (to the upper side), m/s.
  Eigen::Vector2d flow(double time, const MarkerView& marker) const;
  /// F and M of coefficients in that flow u ≠ 0 at the marker; `turning`: the factor of M's last term, π/8 above.
  Wrench load(const MarkerView& marker, const Eigen::Vector2d& u, const AirfoilCoefficients& c, double turning) const;

  /// A flat box of its size, where the body does not draw itself.
  std::vector<DrawnShape> drawn_shapes(int marker) const override;
  DrawnShape shape() const;

 private:
  const Parameters parameters_;
  Vector3 chord_, normal_;  // in the marker's axes
};

extern template std::unique_ptr<ForceBatch> make_force_batch<AirfoilStrip>();

/// rad: to see whether a run stays where the airfoil's table is right.
Sensor angle_of_attack(const AirfoilStrip& strip, Located name = "");

}  // namespace lithe
