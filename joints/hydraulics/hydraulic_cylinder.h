#pragma once

#include <limits>

#include "engine/assembly/batch.h"
#include "engine/model/force_element.h"
#include "engine/model/motion_law.h"
#include "engine/observe/sensors.h"
#include "joints/hydraulics/oil.h"

namespace lithe {

/// A proportional 4/3 valve of four equal orifices, opening x from -1 to 1: x > 0 leads the supply to the cap and the
/// rod's chamber to the tank, x < 0 the other way; x = 0 closes all.
///   Q = |x| α A √(2/ρ) Δp / (Δp² + p_l²)^¼:   turbulent, √Δp, far above p_l; laminar, ~ Δp, far below
/// The spool follows its command as τ ẋ = u - x, or at once without τ. Without a command x is a state that another
/// element drives: displacement_between(ground, oil.point(0), 2) is a coordinate whose rate is x and whose force is ẋ
/// (ControlDiagram::push).
struct HydraulicValve {
  double area = 0;                                          // A, m², of one orifice open; 0: no valve
  double discharge = 0.6;                                   // α
  double laminar = 1e5;                                     // p_l, Pa
  MotionLaw command{};                                      // u; an Input of the scene too
  double time_constant = 0;                                 // τ, s
  MotionLaw supply = constant(0);                           // p_S, Pa
  double tank = 0;                                          // p_T, Pa
  double relief = std::numeric_limits<double>::infinity();  // p_r, Pa: each chamber opens to the tank above it
  double relief_flow = 0;                                   // m³/(s Pa) beyond p_r
  double makeup_flow = 0;  // m³/(s Pa) below p_T: oil that a chamber sucks from the tank
};

/// A hydraulic cylinder that pushes marker B from marker A, by the pressures of its two chambers of compressible oil:
///   F = A_c p_c - A_r p_r - c ṡ,   s = |p_B - p_A| - closed length
///   V_c = V_c0 + A_c s,  V_r = V_r0 + A_r (stroke - s),   A_c = π D²/4,  A_r = π (D² - d²)/4
///   ṗ_c = E'/V_c (Q_c - q - A_c ṡ),  ṗ_r = E'/V_r (Q_r + q + A_r ṡ),   q = k_l (p_c - p_r)
/// (Merritt, Hydraulic Control Systems, 1967, chapters 3 and 6). Pressures are above the atmosphere's. Beyond its
/// stroke a stop pushes back as CoordinateStop does, with a linear spring. Its third marker is a point of
/// FirstOrderStates, which keeps the pressures (in MPa, so that tolerances of a scene fit them) and the spool:
///   auto& oil = graph.add<FirstOrderStates>("lift oil", {.start = HydraulicCylinder::start(5e6, 1e6)});
///   auto& lift = graph.add<HydraulicCylinder>("lift", {frame.marker(), boom.marker(), oil.point(0)}, {.bore = 0.1,
///   ...});
/// Oil is stiff: Automatic, Radau and BDF are its methods. The energy of the compressed oil counts as elastic.
class HydraulicCylinder final : public Force</*markers=*/3, /*rows=*/1> {
 public:
  struct Parameters {
    double bore = 0;              // D, m
    double rod = 0;               // d, m; 0: a rod through both ends, equal areas
    double stroke = 0;            // m
    double closed_length = 0;     // from A to B, m
    double cap_dead_volume = 0;   // V_c0, with the line, m³
    double rod_dead_volume = 0;   // V_r0
    double leakage = 0;           // k_l between the chambers, m³/(s Pa)
    double friction = 0;          // c, N s/m
    double stop_stiffness = 1e8;  // N/m
    double stop_dissipation = 0;  // s/m
    HydraulicOil oil{};
    HydraulicValve valve{};
  };
  /// Throws SceneError for dimensions that are not positive, a rod not thinner than the bore, and numbers that are
  /// negative or not finite.
  explicit HydraulicCylinder(Parameters parameters);

  /// Of FirstOrderStates: pressures in Pa, the opening of the valve.
  static VectorX start(double cap, double rod, double opening = 0);

  void evaluate(double time, std::span<const MarkerView> markers, ForceRows& rows) const override;
  std::vector<CoordinateSwitch> switches() const override;

  Sensor pressures(Located name = "") const;  // of cap and rod, Pa
  /// Into the chambers of cap and rod, with leaks and relief, m³/s.
  Sensor flows(Located name = "") const;
  Sensor force(Located name = "") const;  // on B, away from A, N
  /// W: what supply and tank bring (p_S Q_S + p_T Q_T), what valves and leaks turn into heat, and what friction and
  /// stops do. supply = throttled + friction + power on the bodies + the growth of the stored energy.
  Sensor powers(Located name = "") const;

 private:
  struct Instant;
  Instant at(double time, std::span<const MarkerView> markers) const;
  double orifice(double drop) const;
  template <class Read>
  Sensor sensor(Located name, const std::vector<std::string>& endings, const char* unit, Read read) const;

  const Parameters p_;
  const double cap_area_, rod_area_;
};

extern template std::unique_ptr<ForceBatch> make_force_batch<HydraulicCylinder>();

}  // namespace lithe
