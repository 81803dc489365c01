#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "engine/model/system_graph.h"
#include "joints/aerodynamics/dynamic_airfoil_strip.h"

namespace lithe {

/// Steady aerodynamic load along a stretch of a Beam by tables over the arc length. Section axes: 1 along the span, 2
/// towards the leading edge, 3 to the upper side. Chord, twist and place are linear between stations, and so are the
/// coefficients of two airfoils at one angle of attack; constant beyond the last.
///   add_airfoil_load(graph, "air", blade, {.stations = {{.arc = 0, .chord = 1.2, .twist = 0.2, .airfoil = root},
///                                                       {.arc = 9, .chord = 0.4, .airfoil = tip}}, .wind = gale});
struct AirfoilLoad {
  struct Station {
    double arc = 0;    // m
    double chord = 0;  // m
    double twist = 0;  // rad, from axis 2 towards axis 3: nose up
    double ahead = 0;  // m: of the aerodynamic centre before the beam's axis, along the chord
    AirfoilLaw airfoil{};
  };
  double from = 0;                  // m
  std::optional<double> to{};       // m; none: to its end
  std::vector<Station> stations{};  // rising
  WindField wind{};                 // none: still air
  double density = 1.225;           // kg/m³
};

/// On a body whose nodes are at the arc lengths `nodes`: two strips in each element that the stretch covers, at Gauss's
/// points, cut at the stations, named "<name>.0" and so on.
std::vector<AirfoilStrip*> add_airfoil_load(SystemGraph& graph, const Located& name, const std::vector<double>& nodes,
                                            const std::function<Marker(double arc)>& marker, const AirfoilLoad& load);

/// The same of strips whose flow has a memory, with the states "<name> flow"; they start attached, at zero lift.
std::vector<DynamicAirfoilStrip*> add_dynamic_airfoil_load(SystemGraph& graph, const Located& name,
                                                           const std::vector<double>& nodes,
                                                           const std::function<Marker(double arc)>& marker,
                                                           const AirfoilLoad& load, const FlowLags& lags = {});

template <class Line>
std::vector<double> arcs_of(const Line& line) {
  std::vector<double> nodes;
  for (int i = 0; i < line.node_count(); ++i) nodes.push_back(line.arc(i));
  return nodes;
}

/// Throws SceneError for a stretch that is empty or leaves the beam, no station, stations that do not rise, a chord
/// that is not positive, a station without airfoil, figures that are not finite.
template <class Line>
std::vector<AirfoilStrip*> add_airfoil_load(SystemGraph& graph, const Located& name, Line& line,
                                            const AirfoilLoad& load) {
  return add_airfoil_load(
      graph, name, arcs_of(line), [&](double arc) { return line.marker(arc); }, load);
}
template <class Line>
std::vector<DynamicAirfoilStrip*> add_dynamic_airfoil_load(SystemGraph& graph, const Located& name, Line& line,
                                                           const AirfoilLoad& load, const FlowLags& lags = {}) {
  return add_dynamic_airfoil_load(
      graph, name, arcs_of(line), [&](double arc) { return line.marker(arc); }, load, lags);
}

}  // namespace lithe
