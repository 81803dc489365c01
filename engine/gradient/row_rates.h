#pragma once

#include <vector>

#include "engine/factor/block_structure.h"

namespace lithe {

/// G v of all rows, the compliant ones last.
inline VectorX rates_of_all_rows(const BlockStructure& blocks, const std::vector<double>& values, const VectorX& v) {
  int count = 0;
  for (const auto& row : blocks.rows) count = std::max(count, row.first + row.count);
  VectorX rates = VectorX::Zero(count);
  for (const auto& G : blocks.jacobians) {
    const auto& row = blocks.rows[static_cast<std::size_t>(G.rows)];
    auto to = rates.segment(row.first, row.count);
    if (G.frame >= 0)
      to.noalias() += Eigen::Map<const MatrixX>(values.data() + G.values, row.count, 6) * v.segment<6>(G.velocity);
    if (G.linear >= 0) {
      const auto& L = blocks.linears[static_cast<std::size_t>(G.linear)];
      to.noalias() +=
          Eigen::Map<const MatrixX>(values.data() + G.linear_values, row.count, L.size) * v.segment(L.v, L.size);
    }
  }
  return rates;
}

}  // namespace lithe
