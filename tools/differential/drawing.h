#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "tools/differential/drawn_scene.h"

/// How a scene comes about: a tree of bodies and joints grows from the ground, then loops, forces and contacts.
namespace lithe::differential {

enum class BodyKind { rigid, point, flexible, beam, cable };

struct Drawing {
  explicit Drawing(std::uint32_t seed) : dice(seed) {}

  Dice dice;
  DrawnScene scene;
  bool planar = false;
  Matrix3 plane = Matrix3::Identity();  // of a planar scene: z normal to it
  std::vector<DrawnCoordinate> coordinates;
  std::vector<Place> ground;
  Vector3 drift = Vector3::Zero(), spin = Vector3::Zero();  // of all bodies as drawn, m/s and rad/s, world axes

  int add(DrawnElement element) {
    element.name = element.kind + " " + std::to_string(scene.elements.size());
    scene.elements.push_back(std::move(element));
    return static_cast<int>(scene.elements.size()) - 1;
  }
  const std::string& name(int element) const { return scene.elements.begin()[element].name; }
  /// Elements of places, for DrawnElement::needs.
  static std::vector<int> bodies_of(std::initializer_list<const Place*> places) {
    std::vector<int> out;
    for (const Place* place : places)
      if (place->element >= 0) out.push_back(place->element);
    return out;
  }
  Matrix3 axes() { return planar ? Matrix3(plane * rotation_about({0, 0, 1}, dice.number(-3, 3))) : dice.rotation(); }
  /// In the plane of a planar scene.
  Vector3 shift(double size) {
    const Vector3 d = dice.vector(size * scene.units.length);
    return planar ? Vector3(plane * Vector3(d.x(), d.y(), 0)) : d;
  }
  Vector3 velocity(const Vector3& point, double scatter) {
    return drift + spin.cross(point) + dice.vector(scatter * scene.units.speed());
  }
  /// Any place of a body, or of the ground now and then.
  const Place& any_place();
  /// A place of a rigid body at a point of the world.
  Place place_on(const DrawnBody& body, const Vector3& point) const;
  std::vector<int> rigid_bodies() const;  // indices into scene.bodies
};

/// A body whose first place is at `point`; its index in scene.bodies.
int draw_body(Drawing& drawing, BodyKind kind, const Vector3& point);

/// A body held by a joint at `parent`.
void grow(Drawing& drawing, BodyKind kind, const Place& parent, bool parent_axes);
/// A joint between two bodies that are there.
void close_loop(Drawing& drawing);
/// Gears, racks, discs, couplings: bodies and joints that make sense together.
void draw_group(Drawing& drawing);

void draw_force(Drawing& drawing);
void draw_contact(Drawing& drawing);

}  // namespace lithe::differential
