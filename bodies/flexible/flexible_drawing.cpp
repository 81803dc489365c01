#include <algorithm>
#include <map>

#include "bodies/flexible/drawn_skin.h"
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

/// u = [B, Ψ] C w beyond B η, with w_kl = η_k η_l and w_kk = ½ η_k²: of each product η_k η_l. `modes` and `fields`: B
/// and Ψ at the points that are drawn.
MatrixX pairs_of(const DeflectionMap& map, const MatrixX& modes, const MatrixX& fields) {
  MatrixX both(modes.rows(), map.field_count());
  both << modes, fields;
  MatrixX pairs = both * map.curvature();
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

/// The points of a skin; the node of each is the nearer of its two.
DrawnMesh points_of(const DrawnSkin& skin) {
  DrawnMesh mesh;
  mesh.points = skin.points;
  mesh.triangles = skin.triangles;
  mesh.edges = skin.edges;
  for (std::size_t p = 0; p < skin.nodes.size(); ++p) mesh.nodes.push_back(skin.nodes[p][skin.shares[p] > 0.5 ? 1 : 0]);
  return mesh;
}

/// The nodes of the surface of elements, and those that markers follow; empty where the faces are not known.
DrawnMesh points_of(const ModalBasis& basis, const std::vector<int>& followed) {
  DrawnMesh mesh;
  if (basis.elements.empty()) return mesh;
  try {
    mesh.triangles = boundary_triangles(basis.elements, basis.nodes);
    mesh.edges = boundary_edges(basis.elements, basis.nodes);
  } catch (const SceneError&) {
    return {};
  }
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
  for (int node : followed) add(node);
  mesh.points = basis.nodes(Eigen::all, mesh.nodes);
  return mesh;
}

}  // namespace flexible_drawing

DrawnMesh FlexibleBody::drawn_mesh(bool with_stress) const {
  const ModalBasis& all = basis();
  std::vector<int> followed;
  for (const MarkerShape& marker : markers_)
    followed.insert(followed.end(), marker.nodes.nodes.begin(), marker.nodes.nodes.end());
  DrawnMesh mesh = all.skin ? flexible_drawing::points_of(*all.skin) : flexible_drawing::points_of(all, followed);
  if (mesh.points.cols() == 0) return mesh;
  mesh.nodal = all.nodal && modes_ > 0;
  if (mesh.nodal) return mesh;
  const std::vector<int> rows = flexible_drawing::rows_of(mesh.nodes, 3);
  const SparseMatrix motion = all.skin ? skin_motion(*all.skin, all.nodes, all.rotations) : SparseMatrix();
  const auto at_points = [&](const MatrixX& fields) -> MatrixX {
    return all.skin ? MatrixX(motion * fields) : MatrixX(fields(rows, Eigen::all));
  };
  mesh.modes.resize(mesh.points.size(), modes_);
  if (modes_ > 0) mesh.modes = at_points(all.modes).leftCols(modes_);
  mesh.frequencies = all.frequencies.head(std::min<Eigen::Index>(all.frequencies.size(), modes_));
  if (deflection_)
    mesh.pairs = flexible_drawing::pairs_of(*deflection_, at_points(all.modes), at_points(all.deflection->fields));
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
