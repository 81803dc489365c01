#pragma once

#include "joints/aerodynamics/airfoil_strip.h"
#include "joints/aerodynamics/separated_lift.h"

namespace lithe {

/// How the flow of a section lags behind its motion; times count in half chords of travel, T = c/2W. The wake of a thin
/// section by R. T. Jones: it answers a step of the downwash by 1 - A₁ e^(-b₁ s) - A₂ e^(-b₂ s), s half chords later.
struct FlowLags {
  double wake_share_1 = 0.165, wake_share_2 = 0.335;  // A
  double wake_rate_1 = 0.0455, wake_rate_2 = 0.3;     // b
  double pressure = 1.7, separation = 3;              // T_p, T_f
};

/// A strip as AirfoilStrip whose flow has a memory: unsteady attached flow and dynamic stall from the trailing edge,
/// by Leishman and Beddoes in the form of M. H. Hansen, M. Gaunaa, H. A. Madsen, Risø-R-1354 (2004). With the flow
/// (u_c, u_n) at three quarters of the chord, states y₁, y₂ (downwash of the wake), p and f:
///   ẏ_i = b_i (A_i u_n - y_i)/T,   α_E = ∠(u_n (1 - A₁ - A₂) + y₁ + y₂, u_c)
///   ṗ = (c_l' (α_E - α₀) + π T ω - p)/(T_p T),   ḟ = (f_st(p/c_l' + α₀) - f)/(T_f T)
///   c_l = c_l' (α_E - α₀) f + c_s(α_E) (1 - f) + π T ω,   c_m = c_m,st(α_E) - (π/2) T ω,   ω about the span
///   c_d = c_d,st(α_E) + (α - α_E) c_l + (c_d,st(α_E) - c_d,st(α₀)) ((√f_st - √f)/2 - (f_st - f)/4),  f_st at α_E
/// f_st, c_s, c_l', α₀: SeparatedLift. The report's states of the wake are y_i/W: so the change of W is in them, and
/// flow from behind too. At rest in steady flow the strip is an AirfoilStrip. Not in it: the vortex of the leading
/// edge, compressibility, apparent mass of accelerations, a shift of the moment's arm with f. √f is f/√(f + 1e-4). Its
/// states are two points of FirstOrderStates:
///   auto& flow = graph.add<FirstOrderStates>("flow", {.start = DynamicAirfoilStrip::start()});
///   graph.add<DynamicAirfoilStrip>("fin", {wing.marker(), flow.point(0), flow.point(1)}, {.strip = {...}});
class DynamicAirfoilStrip final : public Force</*markers=*/3, /*rows=*/0>, public DrawableConnector {
 public:
  struct Parameters {
    AirfoilStrip::Parameters strip{};
    FlowLags lags{};
  };
  /// Throws SceneError as AirfoilStrip and SeparatedLift do, and for lags that are negative, not finite or without
  /// time.
  explicit DynamicAirfoilStrip(Parameters parameters);

  /// Of FirstOrderStates: attached flow at zero lift, which is then met at once (Wagner's problem).
  static VectorX start();
  /// The flow that an angle of attack (rad) at a speed (m/s) has had for long.
  static VectorX settled(const Parameters& parameters, double angle, double speed);

  bool depends_on_time() const override { return true; }
  void evaluate(double time, std::span<const MarkerView> markers, ForceRows& rows) const override;
  /// "_angle", α, and "_effective", α_E, rad; "_separation", f; "_lift", c_l.
  Sensor flow(Located name = "") const;
  std::vector<DrawnShape> drawn_shapes(int marker) const override;

 private:
  struct Instant;
  Instant at(double time, std::span<const MarkerView> markers) const;

  const AirfoilLaw airfoil_;
  const FlowLags lags_;
  const double chord_;
  const AirfoilStrip section_;
  const SeparatedLift separated_;
  const double least_drag_;  // c_d at α₀
};

extern template std::unique_ptr<ForceBatch> make_force_batch<DynamicAirfoilStrip>();

}  // namespace lithe
