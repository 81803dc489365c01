#include "engine/factor/block_products.h"

#include "engine/factor/block_kernels.h"

namespace lithe {
namespace {

/// force += Gᵀ y on a plain frame: the translations feel ±y, or nothing; of the rates of G, nothing either.
void add_to_plain_frame(const double* G, int rows, int point, const double* y, double* force) {
  const double* turns = G + 3 * rows;
  Lanes torque = lanes::load3(force + 3);
  int first = 0;
  if (point != 0) {
    const Lanes pull = lanes::load3(y);
    lanes::store3(lanes::load3(force) + G[0] * pull, force);
    torque += lanes::transposed(lanes::load3x3(turns, rows)) * pull;
    first = 3;
  }
  for (int r = first; r < rows; ++r) torque += lanes::of(turns[r], turns[r + rows], turns[r + 2 * rows]) * y[r];
  lanes::store3(torque, force + 3);
}

inline void add_row_force(const BlockStructure& blocks, const std::vector<double>& values,
                          const BlockStructure::Jacobian& G, int constraint_rows, const double* lambda,
                          const double* tension, double* force) {
  const auto& row = blocks.rows[G.rows];
  if (row.first >= constraint_rows ? !tension : !lambda) return;
  const double* y = row.first < constraint_rows ? lambda + row.first : tension + row.first - constraint_rows;
  double* to = force + G.velocity;
  if (G.frame >= 0 && blocks.frames[G.frame].plain)
    return add_to_plain_frame(values.data() + G.values, row.count, G.point, y, to);
  if (G.frame >= 0) kernels::add_transposed(to, values.data() + G.values, y, row.count, 6);
  if (G.linear >= 0) {
    const auto& L = blocks.linears[G.linear];
    kernels::add_transposed(force + L.v, values.data() + G.linear_values, y, row.count, L.size);
  }
}

}  // namespace

void add_row_forces(const BlockStructure& blocks, const std::vector<double>& values, int constraint_rows,
                    const double* lambda, const double* tension, double* force) {
  for (const auto& G : blocks.jacobians) add_row_force(blocks, values, G, constraint_rows, lambda, tension, force);
}

void add_row_forces(const BlockStructure& blocks, const std::vector<double>& values, std::span<const int> jacobians,
                    int constraint_rows, const double* lambda, const double* tension, double* force) {
  for (int i : jacobians) add_row_force(blocks, values, blocks.jacobians[i], constraint_rows, lambda, tension, force);
}

void add_rates(const BlockStructure& blocks, const std::vector<double>& values, const double* v, VectorRef rates) {
  for (const auto& G : blocks.jacobians) {
    const auto& row = blocks.rows[G.rows];
    if (row.first >= rates.size()) continue;  // compliant
    double* to = rates.data() + row.first;
    if (G.frame >= 0) kernels::add_product(to, values.data() + G.values, v + G.velocity, row.count, 6);
    if (G.linear >= 0) {
      const auto& L = blocks.linears[G.linear];
      kernels::add_product(to, values.data() + G.linear_values, v + L.v, row.count, L.size);
    }
  }
}

void visit_blocks(const BlockStructure& b, const std::vector<double>& all,
                  const std::function<void(int, int, ConstMatrixRef)>& visit) {
  const double* values = all.data();
  using View = Eigen::Map<const MatrixX>;
  // 1. S: bodies by themselves, then what couples frames.
  for (const auto& f : b.frames) visit(f.v, f.v, View(values + f.values, 6, 6));
  for (const auto& l : b.linears) {
    for (int f = 0; f < l.frames; ++f) {
      const int v = b.frames[l.frame + f].v, at = 6 * l.size * f;
      visit(v, l.v, View(values + l.frame_linear + at, 6, l.size));
      visit(l.v, v, View(values + l.linear_frame + at, l.size, 6));
    }
    if (!l.pattern) {
      for (int i = 0; i < l.size; ++i) visit(l.v + i, l.v + i, View(values + l.values + i, 1, 1));
    } else {
      for (int k = 0; k < l.pattern->rows.size(); ++k) {
        const int r = l.pattern->rows[k], c = l.pattern->columns[k];
        visit(l.v + r, l.v + c, View(values + l.values + k, 1, 1));
        if (r != c) visit(l.v + c, l.v + r, View(values + l.values + k, 1, 1));
      }
    }
  }
  for (const auto& c : b.couplings) {
    visit(b.frames[c.a].v, b.frames[c.b].v, View(values + c.ab, 6, 6));
    visit(b.frames[c.b].v, b.frames[c.a].v, View(values + c.ba, 6, 6));
  }
  // 2. G and Gᵀ.
  for (const auto& G : b.jacobians) {
    const auto& row = b.rows[G.rows];
    const auto both = [&](int v, const MatrixX& block) {
      visit(b.velocity_count + row.first, v, block);
      visit(v, b.velocity_count + row.first, block.transpose());
    };
    if (G.frame >= 0) both(G.velocity, View(values + G.values, row.count, 6));
    if (G.linear >= 0) both(b.linears[G.linear].v, View(values + G.linear_values, row.count, b.linears[G.linear].size));
  }
  // 3. What tensions owe to multipliers, and -C.
  for (const auto& c : b.row_couplings)
    visit(b.velocity_count + b.rows[c.rows].first, b.velocity_count + b.rows[c.on].first,
          View(values + c.values, b.rows[c.rows].count, b.rows[c.on].count));
  for (const auto& row : b.rows)
    for (int i = 0; row.compliant >= 0 && i < row.count; ++i)
      visit(b.velocity_count + row.first + i, b.velocity_count + row.first + i, View(values + row.compliant + i, 1, 1));
}

}  // namespace lithe
