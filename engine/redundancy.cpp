#include "engine/redundancy.h"

#include <algorithm>
#include <map>
#include <numeric>

#include "engine/graph_topology.h"

namespace lithe {
namespace {

VectorX linear_mass(const BlockStructure::Linear& linear, const double* values) {
  if (!linear.pattern) return Eigen::Map<const VectorX>(values + linear.values, linear.size);
  VectorX mass = VectorX::Zero(linear.size);
  for (int k = 0; k < linear.pattern->rows.size(); ++k)
    if (linear.pattern->rows[k] == linear.pattern->columns[k])
      mass[linear.pattern->rows[k]] = values[linear.values + k];
  return mass;
}

/// g M⁻¹ gᵀ of each joint or force, rows x rows.
std::vector<MatrixX> compliances(const BlockStructure& blocks, const std::vector<double>& all) {
  const double* values = all.data();
  std::vector<MatrixX> sums(blocks.rows.size());
  for (std::size_t k = 0; k < sums.size(); ++k) sums[k].setZero(blocks.rows[k].count, blocks.rows[k].count);
  for (const auto& G : blocks.jacobians) {
    const int count = blocks.rows[G.rows].count;
    if (G.frame >= 0) {
      const Eigen::Map<const MatrixX> g(values + G.values, count, 6);
      const Matrix6 M = Eigen::Map<const Matrix6>(values + blocks.frames[G.frame].values);
      sums[G.rows] += g * M.inverse() * g.transpose();
    }
    if (G.linear < 0) continue;
    const auto& linear = blocks.linears[G.linear];
    const Eigen::Map<const MatrixX> g(values + G.linear_values, count, linear.size);
    sums[G.rows] += g * linear_mass(linear, values).cwiseInverse().asDiagonal() * g.transpose();
  }
  return sums;
}

}  // namespace

bool is_tree(const SystemGraph& graph, const Layout& layout) {
  Topology topology{static_cast<int>(layout.bodies().size()), {}};
  std::map<const Body*, int> number;
  for (const auto& s : layout.bodies()) number.emplace(s.body, static_cast<int>(number.size()));
  for (const auto& c : graph.constraints()) {
    std::vector<int> tie;
    for (const Marker& m : c.markers) {
      const auto at = number.find(m.body);  // ground is no body of the layout
      if (at != number.end() && !m.body->coordinates().frame) return false;
      tie.push_back(at == number.end() ? -1 : at->second);
    }
    std::sort(tie.begin(), tie.end());
    tie.erase(std::unique(tie.begin(), tie.end()), tie.end());
    topology.ties.push_back(tie);
  }
  return !has_loops(topology);
}

VectorX row_compliances(const BlockStructure& blocks, const std::vector<double>& values) {
  VectorX diagonal = VectorX::Zero(blocks.row_count);
  const std::vector<MatrixX> sums = compliances(blocks, values);
  for (std::size_t k = 0; k < sums.size(); ++k)
    diagonal.segment(blocks.rows[k].first, blocks.rows[k].count) = sums[k].diagonal();
  return diagonal;
}

std::vector<int> dependent_within_joints(const BlockStructure& blocks, const std::vector<double>& values,
                                         double tolerance) {
  std::vector<int> dependent;
  std::vector<MatrixX> sums = compliances(blocks, values);
  for (std::size_t k = 0; k < sums.size(); ++k) {
    if (blocks.rows[k].compliant >= 0) continue;
    // Gaussian elimination, largest relative pivot first.
    MatrixX& A = sums[k];
    const VectorX reference = A.diagonal();
    std::vector<int> open(A.rows());
    std::iota(open.begin(), open.end(), 0);
    const auto ratio = [&](int r) { return reference[r] > 0 ? A(r, r) / reference[r] : 0; };
    while (!open.empty()) {
      const auto best =
          std::max_element(open.begin(), open.end(), [&](int i, int j) { return ratio(i) < ratio(j) * (1 - 1e-6); });
      const int p = *best;
      if (!(ratio(p) > tolerance)) break;
      open.erase(best);
      for (int i : open) {
        const double f = A(i, p) / A(p, p);
        for (int j : open) A(i, j) -= f * A(p, j);
      }
    }
    for (int r : open) dependent.push_back(blocks.rows[k].first + r);
  }
  std::sort(dependent.begin(), dependent.end());
  return dependent;
}

}  // namespace lithe
