#include "joints/contact/contact.h"
#include "joints/contact/shape_internal.h"

namespace lithe {
namespace shapes_drawn {

DrawnShape convex(const Shape::Data& data) {
  using Kind = Shape::Kind;
  switch (data.kind) {
    case Kind::sphere:
      return visual::sphere(static_cast<const btSphereShape&>(*data.convex).getRadius());
    case Kind::box:
      return visual::box(2 * from_bullet(static_cast<const btBoxShape&>(*data.convex).getHalfExtentsWithMargin()));
    case Kind::cylinder: {
      const auto& cylinder = static_cast<const btCylinderShapeZ&>(*data.convex);
      return visual::cylinder(cylinder.getRadius(), 2 * cylinder.getHalfExtentsWithMargin().z());
    }
    case Kind::capsule: {
      const auto& capsule = static_cast<const btCapsuleShapeZ&>(*data.convex);
      return visual::capsule(capsule.getRadius(), 2 * capsule.getHalfHeight());
    }
    case Kind::cone: {
      const auto& cone = static_cast<const btConeShapeZ&>(*data.convex);
      return visual::cone(cone.getRadius(), cone.getHeight());
    }
    default: {  // hull
      std::vector<std::array<int, 3>> triangles;
      const Polyhedron& hull = *data.polyhedron;
      for (int face = 0; face + 1 < static_cast<int>(hull.first.size()); ++face) {
        const auto loop = hull.loop(face);
        for (std::size_t i = 2; i < loop.size(); ++i) triangles.push_back({loop[0], loop[i - 1], loop[i]});
      }
      return visual::mesh(hull.corners, triangles);
    }
  }
}

void add(const Shape& shape, std::vector<DrawnShape>& drawn) {
  const Shape::Data& data = shape.data();
  if (data.kind == Shape::Kind::surface) return;  // a deforming body draws its own
  if (data.kind == Shape::Kind::half_space) {
    drawn.push_back({.kind = DrawnShape::Kind::half_space});
  } else if (data.kind == Shape::Kind::compound) {
    for (const auto& [placement, part] : data.parts) {
      std::vector<DrawnShape> own;
      add(part, own);
      for (const DrawnShape& one : own) drawn.push_back(one.at(placement.position, placement.orientation));
    }
  } else {
    drawn.push_back(data.convex ? convex(data) : visual::mesh(data.points, data.triangles));
  }
}

}  // namespace shapes_drawn

std::vector<DrawnShape> Contact::drawn_shapes(int marker) const {
  std::vector<DrawnShape> drawn;
  shapes_drawn::add(colliders_.at(static_cast<std::size_t>(marker)).shape, drawn);
  return drawn;
}

}  // namespace lithe
