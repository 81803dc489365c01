#include <algorithm>

#include "engine/factor/block_factor.h"
#include "engine/factor/block_kernels.h"
#include "engine/factor/branches.h"

/// Which blocks a factor has, and the steps that eliminate them.
namespace lithe {

/// Multiplications of each vertex, roughly; of linear coordinates with their frame or first rows.
template <class Scalar>
std::vector<double> BlockFactorOf<Scalar>::work(const Elimination& elimination,
                                                const std::vector<int>& dimension) const {
  const int frames = static_cast<int>(structure_.frames.size()), others = static_cast<int>(dimension.size());
  std::vector<double> work;
  for (std::size_t v = 0; v < elimination.neighbours.size(); ++v) {
    double around = 0;
    for (int w : elimination.neighbours[v]) around += dimension[w];
    const double d = static_cast<int>(v) < others ? dimension[v] : 1;
    work.push_back(d * (around * around + d * d));
  }
  for (std::size_t l = 0; l < linear_.size(); ++l) {
    const auto& linear = structure_.linears[l];
    if (linear.frame < 0 && linear_[l].rows().empty()) continue;
    const double m = linear_[l].neighbour_size();
    work[linear.frame >= 0 ? linear.frame : frames + linear_[l].rows().front()] += linear.size * (m * m + 10);
  }
  return work;
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
    masses_.push_back({s.frames[f].values, s.frames[f].v, 0, 0, 0, 0, 0});
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
  Elimination elimination = plan_elimination(topology, dimension, couplings, held, centres(topology, dimension));
  const std::vector<int> ends = gather_branches(elimination, work(elimination, dimension));
  const int trunk = static_cast<int>(ends.size());
  branches_.resize(ends.size());
  const auto branch = [&](int b) -> Branch& { return b < trunk ? branches_[b] : trunk_; };
  std::vector<int> branch_of(elimination.order.size(), trunk);
  for (int b = 0, i = 0; b < trunk; ++b)
    for (; i < ends[b]; ++i) branch_of[elimination.order[i]] = b;

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
  // Before the steps of each branch, and of the trunk before all: what the bodies' linear coordinates add to, and
  // compliances.
  std::vector<std::vector<int>> vertices_of(linear_.size());
  schur_targets_.resize(linear_.size());
  for (std::size_t l = 0; l < linear_.size(); ++l) {
    auto& vertices = vertices_of[l];
    for (int f = 0; f < s.linears[l].frames; ++f) vertices.push_back(s.linears[l].frame + f);
    for (int r : linear_[l].rows()) vertices.push_back(frames + r);
    const bool one = std::all_of(vertices.begin(), vertices.end(),
                                 [&](int v) { return branch_of[v] == branch_of[vertices.front()]; });
    branch(one && !vertices.empty() ? branch_of[vertices.front()] : trunk).linears.push_back(static_cast<int>(l));
  }
  for (int b = trunk, k = 0; k <= trunk; b = k++) {  // the trunk, then the branches
    Branch& of = branch(b);
    of.first_copy = static_cast<int>(copies_.size()), of.first_cleared = static_cast<int>(cleared_.size());
    for (int l : of.linears)
      for (int j : vertices_of[l])
        for (int i : vertices_of[l]) touch(i, j, false), schur_targets_[l].push_back(block(i, j));
    int count = 0;
    for (int r = 0; r < rows; ++r) {
      if (branch_of[frames + r] != b) continue;
      count += s.rows[r].count;
      if (s.rows[r].compliant < 0) continue;
      touch(frames + r, frames + r, false);
      of.compliant.insert(of.compliant.end(), {block(frames + r, frames + r), s.rows[r].compliant, s.rows[r].count});
    }
    if (guarded_) of.weak_rows.reserve(count);
    of.last_copy = static_cast<int>(copies_.size()), of.last_cleared = static_cast<int>(cleared_.size());
  }

  // 3. The steps. What a branch's would do to blocks of the trunk is put off until all branches are done.
  struct PutOff {
    int d, v, i, k;
  };
  std::vector<PutOff> put_off;
  struct PutOffPair {
    int mass, i, k, a, b;  // vertices, pins
  };
  std::vector<PutOffPair> put_off_pairs;
  const auto cross = [&] {
    crossing_.first_copy = static_cast<int>(copies_.size()),
    crossing_.first_cleared = static_cast<int>(cleared_.size());
    crossing_.first_update = static_cast<int>(updates_.size());
    for (const PutOffPair& p : put_off_pairs) {
      const bool fresh = touch(p.i, p.k, true);
      crossing_pairs_.push_back({p.mass, static_cast<int>(pairs_.size())});
      pairs_.push_back({block(p.i, p.k), p.a, p.b, dimension[p.i], dimension[p.k], fresh});
    }
    for (const PutOff& u : put_off) {
      const bool fresh = touch(u.i, u.k, true);
      updates_.push_back({kernels::choose_product<Scalar>(dimension[u.i], u.d, dimension[u.k], fresh), block(u.i, u.k),
                          block(u.i, u.v), block(u.v, u.k), dimension[u.i], u.d, dimension[u.k]});
    }
    crossing_.last_copy = static_cast<int>(copies_.size()), crossing_.last_cleared = static_cast<int>(cleared_.size());
    crossing_.last_update = static_cast<int>(updates_.size());
  };
  int now = 0;                               // the branch whose steps these are
  const auto close_branches = [&](int at) {  // that end there
    while (now < trunk && at == ends[now]) {
      branch(now).last_step = at;
      branch(++now).first_step = at;
      if (now == trunk) cross();
    }
  };
  for (std::size_t at = 0; at < elimination.order.size(); ++at) {
    close_branches(static_cast<int>(at));
    const int v = elimination.order[at];
    const auto within = [&](int w) { return branch_of[w] == now; };
    Step step{};
    step.first_neighbour = static_cast<int>(neighbours_.size()), step.first_update = static_cast<int>(updates_.size());
    step.first_copy = static_cast<int>(copies_.size()), step.first_cleared = static_cast<int>(cleared_.size());
    step.mass = v < others ? -1 : v - others;
    step.first_row = v >= frames && v < others ? s.rows[v - frames].first : -1;
    if (step.mass >= 0) {
      Mass& mass = masses_[step.mass];
      std::vector<std::pair<int, int>> pinned;  // and its sign
      for (std::size_t i = 0; i < held[step.mass].size(); ++i)
        pinned.emplace_back(held[step.mass][i], signs[step.mass][i]);
      const auto outside =
          std::stable_partition(pinned.begin(), pinned.end(), [&](const auto& pin) { return within(pin.first); });
      mass.first_pin = static_cast<int>(pins_.size()), mass.first_pair = static_cast<int>(pairs_.size());
      mass.last_within = mass.first_pin + static_cast<int>(outside - pinned.begin());
      for (const auto& [row, sign] : pinned) {
        if (!within(row)) crossing_pins_.push_back({step.mass, static_cast<int>(pins_.size())});
        pins_.push_back({x[row], s.rows[row - frames].first, sign});
      }
      for (std::size_t j = 0; j < pinned.size(); ++j)
        for (std::size_t i = 0; i < pinned.size(); ++i) {
          const int a = pinned[i].first, b = pinned[j].first, pin_a = mass.first_pin + static_cast<int>(i),
                    pin_b = mass.first_pin + static_cast<int>(j);
          if (!within(a) && !within(b)) {
            put_off_pairs.push_back({step.mass, a, b, pin_a, pin_b});
            continue;
          }
          const bool fresh = touch(a, b, true);
          pairs_.push_back({block(a, b), pin_a, pin_b, dimension[a], dimension[b], fresh});
        }
      mass.last_pin = static_cast<int>(pins_.size()), mass.last_pair = static_cast<int>(pairs_.size());
    } else {
      const int d = dimension[v];
      std::vector<int> rest = elimination.neighbours[v];
      const auto outside = std::stable_partition(rest.begin(), rest.end(), within);
      step.dimension = d, step.x = x[v];
      step.invert = kernels::choose_invert<Scalar>(d), step.apply = kernels::choose_apply_vector<Scalar>(d);
      touch(v, v, false);
      step.diagonal = block(v, v);
      step.last_within = step.first_neighbour + static_cast<int>(outside - rest.begin());
      for (int i : rest) {
        touch(i, v, false), touch(v, i, false);
        if (!within(i)) crossing_neighbours_.push_back({static_cast<int>(at), static_cast<int>(neighbours_.size())});
        neighbours_.push_back({block(i, v), block(v, i), x[i], dimension[i],
                               kernels::choose_apply<Scalar>(d, dimension[i]),
                               kernels::choose_multiply_vector<Scalar>(dimension[i], d),
                               kernels::choose_multiply_vector<Scalar>(d, dimension[i])});
      }
      for (int k : rest)
        for (int i : rest) {
          if (!within(i) && !within(k)) {
            put_off.push_back({d, v, i, k});
            continue;
          }
          const bool fresh = touch(i, k, true);
          updates_.push_back({kernels::choose_product<Scalar>(dimension[i], d, dimension[k], fresh), block(i, k),
                              block(i, v), block(v, k), dimension[i], d, dimension[k]});
        }
    }
    step.last_neighbour = static_cast<int>(neighbours_.size());
    step.last_update = static_cast<int>(updates_.size());
    step.last_copy = static_cast<int>(copies_.size()), step.last_cleared = static_cast<int>(cleared_.size());
    steps_.push_back(step);
  }
  close_branches(static_cast<int>(steps_.size()));  // there may be no trunk
  trunk_.last_step = static_cast<int>(steps_.size());
  blocks_.assign(size, Scalar(0));
  is_dropped_.assign(s.row_count, 0);
  compliance_.setZero(s.row_count);
  weak_rows_.reserve(s.row_count);
}

template void BlockFactorOf<double>::plan();
template std::vector<double> BlockFactorOf<double>::work(const Elimination&, const std::vector<int>&) const;
template void BlockFactorOf<std::complex<double>>::plan();
template std::vector<double> BlockFactorOf<std::complex<double>>::work(const Elimination&,
                                                                       const std::vector<int>&) const;

}  // namespace lithe
