#include "bodies/flexible/drawn_skin.h"

namespace lithe {

SparseMatrix skin_motion(const DrawnSkin& skin, const Matrix3X& nodes, const std::vector<RotationalDof>& rotations) {
  const int n = static_cast<int>(nodes.cols());
  // Degrees of freedom of a node's turns; -1: it has none.
  std::vector<std::array<int, 3>> turns(static_cast<std::size_t>(n), {-1, -1, -1});
  for (std::size_t k = 0; k < rotations.size(); ++k)
    turns[static_cast<std::size_t>(rotations[k].node)][static_cast<std::size_t>(rotations[k].axis)] =
        3 * n + static_cast<int>(k);
  std::vector<Eigen::Triplet<double>> entries;
  for (int p = 0; p < skin.points.cols(); ++p) {
    const auto point = static_cast<std::size_t>(p);
    for (const int end : {0, 1}) {
      const double weight = end == 1 ? skin.shares[point] : 1 - skin.shares[point];
      if (weight == 0) continue;
      const int node = skin.nodes[point][static_cast<std::size_t>(end)];
      const Vector3 arm = skin.points.col(p) - nodes.col(node);
      for (int axis = 0; axis < 3; ++axis) {
        entries.emplace_back(3 * p + axis, 3 * node + axis, weight);
        const int turn = turns[static_cast<std::size_t>(node)][static_cast<std::size_t>(axis)];
        if (turn < 0) continue;
        const Vector3 u = weight * Vector3::Unit(axis).cross(arm);
        for (int i = 0; i < 3; ++i)
          if (u[i] != 0) entries.emplace_back(3 * p + i, turn, u[i]);
      }
    }
  }
  SparseMatrix motion(3 * skin.points.cols(), 3 * n + static_cast<Eigen::Index>(rotations.size()));
  motion.setFromTriplets(entries.begin(), entries.end());
  return motion;
}

}  // namespace lithe
