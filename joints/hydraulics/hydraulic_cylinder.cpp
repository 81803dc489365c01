#include "joints/hydraulics/hydraulic_cylinder.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/assembly/batch_of.h"
#include "engine/base/checks.h"
#include "engine/model/joint_coordinate.h"
#include "engine/model/marker_motions.h"
#include "engine/observe/snapshot.h"

namespace lithe {
namespace {

constexpr double kStateUnit = 1e6;  // Pa: of the states that are pressures

double disc(double diameter) { return std::numbers::pi / 4 * diameter * diameter; }

}  // namespace

/// A chamber, and all of the cylinder, at one state.
struct HydraulicCylinder::Instant {
  struct Chamber {
    double pressure, volume, flow;  // flow: into it
    HydraulicOil::At oil;
    double inflow() const { return flow * (pressure + oil.stored); }  // W
  };
  MeasuredCoordinate length;
  Chamber cap, rod;
  double push;                                 // of the oil, N
  double stop, stop_by_length, stop_by_speed;  // tension of the stop and its derivatives
  double stop_elastic, stop_energy;            // what of it is its spring's; J
  double supplied;                             // W
  double spool_rate;
};

HydraulicCylinder::HydraulicCylinder(Parameters parameters)
    : p_(std::move(parameters)), cap_area_(disc(p_.bore)), rod_area_(cap_area_ - disc(p_.rod)) {
  const HydraulicValve& v = p_.valve;
  for (const auto& [value, name] :
       {std::pair(p_.bore, "bore"), std::pair(p_.stroke, "stroke"), std::pair(p_.closed_length, "closed_length"),
        std::pair(p_.cap_dead_volume, "cap_dead_volume"), std::pair(p_.rod_dead_volume, "rod_dead_volume"),
        std::pair(p_.stop_stiffness, "stop_stiffness"), std::pair(v.discharge, "valve.discharge"),
        std::pair(v.laminar, "valve.laminar")})
    require::positive(value, name);
  for (const auto& [value, name] :
       {std::pair(p_.rod, "rod"), std::pair(p_.leakage, "leakage"), std::pair(p_.friction, "friction"),
        std::pair(p_.stop_dissipation, "stop_dissipation"), std::pair(v.area, "valve.area"),
        std::pair(v.time_constant, "valve.time_constant"), std::pair(v.relief_flow, "valve.relief_flow"),
        std::pair(v.makeup_flow, "valve.makeup_flow")})
    require::not_negative(value, name);
  require::finite(v.tank, "valve.tank");
  p_.oil.check();
  if (!(p_.rod < p_.bore)) throw SceneError("the rod is not thinner than the bore", "", "give .rod below .bore, m");
  if (!v.supply) throw SceneError("valve.supply is empty", "", "give .supply = constant(2e7), Pa, or an Input");
  if (!(v.relief > v.tank)) throw SceneError("valve.relief is not above valve.tank", "", "give both in Pa");
}

VectorX HydraulicCylinder::start(double cap, double rod, double opening) {
  return Vector3(cap / kStateUnit, rod / kStateUnit, opening);
}

double HydraulicCylinder::orifice(double drop) const {
  const HydraulicValve& v = p_.valve;
  return v.discharge * v.area * std::sqrt(2 / p_.oil.density) * drop / std::sqrt(std::hypot(drop, v.laminar));
}

HydraulicCylinder::Instant HydraulicCylinder::at(double time, std::span<const MarkerView> markers) const {
  const HydraulicValve& v = p_.valve;
  const Vector3& z = markers[2].v;
  Instant now{};
  now.length = measure(JointCoordinate::Kind::distance, 0, markers[0], markers[1]);
  const double s = now.length.value - p_.closed_length, speed = now.length.rate;
  Instant::Chamber &cap = now.cap, &rod = now.rod;
  cap.pressure = kStateUnit * z[0], rod.pressure = kStateUnit * z[1];
  // A stop that gives way leaves some of the dead volume.
  cap.volume = std::max(p_.cap_dead_volume + cap_area_ * s, 0.1 * p_.cap_dead_volume);
  rod.volume = std::max(p_.rod_dead_volume + rod_area_ * (p_.stroke - s), 0.1 * p_.rod_dead_volume);
  cap.oil = p_.oil.at(cap.pressure), rod.oil = p_.oil.at(rod.pressure);
  now.push = cap_area_ * cap.pressure - rod_area_ * rod.pressure;

  // 1. Flows: from the supply and from the tank into each chamber, and between them.
  const double target = v.command ? v.command(time).value : z[2];
  const double x = std::clamp(v.command && v.time_constant > 0 ? z[2] : target, -1.0, 1.0);
  now.spool_rate = v.command && v.time_constant > 0 ? (target - z[2]) / v.time_constant : 0;
  const double supply = v.supply(time).value;
  const auto fill = [&](Instant::Chamber& chamber, double opening) {
    const double p = chamber.pressure;
    const double from_supply = opening > 0 ? opening * orifice(supply - p) : 0;
    double from_tank = opening < 0 ? -opening * orifice(v.tank - p) : 0;
    if (p > v.relief) from_tank -= v.relief_flow * (p - v.relief);
    if (p < v.tank) from_tank += v.makeup_flow * (v.tank - p);
    chamber.flow = from_supply + from_tank;
    now.supplied += supply * from_supply + v.tank * from_tank;
  };
  fill(cap, x), fill(rod, -x);
  const double leak = p_.leakage * (cap.pressure - rod.pressure);
  cap.flow -= leak, rod.flow += leak;

  // 2. The stop at either end.
  const double side = s < 0 ? -1 : 1, depth = s < 0 ? -s : s - p_.stroke;
  const double elastic = p_.stop_stiffness * depth, factor = 1 + p_.stop_dissipation * side * speed;
  if (depth > 0) {
    now.stop_elastic = side * elastic, now.stop_energy = 0.5 * elastic * depth;
    if (factor > 0) {
      now.stop = side * elastic * factor;
      now.stop_by_length = p_.stop_stiffness * factor;
      now.stop_by_speed = elastic * p_.stop_dissipation;
    }
  }
  return now;
}

void HydraulicCylinder::evaluate(double time, std::span<const MarkerView> markers, ForceRows& rows) const {
  const Instant now = at(time, markers);
  const Instant::Chamber &cap = now.cap, &rod = now.rod;
  const double speed = now.length.rate;
  rows.add({now.length.on_A, now.length.on_B, {Vector3::Zero(), Vector3::Zero()}}, now.stop + p_.friction * speed,
           now.stop_by_length, now.stop_by_speed + p_.friction,
           now.stop_energy + cap.volume * cap.oil.stored + rod.volume * rod.oil.stored);
  rows.add_load(markers[0], now.push * now.length.on_A);
  rows.add_load(markers[1], now.push * now.length.on_B);
  rows.add_load(markers[2], lithe::force({cap.oil.modulus / cap.volume * (cap.flow - cap_area_ * speed) / kStateUnit,
                                          rod.oil.modulus / rod.volume * (rod.flow + rod_area_ * speed) / kStateUnit,
                                          now.spool_rate}));
}

std::vector<CoordinateSwitch> HydraulicCylinder::switches() const {
  const JointCoordinate length{JointCoordinate::Kind::distance, markers()[0], markers()[1]};
  return {{length, p_.closed_length}, {length, p_.closed_length + p_.stroke}};
}

template <class Read>
Sensor HydraulicCylinder::sensor(Located name, const std::vector<std::string>& endings, const char* unit,
                                 Read read) const {
  if (name.text.empty()) name.text = this->name();
  std::vector<std::string> columns;
  for (const std::string& ending : endings) columns.push_back(name.text + ending);
  return Sensor(std::move(name), std::move(columns),
                [this, read](Snapshot& now, std::span<double> out) {
                  read(at(now.time(), MarkerMotions(markers(), [&](const Marker& m) { return now.marker(m); })), out);
                },
                {unit});
}

Sensor HydraulicCylinder::pressures(Located name) const {
  return sensor(std::move(name), {"_cap", "_rod"}, "Pa", [](const Instant& now, std::span<double> out) {
    out[0] = now.cap.pressure, out[1] = now.rod.pressure;
  });
}
Sensor HydraulicCylinder::flows(Located name) const {
  return sensor(std::move(name), {"_cap", "_rod"}, "m³/s",
                [](const Instant& now, std::span<double> out) { out[0] = now.cap.flow, out[1] = now.rod.flow; });
}
Sensor HydraulicCylinder::force(Located name) const {
  return sensor(std::move(name), {""}, "N", [c = p_.friction](const Instant& now, std::span<double> out) {
    out[0] = now.push - now.stop - c * now.length.rate;
  });
}
Sensor HydraulicCylinder::powers(Located name) const {
  return sensor(std::move(name), {"_supply", "_throttled", "_friction"}, "W",
                [this](const Instant& now, std::span<double> out) {
                  const double speed = now.length.rate;
                  out[0] = now.supplied;
                  out[1] = now.supplied - now.cap.inflow() - now.rod.inflow();
                  out[2] = (p_.friction * speed + now.stop - now.stop_elastic) * speed;
                });
}

template std::unique_ptr<ForceBatch> make_force_batch<HydraulicCylinder>();

}  // namespace lithe
