#pragma once

#include <functional>
#include <vector>

#include "bodies/beam/beam_element.h"
#include "bodies/rigid_body.h"
#include "engine/model/system_graph.h"
#include "engine/observe/sensors.h"

namespace lithe {

/// Where a beam is drawn: points and section axes (columns: 1 along the beam, 2, 3) over the arc length.
struct BeamAxis {
  double length = 0;                            // m
  std::function<FramePose(double arc)> pose{};  // arc from 0 to length, m; world axes

  /// Axis 2 is the part of `axis_2` at right angles to the line; {}: from the world axis farthest from the line.
  static BeamAxis straight(const Vector3& from, const Vector3& to, const Vector3& axis_2 = Vector3::Zero());
  /// From `start` with constant curvature (torsion, about axis 2, about axis 3; 1/m): an arc, a helix, a twisted blade.
  static BeamAxis curved(const FramePose& start, const Vector3& curvature, double length);
};

/// A geometrically exact beam: rigid bodies as nodes, a BeamElement between each two. A maker, not an element: what it
/// adds to the graph is called "blade.node0", "blade.element0" and so on, and outlives it.
///   Beam blade(graph, "blade", {.axis = BeamAxis::straight({0, 0, 0}, {8, 0, 0}), .sections = {{0, section}}});
///   graph.add<FixedJoint>("root", {graph.ground().marker({0, 0, 0}, blade.axes(0)), blade.marker(0)});
/// Mass is lumped: each node carries what lies between the middles of its elements as one rigid piece, so that mass,
/// mass centre and inertia of a rigid motion of the undeformed beam are exact, and so are weight and its moments.
/// Elements and lumping have an error of second order in the elements' length.
class Beam {
 public:
  struct Station {
    double arc;  // m
    BeamSection section;
  };
  struct Parameters {
    BeamAxis axis{};
    std::vector<Station> sections{};    // rising; linear between, constant beyond
    int elements = 20;                  // in all; each stretch between stations has one at least
    std::vector<double> stations{};     // m: where markers are wanted: there are nodes, as at both ends
    Vector3 velocity{0, 0, 0};          // of the point at arc 0, world axes, m/s
    Vector3 angular_velocity{0, 0, 0};  // of the whole beam, world axes, rad/s
  };
  /// Throws SceneError for an axis without length, stations out of order or beyond the ends, no section, and what
  /// BeamSection::check says of them.
  Beam(SystemGraph& graph, Located name, const Parameters& parameters);

  /// At a node on the axis, with the section's axes; `arc` is 0, the length, a station or the place of another node.
  Marker marker(double arc) const { return axis_markers_[node_at(arc)]; }
  /// Fixed in the section there: `offset` in section axes (m), marker axes to section axes.
  Marker marker(double arc, const Point& offset, const Matrix3& orientation = Matrix3::Identity()) const;

  int node_count() const { return static_cast<int>(nodes_.size()); }
  RigidBody& node(int i) const { return *nodes_[i]; }
  double arc(int node) const { return arcs_[node]; }                 // m
  const Matrix3& axes(int node) const { return poses_[node].axes; }  // as drawn
  /// The node's piece of the beam: length, and a marker at the middle of its axis, for loads per length.
  double piece_length(int node) const;
  Marker piece_middle(int node) const { return middles_[node]; }

  int element_count() const { return static_cast<int>(elements_.size()); }
  const BeamElement& element(int i) const { return *elements_[i]; }
  /// BeamElement::strain and ::resultants at a state: constant along the element, best in its middle.
  Vector6 strain(Snapshot& at, int element) const;
  Vector6 resultants(Snapshot& at, int element) const;
  /// The same as a sensor: Gamma_1 …, K_1 … (1/m); n_1 … (N), m_1 … (N m).
  Sensor strain(int element, Located name = "") const;
  Sensor resultants(int element, Located name = "") const;

 private:
  int node_at(double arc) const;

  std::string name_, where_;
  std::vector<double> arcs_;
  std::vector<FramePose> poses_;
  std::vector<RigidBody*> nodes_;
  std::vector<Vector3> centers_;  // of the nodes' pieces from the node, in its axes
  std::vector<Marker> axis_markers_, middles_;
  std::vector<const BeamElement*> elements_;
};

}  // namespace lithe
