#include <algorithm>
#include <map>

#include "bodies/flexible/elements/stress_recovery.h"
#include "bodies/flexible/flexible_body.h"
#include "bodies/flexible/surface_mesh.h"
#include "engine/base/error.h"

namespace lithe {
namespace flexible_drawing {

/// Rows 3i, 3i + 1, 3i + 2 of the nodes that are drawn.
std::vector<int> rows_of(const std::vector<int>& nodes, int width) {
  std::vector<int> rows;
  for (int node : nodes)
    for (int i = 0; i < width; ++i) rows.push_back(width * node + i);
  return rows;
}

/// u = [B, Ψ] C w beyond B η, with w_kl = η_k η_l and w_kk = ½ η_k²: of each product η_k η_l.
MatrixX pairs_of(const ModalBasis& basis, const DeflectionMap& map, const std::vector<int>& rows) {
  MatrixX fields(static_cast<Eigen::Index>(rows.size()), map.field_count());
  fields << basis.modes(rows, Eigen::all), basis.deflection->fields(rows, Eigen::all);
  MatrixX pairs = fields * map.curvature();
  for (int k = 0; k < map.mode_count(); ++k) pairs.col(k * (k + 1) / 2 + k) /= 2;
  return pairs;
}

/// The stress modes of the small strain of B, which is all that is linear in η. No columns where elements or materials
/// are missing.
MatrixX stress_of(const ModalBasis& basis, int modes, const std::vector<int>& nodes) {
  MatrixX stress(6 * static_cast<Eigen::Index>(nodes.size()), modes);
  try {
    const StressRecovery recovery(basis);
    for (int k = 0; k < modes; ++k) {
      Matrix6X field = recovery.stress(VectorX::Unit(recovery.coordinate_count(), k))(Eigen::all, nodes);
      field.row(4).swap(field.row(5));  // xy xz yz there
      stress.col(k) = field.reshaped();
    }
  } catch (const SceneError&) {
    stress.resize(stress.rows(), 0);
  }
  return stress;
}

}  // namespace flexible_drawing

DrawnMesh FlexibleBody::drawn_mesh(bool with_stress) const {
  const ModalBasis& all = basis();
  DrawnMesh mesh;
  if (all.elements.empty()) return mesh;
  try {
    mesh.triangles = boundary_triangles(all.elements, all.nodes);
    mesh.edges = boundary_edges(all.elements, all.nodes);
  } catch (const SceneError&) {  // of a type whose faces are not known
    return {};
  }
  // Points: the nodes of the surface, and those that markers follow.
  std::map<int, int> place;
  const auto add = [&](int node) {
    const auto [found, is_new] = place.try_emplace(node, static_cast<int>(mesh.nodes.size()));
    if (is_new) mesh.nodes.push_back(node);
    return found->second;
  };
  for (auto& triangle : mesh.triangles)
    for (int& corner : triangle) corner = add(corner);
  for (auto& edge : mesh.edges)
    for (int& end : edge) end = add(end);
  for (const MarkerShape& marker : markers_)
    for (int node : marker.nodes.nodes) add(node);
  mesh.points = all.nodes(Eigen::all, mesh.nodes);
  mesh.nodal = all.nodal && modes_ > 0;
  const std::vector<int> rows = flexible_drawing::rows_of(mesh.nodes, 3);
  if (mesh.nodal) return mesh;
  mesh.modes.resize(static_cast<Eigen::Index>(rows.size()), modes_);
  if (modes_ > 0) mesh.modes = all.modes(rows, Eigen::all).leftCols(modes_);
  mesh.frequencies = all.frequencies.head(std::min<Eigen::Index>(all.frequencies.size(), modes_));
  if (deflection_) mesh.pairs = flexible_drawing::pairs_of(all, *deflection_, rows);
  if (with_stress && modes_ > 0) mesh.stress = flexible_drawing::stress_of(all, modes_, mesh.nodes);
  return mesh;
}

void FlexibleBody::drawn_points(const BodyState& state, const DrawnMesh& mesh, Matrix3X& points) const {
  Matrix3X moved = basis().nodes;
  for (int k = 0; k < modes_; ++k) moved.data()[basis().free_dofs[static_cast<std::size_t>(k)]] += state.q[7 + k];
  points = moved(Eigen::all, mesh.nodes);
}

std::vector<std::pair<int, double>> FlexibleBody::nodes_of_marker(int marker) const {
  const MarkerNodes& nodes = marker_nodes(marker);
  std::vector<std::pair<int, double>> all;
  for (std::size_t i = 0; i < nodes.nodes.size(); ++i)
    all.emplace_back(nodes.nodes[i],
                     nodes.weights.empty() ? 1.0 / static_cast<double>(nodes.nodes.size()) : nodes.weights[i]);
  return all;
}

}  // namespace lithe
