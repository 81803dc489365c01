#include "engine/factor/block_factor.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "engine/factor/block_kernels.h"
#include "engine/factor/graph_topology.h"

namespace lithe {
namespace {

// Pivots, of the row's own compliance: squared sines of angles to other rows. Bodies that are nearly points have sound
// ones down to 1e-10.
constexpr double kRoundOff = 1e-12, kGives = 1e-10, kWeak = 1e-5;
constexpr int kLargestGuarded = 16;  // rows of a joint

}  // namespace

template <class Scalar>
BlockFactorOf<Scalar>::BlockFactorOf(const BlockStructure& structure) : structure_(structure) {
  for (std::size_t l = 0; l < structure.linears.size(); ++l) linear_.emplace_back(structure, static_cast<int>(l));
  plan();
}

template <class Scalar>
void BlockFactorOf<Scalar>::plan() {
  const auto& s = structure_;
  const int frames = static_cast<int>(s.frames.size()), rows = static_cast<int>(s.rows.size()), n = frames + rows;
  std::vector<int> dimension(n), x(n);
  for (int f = 0; f < frames; ++f) dimension[f] = 6, x[f] = s.frames[f].v;
  for (int r = 0; r < rows; ++r)
    dimension[frames + r] = s.rows[r].count, x[frames + r] = s.velocity_count + s.rows[r].first;

  // The graph: who has a block with whom before elimination.
  Topology topology{frames, std::vector<std::vector<int>>(rows)};
  std::vector<std::pair<int, int>> couplings;
  for (const auto& G : s.jacobians)
    if (G.frame >= 0) topology.ties[G.rows].push_back(G.frame);
  for (auto& tie : topology.ties)
    if (tie.size() < 2) tie.push_back(-1);  // what else it holds is ground, or a body without frame: as good as ground
  for (const auto& c : s.couplings) couplings.emplace_back(c.a, c.b);
  for (const auto& block : linear_)
    for (int a : block.rows())
      for (int b : block.rows())
        if (a < b) couplings.emplace_back(frames + a, frames + b);
  for (const auto& c : s.row_couplings) couplings.emplace_back(frames + c.rows, frames + c.on);
  // Compliant rows always have their pivot: what springs close is no loop to watch in every step.
  Topology joints{frames, {}};
  for (int r = 0; r < rows; ++r)
    if (s.rows[r].compliant < 0) joints.ties.push_back(topology.ties[r]);
  guarded_ = has_loops(joints);
  const Elimination elimination = plan_elimination(topology, dimension, couplings);

  // Factor storage, found by (row vertex, column vertex) while planning only.
  std::vector<std::map<int, int>> at(n);
  int size = 0;
  const auto block = [&](int i, int k) {
    const auto [place, added] = at[i].try_emplace(k, size);
    if (added) size += dimension[i] * dimension[k];
    return place->second;
  };
  diagonal_.resize(n);
  for (int v : elimination.order) diagonal_[v] = block(v, v);
  for (int f = 0; f < frames; ++f) copies_.push_back({s.frames[f].values, diagonal_[f], -1, 6});
  row_copies_.resize(rows);
  for (const auto& G : s.jacobians) {
    if (G.frame < 0) continue;
    const int r = s.rows[G.rows].count;
    const int row_block = block(frames + G.rows, G.frame);
    copies_.push_back({G.values, row_block, block(G.frame, frames + G.rows), r});
    row_copies_[G.rows].push_back(copies_.back());
  }
  for (const auto& c : s.couplings) {
    copies_.push_back({c.ab, block(c.a, c.b), -1, 6});
    copies_.push_back({c.ba, block(c.b, c.a), -1, 6});
  }
  for (auto [a, b] : couplings) block(a, b), block(b, a);
  for (const auto& c : s.row_couplings)
    row_coupling_copies_.push_back(
        {c.values, block(frames + c.rows, frames + c.on), s.rows[c.rows].count * s.rows[c.on].count});
  for (int r = 0; r < rows; ++r)
    if (s.rows[r].compliant >= 0)
      compliant_.insert(compliant_.end(), {diagonal_[frames + r], s.rows[r].compliant, s.rows[r].count});

  for (int v : elimination.order) {
    const std::vector<int>& rest = elimination.neighbours[v];
    const int d = dimension[v];
    Step step{d,
              diagonal_[v],
              x[v],
              static_cast<int>(neighbours_.size()),
              0,
              static_cast<int>(updates_.size()),
              0,
              v < frames ? -1 : s.rows[v - frames].first,
              kernels::choose_invert<Scalar>(d),
              kernels::choose_apply_vector<Scalar>(d)};
    for (int i : rest)
      neighbours_.push_back({block(i, v), block(v, i), x[i], dimension[i],
                             kernels::choose_apply<Scalar>(d, dimension[i]),
                             kernels::choose_multiply_vector<Scalar>(dimension[i], d),
                             kernels::choose_multiply_vector<Scalar>(d, dimension[i])});
    for (int k : rest)
      for (int i : rest)
        updates_.push_back({kernels::choose_product<Scalar>(dimension[i], d, dimension[k]), block(i, k), block(i, v),
                            block(v, k), dimension[i], dimension[k]});
    step.last_neighbour = static_cast<int>(neighbours_.size());
    step.last_update = static_cast<int>(updates_.size());
    steps_.push_back(step);
  }
  blocks_.resize(size);
  // Where each body's Schur complement is subtracted.
  for (const auto& linear : linear_) {
    std::vector<int> vertices;
    const auto& l = s.linears[&linear - linear_.data()];
    if (l.frame >= 0) vertices.push_back(l.frame);
    for (int r : linear.rows()) vertices.push_back(frames + r);
    schur_targets_.emplace_back();
    for (std::size_t k = 0; k < vertices.size(); ++k)
      for (std::size_t i = 0; i < vertices.size(); ++i)
        schur_targets_.back().push_back(block(vertices[i], vertices[k]));
  }
  if (static_cast<int>(blocks_.size()) < size) blocks_.resize(size);

  // What elimination fills in starts from zero.
  std::vector<char> filled(size, 0);
  for (const Copy& c : copies_)
    for (int to : {c.to, c.to_transposed})
      if (to >= 0) std::fill_n(filled.begin() + to, 6 * c.rows, 1);
  for (int i = 0; i < size; ++i) {
    if (filled[i]) continue;
    if (i == 0 || filled[i - 1]) cleared_.emplace_back(i, 0);
    ++cleared_.back().second;
  }
  is_dropped_.assign(s.row_count, 0);
  compliance_.setZero(s.row_count);
  weak_rows_.reserve(s.row_count);
}

template <class Scalar>
void BlockFactorOf<Scalar>::drop_rows(const std::vector<int>& rows) {
  dropped_ = rows;
  std::fill(is_dropped_.begin(), is_dropped_.end(), 0);
  for (int r : rows) is_dropped_[r] = 1;
}

template <class Scalar>
void BlockFactorOf<Scalar>::load(const std::vector<Scalar>& values) {
  for (const auto& [first, count] : cleared_)
    for (Scalar *to = blocks_.data() + first, *end = to + count; to != end; ++to) *to = 0;
  for (const Copy& c : copies_) {
    const Scalar* from = values.data() + c.from;
    Scalar* to = blocks_.data() + c.to;
    if (c.to_transposed < 0)
      Eigen::Map<Eigen::Matrix<Scalar, 6, 6>>{to} = Eigen::Map<const Eigen::Matrix<Scalar, 6, 6>>(from);
    else
      kernels::copy_both(from, to, blocks_.data() + c.to_transposed, c.rows);
  }
  for (std::size_t i = 0; i < compliant_.size(); i += 3)
    for (int r = 0, n = compliant_[i + 2]; r < n; ++r)
      blocks_[compliant_[i] + r * (n + 1)] = values[compliant_[i + 1] + r];
  for (const RowCopy& c : row_coupling_copies_) std::copy_n(values.data() + c.from, c.count, blocks_.data() + c.to);
  if (!dropped_.empty()) clear_dropped();
  for (std::size_t l = 0; l < linear_.size(); ++l) {
    LinearBlock<Scalar>& linear = linear_[l];
    linear.factorize(values, is_dropped_);
    const auto& parts = linear.parts();
    const auto& schur = linear.schur();
    std::size_t target = 0;
    for (const auto& k : parts)
      for (const auto& i : parts) {
        Scalar* to = blocks_.data() + schur_targets_[l][target++];
        for (int b = 0; b < k.size; ++b)
          for (int a = 0; a < i.size; ++a) to[a + i.size * b] += schur(i.column + a, k.column + b);
      }
  }
}

/// A dropped row becomes  -1 · y = 0.
template <class Scalar>
void BlockFactorOf<Scalar>::clear_dropped() {
  const int frames = static_cast<int>(structure_.frames.size());
  for (std::size_t v = 0; v < structure_.rows.size(); ++v) {
    const auto& rows = structure_.rows[v];
    for (int r = 0; r < rows.count; ++r) {
      if (!is_dropped_[rows.first + r]) continue;
      for (const Copy& c : row_copies_[v])
        for (int k = 0; k < 6; ++k) blocks_[c.to + r + rows.count * k] = blocks_[c.to_transposed + k + 6 * r] = 0;
      blocks_[diagonal_[frames + v] + r * (rows.count + 1)] = -1;
    }
  }
}

template <class Scalar>
void BlockFactorOf<Scalar>::eliminate(const Step& s) {
  Scalar* b = blocks_.data();
  const Scalar* P = b + s.diagonal;
  for (int i = s.first_neighbour; i < s.last_neighbour; ++i) {
    const Neighbour& n = neighbours_[i];
    n.apply(P, b + n.column_block, s.dimension, n.dimension);
  }
  for (int i = s.first_update; i < s.last_update; ++i) {
    const Update& u = updates_[i];
    u.product(b + u.target, b + u.row_block, b + u.column_block, u.m, s.dimension, u.n);
  }
}

template <class Scalar>
void BlockFactorOf<Scalar>::factorize(const std::vector<Scalar>& values) {
  load(values);
  weak_rows_.clear();
  if (!guarded_) {
    for (const Step& s : steps_) {
      s.invert(blocks_.data() + s.diagonal, s.dimension);
      eliminate(s);
    }
    return;
  }
  compliance_.setZero();
  for (const Step& s : steps_) {
    if (s.first_row >= 0)
      invert_guarded(s);
    else
      s.invert(blocks_.data() + s.diagonal, s.dimension);
    eliminate(s);
    if (s.first_row < 0) add_compliances(s);
  }
}

/// What this body adds to g S⁻¹ gᵀ of its rows: the scale on which their pivots are judged.
template <class Scalar>
void BlockFactorOf<Scalar>::add_compliances(const Step& s) {
  for (int i = s.first_neighbour; i < s.last_neighbour; ++i) {
    const Neighbour& n = neighbours_[i];
    if (n.x < structure_.velocity_count) continue;
    const Scalar *g = blocks_.data() + n.row_block, *moved = blocks_.data() + n.column_block;
    double* sum = compliance_.data() + n.x - structure_.velocity_count;
    for (int r = 0; r < n.dimension; ++r)
      for (int k = 0; k < 6; ++k) sum[r] += std::abs(g[r + n.dimension * k] * moved[k + 6 * r]);
  }
}

/// A row's pivot is smallest where it goes last in its block: one over the inverse's diagonal. Only where one of those
/// is small is it worth finding the pivots in turn.
template <class Scalar>
void BlockFactorOf<Scalar>::invert_guarded(const Step& s) {
  const int n = s.dimension;
  Scalar* P = blocks_.data() + s.diagonal;
  if (n > kLargestGuarded) return s.invert(P, n);
  Scalar before[kLargestGuarded * kLargestGuarded];
  std::copy_n(P, n * n, before);
  s.invert(P, n);
  const double* reference = compliance_.data() + s.first_row;
  bool sound = true;
  for (int p = 0; p < n; ++p) sound &= std::abs(P[p + n * p]) * kWeak * reference[p] <= 1;  // not where it is no number
  if (sound) return;
  std::copy_n(before, n * n, P);
  guard(s);
  s.invert(P, n);
}

/// Gaussian elimination on a copy of minus the pivot block, a pivot near round-off gives way; small ones are noted
/// where another row may take the place of theirs.
///
/// Where branches of the motion meet, a row's pivot is about δ², δ the angle to that pose, and an error c in g turns
/// the straight way through, x y = 0, into the hyperbola x y = c: exact solutions of that would turn into the other
/// branch at δ = √c. Where the row gives way instead, the motion goes on as its velocity tells.
template <class Scalar>
void BlockFactorOf<Scalar>::guard(const Step& s) {
  const int n = s.dimension;
  Scalar A[kLargestGuarded * kLargestGuarded];
  Scalar* P = blocks_.data() + s.diagonal;
  for (int i = 0; i < n * n; ++i) A[i] = -P[i];
  for (int p = 0; p < n; ++p) {
    const int row = s.first_row + p;
    const double reference = compliance_[row];
    const double pivot = std::abs(A[p + n * p]);
    if (!is_dropped_[row] && pivot < kWeak * reference) {
      if (!dropped_.empty()) weak_rows_.push_back(row);
      if (pivot < kRoundOff * reference) {
        P[p + n * p] -= kGives * reference - A[p + n * p];
        A[p + n * p] = kGives * reference;
      }
    }
    const Scalar inverse = 1.0 / A[p + n * p];
    for (int i = p + 1; i < n; ++i) {
      const Scalar f = A[i + n * p] * inverse;
      for (int k = p + 1; k < n; ++k) A[i + n * k] -= f * A[p + n * k];
    }
  }
}

template <class Scalar>
std::vector<int> BlockFactorOf<Scalar>::factorize_revealing(const std::vector<Scalar>& values, const VectorX& reference,
                                                            double tolerance) {
  using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;
  load(values);
  std::vector<int> dependent;
  for (const Step& s : steps_) {
    Eigen::Map<Matrix> P(blocks_.data() + s.diagonal, s.dimension, s.dimension);
    if (s.first_row >= 0) {
      // Gaussian elimination on a copy, largest relative pivot first; what is left below tolerance is dependent.
      Matrix A = -P;
      std::vector<int> open(s.dimension);
      for (int r = 0; r < s.dimension; ++r) open[r] = r;
      std::vector<int> bad;
      while (!open.empty()) {
        const auto ratio = [&](int r) {  // 0: no body feels this row
          const double scale = reference[s.first_row + r];
          return scale > 0 ? std::real(A(r, r)) / scale : 0.0;
        };
        const auto best =
            std::max_element(open.begin(), open.end(), [&](int a, int b) { return ratio(a) < ratio(b) * (1 - 1e-6); });
        const int p = *best;
        if (!(ratio(p) > tolerance)) {
          bad = open;
          break;
        }
        open.erase(best);
        for (int i : open) {
          const Scalar f = A(i, p) / A(p, p);
          for (int k : open) A(i, k) -= f * A(p, k);
        }
      }
      for (int r : bad) {
        if (is_dropped_[s.first_row + r]) continue;
        dependent.push_back(s.first_row + r);
        P.row(r).setZero();
        P.col(r).setZero();
        P(r, r) = -1;
        for (int i = s.first_neighbour; i < s.last_neighbour; ++i) {
          const Neighbour& n = neighbours_[i];
          Eigen::Map<Matrix>(blocks_.data() + n.row_block, n.dimension, s.dimension).col(r).setZero();
          Eigen::Map<Matrix>(blocks_.data() + n.column_block, s.dimension, n.dimension).row(r).setZero();
        }
      }
    }
    s.invert(P.data(), s.dimension);
    eliminate(s);
  }
  std::vector<int> all = dropped_;
  all.insert(all.end(), dependent.begin(), dependent.end());
  std::sort(all.begin(), all.end());
  drop_rows(all);
  std::sort(dependent.begin(), dependent.end());
  if (!dependent.empty()) factorize(values);  // what came before a dependent row in the order still knew it
  return dependent;
}

template <class Scalar>
void BlockFactorOf<Scalar>::solve(Scalar* x) const {
  const Scalar* b = blocks_.data();
  for (int r : dropped_) x[structure_.velocity_count + r] = 0;
  for (const auto& linear : linear_) linear.forward(x);
  for (int r : dropped_) x[structure_.velocity_count + r] = 0;
  for (const Step& s : steps_) {
    Scalar* y = x + s.x;
    s.apply(b + s.diagonal, y, s.dimension);
    for (int i = s.first_neighbour; i < s.last_neighbour; ++i) {
      const Neighbour& n = neighbours_[i];
      n.forward(x + n.x, b + n.row_block, y, n.dimension, s.dimension);
    }
  }
  for (auto s = steps_.rbegin(); s != steps_.rend(); ++s)
    for (int i = s->first_neighbour; i < s->last_neighbour; ++i) {
      const Neighbour& n = neighbours_[i];
      n.backward(x + s->x, b + n.column_block, x + n.x, s->dimension, n.dimension);
    }
  for (const auto& linear : linear_) linear.backward(x);
}

template class BlockFactorOf<double>;
template class BlockFactorOf<std::complex<double>>;

}  // namespace lithe
