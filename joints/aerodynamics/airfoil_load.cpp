#include "joints/aerodynamics/airfoil_load.h"

#include <algorithm>

#include "engine/base/checks.h"
#include "engine/model/point_body.h"
#include "joints/forces/first_order_states.h"
#include "joints/forces/line_pieces.h"

namespace lithe {
namespace {

void check(const AirfoilLoad& load) {
  require::positive(load.density, "density");
  if (load.stations.empty())
    throw SceneError("it has no station", "",
                     "give .stations = {{.arc = 0, .chord = 0.3, .airfoil = linear_airfoil()}}");
  for (std::size_t i = 0; i < load.stations.size(); ++i) {
    const auto& station = load.stations[i];
    const std::string of = " of station " + std::to_string(i);
    require::finite(station.arc, "the place" + of);
    require::positive(station.chord, "the chord" + of);
    require::finite(station.twist, "the twist" + of);
    require::finite(station.ahead, "the aerodynamic centre" + of);
    if (!station.airfoil)
      throw SceneError("station " + std::to_string(i) + " has no airfoil", "", "give .airfoil = airfoil_table(...)");
    if (i > 0 && !(station.arc > load.stations[i - 1].arc))
      throw SceneError("station " + std::to_string(i) + " does not lie behind the one before", "",
                       "list stations from the start to the end");
  }
}

AirfoilStrip::Parameters strip_at(const AirfoilLoad& load, double arc) {
  const auto next =
      std::find_if(load.stations.begin(), load.stations.end(), [&](const auto& s) { return s.arc > arc; });
  const auto& b = next == load.stations.end() ? load.stations.back() : *next;
  const auto& a = next == load.stations.begin() ? b : *(next - 1);
  const double share = b.arc > a.arc ? (arc - a.arc) / (b.arc - a.arc) : 0;
  const auto between = [share](double x, double y) { return (1 - share) * x + share * y; };
  return {
      .width = 0,
      .chord = between(a.chord, b.chord),
      .twist = between(a.twist, b.twist),
      .ahead = between(a.ahead, b.ahead),
      .airfoil =
          [between, first = a.airfoil, second = b.airfoil](double angle) {
            const AirfoilCoefficients x = first(angle), y = second(angle);
            return AirfoilCoefficients{between(x.lift, y.lift), between(x.drag, y.drag), between(x.moment, y.moment)};
          },
      .wind = load.wind,
      .density = load.density};
}

/// A strip as it will be drawn.
struct Planned {
  Located name;
  Marker marker;
  AirfoilStrip::Parameters parameters;
};

std::vector<Planned> plan(const Located& name, const std::vector<double>& nodes,
                          const std::function<Marker(double arc)>& marker, const AirfoilLoad& load) {
  std::vector<LinePiece> stretches;
  try {
    check(load);
    std::vector<double> stations;
    for (const auto& station : load.stations) stations.push_back(station.arc);
    stretches = line_pieces(load.from, load.to.value_or(nodes.back()), nodes, stations);
  } catch (const SceneError& error) {
    throw SceneError("'" + name.text + "': " + error.problem(), to_string(name.where), error.fix());
  }
  std::vector<Planned> strips;
  for (const auto& [arcs, half] : stretches)
    for (const double arc : arcs) {
      const Marker at = marker(arc);
      if (dynamic_cast<const PointBody*>(at.body))
        throw SceneError("'" + name.text + "': sections of '" + at.body->name() + "' do not turn",
                         to_string(name.where), "give the load of the wind on a cable as a LineLoad in world axes");
      AirfoilStrip::Parameters strip = strip_at(load, arc);
      strip.width = half;
      strips.push_back({{name.text + "." + std::to_string(strips.size()), name.where}, at, std::move(strip)});
    }
  return strips;
}

}  // namespace

std::vector<AirfoilStrip*> add_airfoil_load(SystemGraph& graph, const Located& name, const std::vector<double>& nodes,
                                            const std::function<Marker(double arc)>& marker, const AirfoilLoad& load) {
  std::vector<AirfoilStrip*> strips;
  for (Planned& strip : plan(name, nodes, marker, load))
    strips.push_back(&graph.add<AirfoilStrip>(strip.name, {strip.marker}, std::move(strip.parameters)));
  return strips;
}

std::vector<DynamicAirfoilStrip*> add_dynamic_airfoil_load(SystemGraph& graph, const Located& name,
                                                           const std::vector<double>& nodes,
                                                           const std::function<Marker(double arc)>& marker,
                                                           const AirfoilLoad& load, const FlowLags& lags) {
  std::vector<Planned> planned = plan(name, nodes, marker, load);
  const auto count = static_cast<Eigen::Index>(planned.size());
  auto& flow = graph.add<FirstOrderStates>({name.text + " flow", name.where},
                                           {.start = DynamicAirfoilStrip::start().replicate(count, 1)});
  std::vector<DynamicAirfoilStrip*> strips;
  for (Planned& strip : planned) {
    const int first = 2 * static_cast<int>(strips.size());
    strips.push_back(&graph.add<DynamicAirfoilStrip>(strip.name,
                                                     {strip.marker, flow.point(first), flow.point(first + 1)},
                                                     {.strip = std::move(strip.parameters), .lags = lags}));
  }
  return strips;
}

}  // namespace lithe
