#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "engine/model/system_graph.h"
#include "engine/observe/sensors.h"

namespace lithe {

/// Friction of a rope that moves with the surface of its pulley: a toothed belt, a rope clamped to a drum.
inline constexpr double kNoSlip = std::numeric_limits<double>::infinity();

/// Where a rope ends: at the point of a marker, or wound on a drum.
struct RopeEnd {
  Marker marker;
  double radius = 0;  // of a drum that turns with the marker about its z axis, m; 0: the rope is tied to the point
  int sense = 1;      // of a drum, as RopePulley::sense
};

/// A pulley that a rope runs over.
struct RopePulley {
  Marker marker;        // at the centre, on the body that carries the axle; z: the axle
  double radius = 0;    // of the rope's axis on the wheel, m
  int sense = 1;        // 1: from its first end to its last the rope runs counter-clockwise about z; -1: clockwise
  double friction = 0;  // μ between rope and surface; kNoSlip: they move together
  std::optional<JointCoordinate> wheel{};  // angle of the wheel to its carrier about that z: pin.angle(); none: with
                                           // friction the surface is the carrier's (a bollard), without it turns freely
  int turns = 0;                           // whole turns of the rope about it beyond the drawing's wrap below one
};

struct RopeParameters {
  std::vector<RopePulley> pulleys{};  // in the order in which the rope meets them
  double axial_stiffness = 0;         // EA, N
  double axial_damping = 0;           // c, N s: tension EA ε + c ε̇, the viscous part limited to the elastic one
  double mass_per_length = 0;         // μ_l, kg/m: weight, and inertia along the rope
  std::optional<double> length{};     // unstretched, with its arcs, m; none: by the pretension
  double pretension = 0;              // tension as drawn where no length is given, N
  double speed = 0;                   // of the rope along itself as drawn, m/s; needs mass
  double presliding = 1e-4;           // δ: travel over a surface until friction is full, m
};

/// The elements of a rope in a graph, which owns them. Spans are numbered from 0 at the first end; span i comes before
/// pulley i, that of a closed belt behind it.
struct Rope {
  std::string name;
  std::vector<const ForceElement*> spans;  // one a span; all the same of a rope without mass
  std::vector<const Body*> travels;        // one a pulley; none of a rope without mass
  std::vector<double> drawn_lengths;       // of the straight parts, m
  std::vector<double> wraps;               // α as drawn, rad, one a pulley
  double length = 0;                       // unstretched, with its arcs, m

  /// Unstretched length that has passed pulley i (0 …) since the drawing, m. SceneError for a rope without mass.
  JointCoordinate travel(int pulley) const;
};

/// Draws an elastic rope between two ends over any number of pulleys, or without ends a closed belt over two or more.
///   reeve(graph, "hoist", {{drum.marker(), 0.2}, {hook.marker()}},
///         {.pulleys = {{head.marker(), 0.15, -1}}, .axial_stiffness = 2e6});
/// Straight parts follow the tangents of the wheels as they move, external where neighbours turn alike, crossed where
/// not; a rope does not lift off a pulley.
/// - Without mass and friction it has one tension all along, T = EA ε (IdealRope): at most six pulleys.
/// - With mass its travel over each pulley is a coordinate with the mass of half the spans beside it, and of all of a
///   span to an end that moves; of a span's weight half acts at either end. Every span has a tension of its own, at its
///   middle. Friction lets those beside a pulley differ by up to e^(μα), sticks below that, and drives wheels: two or
///   more make a belt drive with elastic creep, (T_1 - T_2)/EA.
/// Spans that are slack carry nothing. Limits: the axles are about parallel (20 degrees) and neighbours about in one
/// plane (20 degrees); spans are straight, and inertia across themselves and the centrifugal force of the rope are left
/// out; the mass of a travel stays that of the drawing, and rope on a drum keeps stiffness and weight of the span as
/// drawn. What has slipped is kept as the rate of a coordinate: start static equilibria, at which rates vanish, from a
/// state in which nothing has slipped, such as the drawing.
/// Throws SceneError for a missing stiffness, negative or not finite values, a pulley without radius, pulleys that
/// overlap or an end within one, axes out of line, a wheel that does not turn about its pulley's z axis on the body of
/// its marker, and what needs mass and has none; it names the pulley, from 1.
Rope reeve(SystemGraph& graph, Located name, std::vector<RopeEnd> ends, RopeParameters parameters);

/// Tension of a span, in its middle, N. Throws SceneError for a span that the rope does not have.
Sensor tension(const Rope& rope, int span, Located name = "");

}  // namespace lithe
