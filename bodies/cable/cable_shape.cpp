#include "bodies/cable/cable.h"

namespace lithe {
namespace {

constexpr int kSides = 6;  // of the tube

}  // namespace

DrawnMesh Cable::drawn_mesh(bool) const {
  DrawnMesh drawn;
  drawn.nodal = true;
  drawn.points = surface(drawn_);
  const int nodes = node_count();
  for (int i = 0; i < nodes; ++i) drawn.nodes.push_back(i);
  for (int i = 0; i < nodes; ++i) drawn.nodes.insert(drawn.nodes.end(), kSides, i);
  const auto rim = [&](int node, int side) { return nodes + kSides * node + side % kSides; };
  for (int e = 0; e < element_count(); ++e)
    for (int side = 0; side < kSides; ++side) {
      drawn.triangles.push_back({rim(e, side), rim(e, side + 1), rim(e + 1, side + 1)});
      drawn.triangles.push_back({rim(e, side), rim(e + 1, side + 1), rim(e + 1, side)});
    }
  for (int side = 2; side < kSides; ++side) {  // its ends
    drawn.triangles.push_back({rim(0, 0), rim(0, side), rim(0, side - 1)});
    drawn.triangles.push_back({rim(nodes - 1, 0), rim(nodes - 1, side - 1), rim(nodes - 1, side)});
  }
  return drawn;
}

/// The nodes, and round each of them a rim across the mean of the elements' directions, not twisted from one to the
/// next.
Matrix3X Cable::surface(const Matrix3X& axis) const {
  const int nodes = node_count();
  const double radius = parameters_.radius > 0 ? parameters_.radius : length() / 500;
  Matrix3X points(3, (1 + kSides) * nodes);
  points.leftCols(nodes) = axis;
  Vector3 normal = Vector3::Zero();
  for (int i = 0; i < nodes; ++i) {
    const Vector3 t = (axis.col(std::min(i + 1, nodes - 1)) - axis.col(std::max(i - 1, 0))).normalized();
    normal -= normal.dot(t) * t;
    normal = normal.norm() > 1e-3 ? Vector3(normal.normalized()) : Vector3(t.unitOrthogonal());
    const Vector3 binormal = t.cross(normal);
    for (int side = 0; side < kSides; ++side) {
      const double angle = 2 * M_PI * side / kSides;
      points.col(nodes + kSides * i + side) =
          axis.col(i) + radius * (std::cos(angle) * normal + std::sin(angle) * binormal);
    }
  }
  return points;
}

void Cable::drawn_points(const BodyState& state, const DrawnMesh&, Matrix3X& points) const {
  points = surface(positions(state));
}

std::vector<std::pair<int, double>> Cable::nodes_of_marker(int marker) const {
  const Place& place = places_[static_cast<std::size_t>(marker)];
  if (place.share == 0) return {{place.element, 1.0}};
  if (place.share == 1) return {{place.element + 1, 1.0}};
  return {{place.element, 1 - place.share}, {place.element + 1, place.share}};
}

}  // namespace lithe
