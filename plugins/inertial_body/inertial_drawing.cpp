#include <algorithm>
#include <map>
#include <set>

#include "plugins/inertial_body/inertial_body.h"

namespace lithe {

DrawnMesh InertialBody::drawn_mesh(bool) const {
  // Faces that one brick alone has, counter-clockwise from outside.
  static constexpr int kFaces[6][4] = {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4},
                                       {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};
  std::map<std::array<int, 4>, std::pair<std::array<int, 4>, int>> faces;
  for (const auto& element : mesh().elements)
    for (const auto& face : kFaces) {
      std::array<int, 4> loop{};
      for (std::size_t i = 0; i < 4; ++i) loop[i] = element[static_cast<std::size_t>(face[i])];
      std::array<int, 4> key = loop;
      std::sort(key.begin(), key.end());
      auto& found = faces.try_emplace(key, loop, 0).first->second;
      ++found.second;
    }
  DrawnMesh drawn;
  drawn.nodal = true;
  std::map<int, int> place;
  const auto point = [&](int node) {
    const auto [found, is_new] = place.try_emplace(node, static_cast<int>(drawn.nodes.size()));
    if (is_new) drawn.nodes.push_back(node);
    return found->second;
  };
  std::set<std::array<int, 2>> edges;
  for (const auto& [key, face] : faces) {
    if (face.second != 1) continue;
    std::array<int, 4> at{};
    for (std::size_t i = 0; i < 4; ++i) at[i] = point(face.first[i]);
    drawn.triangles.push_back({at[0], at[1], at[2]});
    drawn.triangles.push_back({at[0], at[2], at[3]});
    for (std::size_t i = 0; i < 4; ++i)
      edges.insert({std::min(at[i], at[(i + 1) % 4]), std::max(at[i], at[(i + 1) % 4])});
  }
  drawn.edges.assign(edges.begin(), edges.end());
  for (const MarkerShape& marker : markers_)
    for (int node : marker.points) point(node);
  drawn.points = mesh().nodes(Eigen::all, drawn.nodes);
  return drawn;
}

void InertialBody::drawn_points(const BodyState& state, const DrawnMesh& drawn, Matrix3X& points) const {
  points = positions(state)(Eigen::all, drawn.nodes);
}

std::vector<std::pair<int, double>> InertialBody::nodes_of_marker(int marker) const {
  std::vector<std::pair<int, double>> all;
  const std::vector<int>& nodes = markers_[static_cast<std::size_t>(marker)].points;
  for (int node : nodes) all.emplace_back(node, 1.0 / static_cast<double>(nodes.size()));
  return all;
}

}  // namespace lithe
