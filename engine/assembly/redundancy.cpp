#include "engine/assembly/redundancy.h"

#include <algorithm>
#include <map>
#include <numeric>

#include "engine/base/dense_inverse.h"
#include "engine/factor/block_products.h"
#include "engine/factor/graph_topology.h"

namespace lithe {
namespace {

/// Bodies by number, in the order of the layout.
Topology topology_of(const SystemGraph& graph, const Layout& layout) {
  std::map<const Body*, int> number;
  for (const auto& s : layout.bodies()) number.emplace(s.body, static_cast<int>(number.size()));
  Topology topology{static_cast<int>(number.size()), {}};
  for (const auto& c : graph.constraints()) {
    std::vector<int> tie;
    for (const Marker& m : c.markers) {
      const auto at = number.find(m.body);  // ground is no body of the layout
      tie.push_back(at == number.end() ? -1 : at->second);
    }
    std::sort(tie.begin(), tie.end());
    tie.erase(std::unique(tie.begin(), tie.end()), tie.end());
    topology.ties.push_back(tie);
  }
  return topology;
}

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
      const MatrixX inverse = inverse_of(Eigen::Map<const Matrix6>(values + blocks.frames[G.frame].values));
      sums[G.rows] += g * inverse * g.transpose();
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
  for (const auto& c : graph.constraints())
    for (const Marker& m : c.markers)
      if (const Coordinates has = m.body->coordinates(); has.v_count() > 0 && has.frames == 0) return false;
  return !has_loops(topology_of(graph, layout));
}

std::string dependent_rows_text(const SystemGraph& graph, const Layout& layout, const std::vector<int>& dependent) {
  constexpr std::size_t kNamed = 3;
  const Topology topology = topology_of(graph, layout);
  const std::vector<int> mechanism = islands(topology);
  // 1. The mechanism of each dependent row: that of any body that its constraint holds.
  std::map<int, int> counts;
  std::size_t constraint = 0;
  for (int row : dependent) {
    while (layout.rows()[constraint].first + layout.rows()[constraint].count <= row) ++constraint;
    const auto& tie = topology.ties[constraint];
    const auto body = std::find_if(tie.begin(), tie.end(), [](int b) { return b >= 0; });
    ++counts[mechanism[*body]];
  }
  // 2. A line for each.
  const std::vector<std::string> bodies = layout.body_names();
  std::string text;
  for (const auto& [number, count] : counts) {
    std::vector<std::string> names;
    for (std::size_t b = 0; b < mechanism.size(); ++b)
      if (mechanism[b] == number) names.push_back("'" + bodies[b] + "'");
    text += (text.empty() ? "mechanism of " : "\nmechanism of ");
    for (std::size_t i = 0; i < std::min(kNamed, names.size()); ++i) text += (i > 0 ? ", " : "") + names[i];
    if (names.size() > kNamed) text += " and " + std::to_string(names.size() - kNamed) + " more";
    text += ": " + std::to_string(count) + (count == 1 ? " dependent constraint row" : " dependent constraint rows") +
            "; the motion is unaffected, reactions are those of least norm";
  }
  return text;
}

VectorX null_vector(const Evaluator& evaluator, int row) {
  const Layout& layout = evaluator.layout();
  VectorX force = VectorX::Zero(layout.v_count()), z = VectorX::Zero(layout.row_count());
  z[row] = 1;
  add_row_forces(evaluator.system().blocks(), evaluator.workspace().values, layout.row_count(), z.data(), nullptr,
                 force.data());
  z.setZero();
  evaluator.solve(force, z);
  z[row] = -1;
  return z;
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
