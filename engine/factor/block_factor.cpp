#include "engine/factor/block_factor.h"

#include <algorithm>
#include <cmath>
#include <type_traits>

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

/// A body without a frame that has no more coordinates than one: planar, a point, a number. Its joints close loops too.
template <class Scalar>
bool BlockFactorOf<Scalar>::is_small(std::size_t linear) const {
  return structure_.linears[linear].frames == 0 && structure_.linears[linear].size <= 6;
}

template <class Scalar>
void BlockFactorOf<Scalar>::plan() {
  const auto& s = structure_;
  const int frames = static_cast<int>(s.frames.size()), rows = static_cast<int>(s.rows.size());
  // Vertices: frames (of plain ones the turns alone), rows, then the translations of plain frames.
  std::vector<int> dimension, x, translations(frames, -1);
  for (const auto& f : s.frames) dimension.push_back(f.plain ? 3 : 6), x.push_back(f.plain ? f.v + 3 : f.v);
  for (const auto& r : s.rows) dimension.push_back(r.count), x.push_back(s.velocity_count + r.first);
  for (int f = 0; f < frames; ++f) {
    if (!s.frames[f].plain) continue;
    translations[f] = static_cast<int>(masses_.size());
    masses_.push_back({s.frames[f].values, s.frames[f].v, 0, 0, 0, 0});
  }
  std::vector<std::vector<int>> held(masses_.size()), signs(masses_.size());  // rows that hold points of each
  const int others = frames + rows;

  // The graph: who has a block with whom before elimination.
  Topology topology{frames, std::vector<std::vector<int>>(rows)};
  std::vector<std::pair<int, int>> couplings;
  for (const auto& G : s.jacobians) {
    if (G.frame < 0) continue;
    topology.ties[G.rows].push_back(G.frame);
    if (translations[G.frame] < 0 || G.point == 0) continue;
    held[translations[G.frame]].push_back(frames + G.rows);
    signs[translations[G.frame]].push_back(G.point);
  }
  for (auto& tie : topology.ties)
    if (tie.size() < 2) tie.push_back(-1);  // what else it holds is ground, or a body without frame: as good as ground
  for (const auto& c : s.couplings) couplings.emplace_back(c.a, c.b);
  for (std::size_t l = 0; l < linear_.size(); ++l) {
    const auto& block = linear_[l];
    for (int a : block.rows())
      for (int b : block.rows())
        if (a < b) couplings.emplace_back(frames + a, frames + b);
    // Of several frames: all know each other, and all rows at the linear coordinates.
    const int first = s.linears[l].frame, last = first + s.linears[l].frames;
    for (int a = first; a < last && last - first > 1; ++a) {
      for (int b = a + 1; b < last; ++b) couplings.emplace_back(a, b);
      for (int r : block.rows())
        if (auto& tie = topology.ties[r]; std::find(tie.begin(), tie.end(), a) == tie.end()) tie.push_back(a);
    }
  }
  for (const auto& c : s.row_couplings) couplings.emplace_back(frames + c.rows, frames + c.on);
  // Compliant rows always have their pivot: what springs close is no loop to watch in every step.
  Topology joints{frames + static_cast<int>(linear_.size()), topology.ties};
  for (std::size_t l = 0; l < linear_.size(); ++l)
    if (is_small(l))
      for (int r : linear_[l].rows()) {
        std::erase(joints.ties[r], -1);
        joints.ties[r].push_back(frames + static_cast<int>(l));
      }
  for (int r = rows - 1; r >= 0; --r) {
    if (joints.ties[r].size() < 2) joints.ties[r].push_back(-1);
    if (s.rows[r].compliant >= 0) joints.ties.erase(joints.ties.begin() + r);
  }
  guarded_ = has_loops(joints);
  const Elimination elimination = plan_elimination(topology, dimension, couplings, held);

  // 1. The blocks of each row vertex: where they lie in the factor, where their values come from.
  struct Place {
    int column, at = -1, source = -1;
    bool ready = false;
  };
  std::vector<std::vector<Place>> places(others);
  std::vector<Copy> sources;
  int size = 0;
  const auto place = [&](int i, int k) -> Place& {
    auto& row = places[i];
    auto found =
        std::lower_bound(row.begin(), row.end(), k, [](const Place& p, int column) { return p.column < column; });
    if (found == row.end() || found->column != k) found = row.insert(found, Place{k});
    return *found;
  };
  const auto block = [&](int i, int k) {
    Place& p = place(i, k);
    if (p.at < 0) p.at = size, size += kernels::stride<Scalar>(dimension[i]) * dimension[k];
    return p.at;
  };
  const auto source = [&](int i, int k, int from, int stride) {
    place(i, k).source = static_cast<int>(sources.size());
    sources.push_back(
        {kernels::choose_copy<Scalar>(dimension[i], dimension[k]), from, -1, -1, dimension[i], dimension[k], stride});
  };
  const auto turns = [&](int frame) { return s.frames[frame].plain ? 3 : 0; };  // where a frame's vertex begins
  for (int f = 0; f < frames; ++f) source(f, f, s.frames[f].values + 7 * turns(f), 6);
  for (const auto& G : s.jacobians) {
    if (G.frame < 0) continue;
    const int r = s.rows[G.rows].count;
    source(frames + G.rows, G.frame, G.values + r * turns(G.frame), r);
  }
  for (const auto& c : s.couplings) {
    source(c.a, c.b, c.ab + turns(c.a) + 6 * turns(c.b), 6);
    source(c.b, c.a, c.ba + turns(c.b) + 6 * turns(c.a), 6);
  }
  for (const auto& c : s.row_couplings) source(frames + c.rows, frames + c.on, c.values, s.rows[c.rows].count);

  // 2. A block is copied, or cleared, by the step that touches it first, of G with its transpose; where that step is to
  // subtract from it and nothing is there yet, it writes. Whether it does.
  const auto touch = [&](int i, int k, bool subtracts) {
    if (place(i, k).ready) return false;
    place(i, k).ready = true;
    const bool transpose = i < frames && k >= frames;
    const int row = transpose ? k : i, column = transpose ? i : k;
    const int from = place(row, column).source;
    if (from >= 0) {
      Copy copy = sources[from];
      copy.to = block(row, column);
      if (row >= frames && column < frames) {
        copy.to_transposed = block(column, row);
        place(row, column).ready = place(column, row).ready = true;
      }
      copies_.push_back(copy);
      return false;
    }
    const int to = block(i, k);
    if (!subtracts) cleared_.push_back({to, kernels::stride<Scalar>(dimension[i]) * dimension[k]});
    return subtracts;
  };
  // Before all steps: what the bodies' linear coordinates add to, and compliances.
  for (std::size_t l = 0; l < linear_.size(); ++l) {
    std::vector<int> vertices;
    for (int f = 0; f < s.linears[l].frames; ++f) vertices.push_back(s.linears[l].frame + f);
    for (int r : linear_[l].rows()) vertices.push_back(frames + r);
    schur_targets_.emplace_back();
    for (int k : vertices)
      for (int i : vertices) touch(i, k, false), schur_targets_.back().push_back(block(i, k));
  }
  for (int r = 0; r < rows; ++r) {
    if (s.rows[r].compliant < 0) continue;
    touch(frames + r, frames + r, false);
    compliant_.insert(compliant_.end(), {block(frames + r, frames + r), s.rows[r].compliant, s.rows[r].count});
  }
  first_copies_ = static_cast<int>(copies_.size()), first_cleared_ = static_cast<int>(cleared_.size());

  // 3. The steps.
  for (int v : elimination.order) {
    Step step{};
    step.first_neighbour = static_cast<int>(neighbours_.size()), step.first_update = static_cast<int>(updates_.size());
    step.first_copy = static_cast<int>(copies_.size()), step.first_cleared = static_cast<int>(cleared_.size());
    step.mass = v < others ? -1 : v - others;
    step.first_row = v >= frames && v < others ? s.rows[v - frames].first : -1;
    if (step.mass >= 0) {
      Mass& mass = masses_[step.mass];
      const auto &pinned = held[step.mass], &sign = signs[step.mass];
      mass.first_pin = static_cast<int>(pins_.size()), mass.first_pair = static_cast<int>(pairs_.size());
      for (std::size_t i = 0; i < pinned.size(); ++i)
        pins_.push_back({x[pinned[i]], s.rows[pinned[i] - frames].first, sign[i]});
      for (std::size_t k = 0; k < pinned.size(); ++k)
        for (std::size_t i = 0; i < pinned.size(); ++i) {
          const bool fresh = touch(pinned[i], pinned[k], true);
          pairs_.push_back({block(pinned[i], pinned[k]), mass.first_pin + static_cast<int>(i),
                            mass.first_pin + static_cast<int>(k), dimension[pinned[i]], dimension[pinned[k]], fresh});
        }
      mass.last_pin = static_cast<int>(pins_.size()), mass.last_pair = static_cast<int>(pairs_.size());
    } else {
      const int d = dimension[v];
      const std::vector<int>& rest = elimination.neighbours[v];
      step.dimension = d, step.x = x[v];
      step.invert = kernels::choose_invert<Scalar>(d), step.apply = kernels::choose_apply_vector<Scalar>(d);
      touch(v, v, false);
      step.diagonal = block(v, v);
      for (int i : rest) {
        touch(i, v, false), touch(v, i, false);
        neighbours_.push_back({block(i, v), block(v, i), x[i], dimension[i],
                               kernels::choose_apply<Scalar>(d, dimension[i]),
                               kernels::choose_multiply_vector<Scalar>(dimension[i], d),
                               kernels::choose_multiply_vector<Scalar>(d, dimension[i])});
      }
      for (int k : rest)
        for (int i : rest) {
          const bool fresh = touch(i, k, true);
          updates_.push_back({kernels::choose_product<Scalar>(dimension[i], d, dimension[k], fresh), block(i, k),
                              block(i, v), block(v, k), dimension[i], dimension[k]});
        }
    }
    step.last_neighbour = static_cast<int>(neighbours_.size());
    step.last_update = static_cast<int>(updates_.size());
    step.last_copy = static_cast<int>(copies_.size()), step.last_cleared = static_cast<int>(cleared_.size());
    steps_.push_back(step);
  }
  blocks_.assign(size, Scalar(0));
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
Scalar& BlockFactorOf<Scalar>::entry(int block, int row, int column, int rows) {
  return blocks_[block + kernels::place<Scalar>(row, rows) + kernels::stride<Scalar>(rows) * column];
}

/// What is there before all steps.
template <class Scalar>
void BlockFactorOf<Scalar>::load_first(const std::vector<Scalar>& values) {
  Step first{};
  first.last_copy = first_copies_, first.last_cleared = first_cleared_;
  load(first, values);
  for (std::size_t i = 0; i < compliant_.size(); i += 3)
    for (int r = 0, n = compliant_[i + 2]; r < n; ++r) entry(compliant_[i], r, r, n) = values[compliant_[i + 1] + r];
  for (std::size_t l = 0; l < linear_.size(); ++l) {
    LinearBlock<Scalar>& linear = linear_[l];
    linear.factorize(values, is_dropped_);
    const auto& parts = linear.parts();
    const auto& schur = linear.schur();
    std::size_t target = 0;
    for (const auto& k : parts)
      for (const auto& i : parts) {
        const int to = schur_targets_[l][target++];
        for (int b = 0; b < k.size; ++b)
          for (int a = 0; a < i.size; ++a) entry(to, a, b, i.size) += schur(i.column + a, k.column + b);
      }
    if (!guarded_ || !is_small(l)) continue;
    for (const auto& part : parts)
      if (part.x >= structure_.velocity_count)
        for (int a = 0; a < part.size; ++a)
          compliance_[part.x - structure_.velocity_count + a] += std::abs(schur(part.column + a, part.column + a));
  }
}

/// The blocks that a step is the first to touch.
template <class Scalar>
void BlockFactorOf<Scalar>::load(const Step& s, const std::vector<Scalar>& values) {
  Scalar* b = blocks_.data();
  for (int i = s.first_cleared; i < s.last_cleared; ++i)
    std::fill_n(b + cleared_[i].first, cleared_[i].count, Scalar(0));
  for (int i = s.first_copy; i < s.last_copy; ++i) {
    const Copy& c = copies_[i];
    c.copy(values.data() + c.from, b + c.to, c.to_transposed < 0 ? nullptr : b + c.to_transposed, c.m, c.n, c.stride);
  }
}

/// Takes dropped rows out of the blocks of a step before it eliminates: a dropped row becomes  -1 · y = 0.
template <class Scalar>
void BlockFactorOf<Scalar>::drop(const Step& s) {
  const auto clear = [&](int row_block, int column_block, int rows, int columns, int row) {
    for (int k = 0; k < columns; ++k) entry(row_block, row, k, rows) = 0, entry(column_block, k, row, columns) = 0;
  };
  for (int r = 0; s.first_row >= 0 && r < s.dimension; ++r) {
    if (!is_dropped_[s.first_row + r]) continue;
    for (int k = 0; k < s.dimension; ++k)
      entry(s.diagonal, r, k, s.dimension) = entry(s.diagonal, k, r, s.dimension) = 0;
    entry(s.diagonal, r, r, s.dimension) = -1;
    for (int i = s.first_neighbour; i < s.last_neighbour; ++i) {
      const Neighbour& n = neighbours_[i];
      clear(n.column_block, n.row_block, s.dimension, n.dimension, r);
    }
  }
  for (int i = s.first_neighbour; i < s.last_neighbour; ++i) {
    const Neighbour& n = neighbours_[i];
    const int first = n.x - structure_.velocity_count;
    for (int r = 0; first >= 0 && r < n.dimension; ++r)
      if (is_dropped_[first + r]) clear(n.row_block, n.column_block, n.dimension, s.dimension, r);
  }
}

/// C -= ±E / m in rows and columns 0 to 2 of the block of each pair of pins.
template <class Scalar>
void BlockFactorOf<Scalar>::eliminate_mass(const Step& s, const std::vector<Scalar>& values) {
  Mass& mass = masses_[s.mass];
  mass.inverse = 1.0 / values[mass.value];
  const kernels::Diagonal3<Scalar> minus(-mass.inverse), plus(mass.inverse);
  for (int i = mass.first_pair; i < mass.last_pair; ++i) {
    const Pair& p = pairs_[i];
    Scalar* to = blocks_.data() + p.target;
    const int stride = kernels::stride<Scalar>(p.rows);
    const auto& part = pins_[p.a].sign == pins_[p.b].sign ? minus : plus;
    if (p.fresh)
      part.put(to, stride, p.columns);
    else
      part.add_to(to, stride);
  }
  // What rows feel of the scale on which their pivots are judged.
  if (!guarded_) return;
  for (int i = mass.first_pin; i < mass.last_pin; ++i)
    for (int k = 0; k < 3; ++k) compliance_[pins_[i].row + k] += std::abs(mass.inverse);
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
  if (guarded_) compliance_.setZero();
  load_first(values);
  weak_rows_.clear();
  const bool drops = !dropped_.empty();
  for (const Step& s : steps_) {
    load(s, values);
    if (s.mass >= 0) {
      eliminate_mass(s, values);
      continue;
    }
    if (drops) drop(s);
    const bool watched = guarded_ && s.first_row >= 0;
    if (watched)
      invert_guarded(s);
    else
      s.invert(blocks_.data() + s.diagonal, s.dimension);
    eliminate(s);
    if (guarded_ && !watched) add_compliances(s);
  }
}

/// What this body adds to g S⁻¹ gᵀ of its rows: the scale on which their pivots are judged.
template <class Scalar>
void BlockFactorOf<Scalar>::add_compliances(const Step& s) {
  for (int i = s.first_neighbour; i < s.last_neighbour; ++i) {
    const Neighbour& n = neighbours_[i];
    if (n.x < structure_.velocity_count) continue;
    double* sum = compliance_.data() + n.x - structure_.velocity_count;
    for (int r = 0; r < n.dimension; ++r)
      for (int k = 0; k < s.dimension; ++k)
        sum[r] += std::abs(entry(n.row_block, r, k, n.dimension) * entry(n.column_block, k, r, s.dimension));
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
  const int size = kernels::stride<Scalar>(n) * n;
  std::copy_n(P, size, before);
  s.invert(P, n);
  const double* reference = compliance_.data() + s.first_row;
  bool sound = true;
  for (int p = 0; p < n; ++p)
    sound &= std::abs(entry(s.diagonal, p, p, n)) * kWeak * reference[p] <= 1;  // not where it is no number
  if (sound) return;
  std::copy_n(before, size, P);
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
  for (int k = 0; k < n; ++k)
    for (int i = 0; i < n; ++i) A[i + n * k] = -entry(s.diagonal, i, k, n);
  for (int p = 0; p < n; ++p) {
    const int row = s.first_row + p;
    const double reference = compliance_[row];
    const double pivot = std::abs(A[p + n * p]);
    if (!is_dropped_[row] && pivot < kWeak * reference) {
      if (!dropped_.empty()) weak_rows_.push_back(row);
      if (pivot < kRoundOff * reference) {
        entry(s.diagonal, p, p, n) -= kGives * reference - A[p + n * p];
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
                                                            double tolerance, double doubt,
                                                            std::vector<int>& doubtful) {
  using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;
  load_first(values);
  std::vector<int> dependent;
  for (const Step& s : steps_) {
    load(s, values);
    if (s.mass >= 0) {
      eliminate_mass(s, values);
      continue;
    }
    drop(s);
    if (s.first_row >= 0) {
      // Gaussian elimination on a copy, largest relative pivot first; what is left below tolerance is dependent.
      Matrix A(s.dimension, s.dimension);
      for (int k = 0; k < s.dimension; ++k)
        for (int i = 0; i < s.dimension; ++i) A(i, k) = -entry(s.diagonal, i, k, s.dimension);
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
        if (!(ratio(p) > doubt)) doubtful.push_back(s.first_row + p);
        open.erase(best);
        for (int i : open) {
          const Scalar f = A(i, p) / A(p, p);
          for (int k : open) A(i, k) -= f * A(p, k);
        }
      }
      for (int r : bad) {
        if (is_dropped_[s.first_row + r]) continue;
        dependent.push_back(s.first_row + r);
        is_dropped_[s.first_row + r] = 1;
      }
      if (!bad.empty()) drop(s);
    }
    s.invert(blocks_.data() + s.diagonal, s.dimension);
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
  const bool drops = !dropped_.empty();
  for (int r : dropped_) x[structure_.velocity_count + r] = 0;
  for (const auto& linear : linear_) linear.forward(x);
  for (int r : dropped_) x[structure_.velocity_count + r] = 0;
  for (const Step& s : steps_) {
    if (s.mass >= 0) {
      const Mass& mass = masses_[s.mass];
      const kernels::Three<Scalar> moved = kernels::Three<Scalar>(x + mass.x) * mass.inverse;
      for (int i = mass.first_pin; i < mass.last_pin; ++i) {
        const Pin& pin = pins_[i];
        moved.subtract_from(x + pin.x, pin.sign);
        for (int k = 0; drops && k < 3; ++k)
          if (is_dropped_[pin.row + k]) x[pin.x + k] = 0;
      }
      continue;
    }
    Scalar* y = x + s.x;
    s.apply(b + s.diagonal, y, s.dimension);
    for (int i = s.first_neighbour; i < s.last_neighbour; ++i) {
      const Neighbour& n = neighbours_[i];
      n.forward(x + n.x, b + n.row_block, y, n.dimension, s.dimension);
    }
  }
  for (auto s = steps_.rbegin(); s != steps_.rend(); ++s) {
    if (s->mass >= 0) {
      const Mass& mass = masses_[s->mass];
      kernels::Three<Scalar> load(x + mass.x);
      for (int i = mass.first_pin; i < mass.last_pin; ++i) load.subtract(x + pins_[i].x, pins_[i].sign);
      (load * mass.inverse).store(x + mass.x);
      continue;
    }
    for (int i = s->first_neighbour; i < s->last_neighbour; ++i) {
      const Neighbour& n = neighbours_[i];
      n.backward(x + s->x, b + n.column_block, x + n.x, s->dimension, n.dimension);
    }
  }
  for (const auto& linear : linear_) linear.backward(x);
}

template class BlockFactorOf<double>;
template class BlockFactorOf<std::complex<double>>;

}  // namespace lithe
