#pragma once

#include <functional>
#include <string>
#include <vector>

#include "engine/model/system_graph.h"
#include "tools/differential/dice.h"

namespace lithe::differential {

/// Sizes that numbers of a scene are drawn around; time is that in which weight moves a body by its size.
struct Units {
  double length = 1, mass = 1, time = 1;  // m, kg, s
  double speed() const { return length / time; }
  double force() const { return mass * length / (time * time); }
  double energy() const { return force() * length; }
  double stiffness() const { return mass / (time * time); }
  double damping() const { return mass / time; }
};

/// An element as a value: it can be added to any number of graphs. `nudge` disturbs drawn velocities, in units of
/// speed.
struct DrawnElement {
  std::string name, kind;
  std::vector<int> needs;  // elements that must be in the graph before it
  std::function<void(SystemGraph& graph, double nudge)> add;
};

/// Where connectors may hold a body: a point of the world as drawn, and the marker there with axes of the world.
struct Place {
  int element = -1;  // of the body; -1: ground
  Vector3 point = Vector3::Zero();
  std::function<Marker(SystemGraph& graph, const Matrix3& axes)> marker;
};

struct DrawnBody {
  int element;
  bool axes;                  // its markers have axes
  bool rigid;                 // a marker may be anywhere
  std::vector<Place> places;  // the first is where it was attached
  std::function<Marker(SystemGraph& graph)> watched;
  std::vector<std::function<Marker(SystemGraph& graph)>> nodes;  // three that its frame holds, at its first place
};

/// What springs, drives and friction act on: a coordinate of a joint, with its value as drawn.
struct DrawnCoordinate {
  int element;  // of the joint
  std::function<JointCoordinate(SystemGraph& graph)> of;
  bool angle, rubs;
  double value;  // rad or m
};

/// A scene as a value.
struct DrawnScene {
  std::uint32_t seed = 0;
  Units units;
  Vector3 gravity = Vector3::Zero();  // m/s²
  double duration = 0;                // s
  bool impacts = false;               // rigid surfaces: for time stepping alone
  bool stiff = false;                 // not for explicit methods
  std::vector<DrawnElement> elements;
  std::vector<DrawnBody> bodies;
  std::vector<std::string> joints;  // whose reactions are compared
};

/// A random graph of bodies, joints, forces and contacts; one of a seed.
DrawnScene draw_scene(std::uint32_t seed);

/// Elements in another order that may be added one after the other; seed 0: as drawn.
std::vector<int> order_of(const DrawnScene& scene, std::uint32_t seed);

/// Without those elements and all that need them.
DrawnScene without(const DrawnScene& scene, const std::vector<int>& left_out);

/// A line an element.
std::string text_of(const DrawnScene& scene);

}  // namespace lithe::differential
