#include "engine/factor/block_factor.h"

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "engine/base/thread_team.h"
#include "engine/factor/block_kernels.h"

namespace lithe {
namespace {

// Pivots, of the row's own compliance: squared sines of angles to other rows. Bodies that are nearly points have sound
// ones down to 1e-10.
constexpr double kRoundOff = 1e-12, kGives = 1e-10, kWeak = 1e-5;
constexpr int kLargestGuarded = 16;  // rows of a joint

}  // namespace

template <class Scalar>
BlockFactorOf<Scalar>::BlockFactorOf(const BlockStructure& structure, ThreadTeam* team)
    : structure_(structure), team_(team) {
  for (std::size_t l = 0; l < structure.linears.size(); ++l) linear_.emplace_back(structure, static_cast<int>(l));
  plan();
}

/// A body without a frame that has no more coordinates than one: planar, a point, a number. Its joints close loops too.
template <class Scalar>
bool BlockFactorOf<Scalar>::is_small(std::size_t linear) const {
  return structure_.linears[linear].frames == 0 && structure_.linears[linear].size <= 6;
}

template <class Scalar>
template <class Job>
void BlockFactorOf<Scalar>::for_each_branch(ThreadTeam* team, const Job& job) const {
  const int count = static_cast<int>(branches_.size());
  if (team) return team->run(count, job);
  for (int i = 0; i < count; ++i) job(i);
}

template <class Scalar>
void BlockFactorOf<Scalar>::drop_rows(const std::vector<int>& rows) {
  dropped_ = rows;
  std::fill(is_dropped_.begin(), is_dropped_.end(), 0);
  for (int r : rows) is_dropped_[r] = 1;
  const auto has_dropped = [&](int first, int count) {
    return first >= 0 && std::any_of(&is_dropped_[first], &is_dropped_[first] + count, [](char is) { return is != 0; });
  };
  for (Step& s : steps_) {
    s.touches_dropped = has_dropped(s.first_row, s.dimension);
    for (int i = s.first_neighbour; i < s.last_neighbour; ++i)
      s.touches_dropped |= has_dropped(neighbours_[i].x - structure_.velocity_count, neighbours_[i].dimension);
  }
}

template <class Scalar>
Scalar& BlockFactorOf<Scalar>::entry(int block, int row, int column, int rows) {
  return blocks_[block + kernels::place<Scalar>(row, rows) + kernels::stride<Scalar>(rows) * column];
}

/// What is there before its steps.
template <class Scalar>
void BlockFactorOf<Scalar>::load_first(const Branch& branch, const std::vector<Scalar>& values) {
  Step first{};
  first.first_copy = branch.first_copy, first.last_copy = branch.last_copy;
  first.first_cleared = branch.first_cleared, first.last_cleared = branch.last_cleared;
  load(first, values);
  const std::vector<int>& compliant = branch.compliant;
  for (std::size_t i = 0; i < compliant.size(); i += 3)
    for (int r = 0, n = compliant[i + 2]; r < n; ++r) entry(compliant[i], r, r, n) = values[compliant[i + 1] + r];
  for (int l : branch.linears) {
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

/// C -= ±E / m in rows and columns 0 to 2 of the block of a pair of pins.
template <class Scalar>
void BlockFactorOf<Scalar>::eliminate_pair(const Mass& mass, const Pair& p) {
  Scalar* to = blocks_.data() + p.target;
  const int stride = kernels::stride<Scalar>(p.rows);
  const kernels::Diagonal3<Scalar> part(pins_[p.a].sign == pins_[p.b].sign ? -mass.inverse : mass.inverse);
  if (p.fresh)
    part.put(to, stride, p.columns);
  else
    part.add_to(to, stride);
}

template <class Scalar>
void BlockFactorOf<Scalar>::eliminate_mass(const Step& s, const std::vector<Scalar>& values) {
  Mass& mass = masses_[s.mass];
  mass.inverse = 1.0 / values[mass.value];
  for (int i = mass.first_pair; i < mass.last_pair; ++i) eliminate_pair(mass, pairs_[i]);
  if (!guarded_) return;
  for (int i = mass.first_pin; i < mass.last_within; ++i) add_compliance(mass, pins_[i]);
}

template <class Scalar>
void BlockFactorOf<Scalar>::eliminate(const Step& s) {
  Scalar* b = blocks_.data();
  const Scalar* P = b + s.diagonal;
  for (int i = s.first_neighbour; i < s.last_neighbour; ++i) {
    const Neighbour& n = neighbours_[i];
    n.apply(P, b + n.column_block, s.dimension, n.dimension);
  }
  update(s.first_update, s.last_update);
}

template <class Scalar>
void BlockFactorOf<Scalar>::update(int first, int last) {
  Scalar* b = blocks_.data();
  for (int i = first; i < last; ++i) {
    const Update& u = updates_[i];
    u.product(b + u.target, b + u.row_block, b + u.column_block, u.m, u.d, u.n);
  }
}

/// What the branches owe to the trunk, in a fixed order.
template <class Scalar>
void BlockFactorOf<Scalar>::cross(const std::vector<Scalar>& values) {
  load(crossing_, values);
  for (const Crossing& c : crossing_pairs_) eliminate_pair(masses_[c.of], pairs_[c.what]);
  update(crossing_.first_update, crossing_.last_update);
  if (!guarded_) return;
  for (const Crossing& c : crossing_pins_) add_compliance(masses_[c.of], pins_[c.what]);
  for (const Crossing& c : crossing_neighbours_) add_compliance(steps_[c.of], neighbours_[c.what]);
}

/// Each branch, what they owe to the trunk, and the trunk. `pivot(step, weak_rows)`: inverts the step's diagonal.
template <class Scalar>
template <class Pivot>
void BlockFactorOf<Scalar>::eliminate_all(const std::vector<Scalar>& values, ThreadTeam* team, const Pivot& pivot) {
  const auto eliminate_steps = [&](Branch& branch) {
    branch.weak_rows.clear();
    for (int i = branch.first_step; i < branch.last_step; ++i) {
      const Step& s = steps_[i];
      load(s, values);
      if (s.mass >= 0) {
        eliminate_mass(s, values);
        continue;
      }
      pivot(s, branch.weak_rows);
      eliminate(s);
      if (!guarded_) continue;
      for (int k = s.first_neighbour; k < s.last_within; ++k) add_compliance(s, neighbours_[k]);
    }
  };
  load_first(trunk_, values);
  for_each_branch(team, [&](int i) {
    load_first(branches_[i], values);
    eliminate_steps(branches_[i]);
  });
  cross(values);
  eliminate_steps(trunk_);
}

template <class Scalar>
void BlockFactorOf<Scalar>::factorize(const std::vector<Scalar>& values) {
  if (guarded_) compliance_.setZero();
  eliminate_all(values, team_, [&](const Step& s, std::vector<int>& weak_rows) {
    if (s.touches_dropped) drop(s);
    if (guarded_ && s.first_row >= 0)
      invert_guarded(s, weak_rows);
    else
      s.invert(blocks_.data() + s.diagonal, s.dimension);
  });
  weak_rows_.clear();
  if (!guarded_) return;
  for (const Branch& branch : branches_)
    weak_rows_.insert(weak_rows_.end(), branch.weak_rows.begin(), branch.weak_rows.end());
  weak_rows_.insert(weak_rows_.end(), trunk_.weak_rows.begin(), trunk_.weak_rows.end());
}

/// What a body adds to g S⁻¹ gᵀ of one of its joints' rows: the scale on which their pivots are judged.
template <class Scalar>
void BlockFactorOf<Scalar>::add_compliance(const Step& s, const Neighbour& n) {
  if (s.first_row >= 0 || n.x < structure_.velocity_count) return;
  double* sum = compliance_.data() + n.x - structure_.velocity_count;
  for (int r = 0; r < n.dimension; ++r)
    for (int k = 0; k < s.dimension; ++k)
      sum[r] += std::abs(entry(n.row_block, r, k, n.dimension) * entry(n.column_block, k, r, s.dimension));
}
template <class Scalar>
void BlockFactorOf<Scalar>::add_compliance(const Mass& mass, const Pin& pin) {
  for (int k = 0; k < 3; ++k) compliance_[pin.row + k] += std::abs(mass.inverse);
}

/// A row's pivot is smallest where it goes last in its block: one over the inverse's diagonal. Only where one of those
/// is small is it worth finding the pivots in turn.
template <class Scalar>
void BlockFactorOf<Scalar>::invert_guarded(const Step& s, std::vector<int>& weak_rows) {
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
  guard(s, weak_rows);
  s.invert(P, n);
}

/// Gaussian elimination on a copy of minus the pivot block, a pivot near round-off gives way; small ones are noted
/// where another row may take the place of theirs.
///
/// Where branches of the motion meet, a row's pivot is about δ², δ the angle to that pose, and an error c in g turns
/// the straight way through, x y = 0, into the hyperbola x y = c: exact solutions of that would turn into the other
/// branch at δ = √c. Where the row gives way instead, the motion goes on as its velocity tells.
template <class Scalar>
void BlockFactorOf<Scalar>::guard(const Step& s, std::vector<int>& weak_rows) {
  const int n = s.dimension;
  Scalar A[kLargestGuarded * kLargestGuarded];
  for (int k = 0; k < n; ++k)
    for (int i = 0; i < n; ++i) A[i + n * k] = -entry(s.diagonal, i, k, n);
  for (int p = 0; p < n; ++p) {
    const int row = s.first_row + p;
    const double reference = compliance_[row];
    const double pivot = std::abs(A[p + n * p]);
    if (!is_dropped_[row] && pivot < kWeak * reference) {
      if (!dropped_.empty()) weak_rows.push_back(row);
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
  std::vector<int> dependent;
  eliminate_all(values, nullptr, [&](const Step& s, std::vector<int>&) {
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
  });
  std::vector<int> all = dropped_;
  all.insert(all.end(), dependent.begin(), dependent.end());
  std::sort(all.begin(), all.end());
  drop_rows(all);
  std::sort(dependent.begin(), dependent.end());
  if (!dependent.empty()) factorize(values);  // what came before a dependent row in the order still knew it
  return dependent;
}

template <class Scalar>
void BlockFactorOf<Scalar>::forward(const Branch& branch, Scalar* x) const {
  const Scalar* b = blocks_.data();
  const bool drops = !dropped_.empty();
  for (int i = branch.first_step; i < branch.last_step; ++i) {
    const Step& s = steps_[i];
    if (s.mass >= 0) {
      const Mass& mass = masses_[s.mass];
      const kernels::Three<Scalar> moved = kernels::Three<Scalar>(x + mass.x) * mass.inverse;
      for (int p = mass.first_pin; p < mass.last_within; ++p) moved.subtract_from(x + pins_[p].x, pins_[p].sign);
      continue;
    }
    Scalar* y = x + s.x;
    if (drops && s.first_row >= 0)
      for (int r = 0; r < s.dimension; ++r)
        if (is_dropped_[s.first_row + r]) y[r] = 0;
    s.apply(b + s.diagonal, y, s.dimension);
    for (int k = s.first_neighbour; k < s.last_within; ++k) {
      const Neighbour& n = neighbours_[k];
      n.forward(x + n.x, b + n.row_block, y, n.dimension, s.dimension);
    }
  }
}

template <class Scalar>
void BlockFactorOf<Scalar>::cross_forward(Scalar* x) const {
  for (const Crossing& c : crossing_pins_) {
    const Mass& mass = masses_[c.of];
    const Pin& pin = pins_[c.what];
    (kernels::Three<Scalar>(x + mass.x) * mass.inverse).subtract_from(x + pin.x, pin.sign);
  }
  for (const Crossing& c : crossing_neighbours_) {
    const Neighbour& n = neighbours_[c.what];
    n.forward(x + n.x, blocks_.data() + n.row_block, x + steps_[c.of].x, n.dimension, steps_[c.of].dimension);
  }
}

template <class Scalar>
void BlockFactorOf<Scalar>::backward(const Branch& branch, Scalar* x) const {
  for (int i = branch.last_step; i-- > branch.first_step;) {
    const Step& s = steps_[i];
    if (s.mass >= 0) {
      const Mass& mass = masses_[s.mass];
      kernels::Three<Scalar> load(x + mass.x);
      for (int p = mass.first_pin; p < mass.last_pin; ++p) load.subtract(x + pins_[p].x, pins_[p].sign);
      (load * mass.inverse).store(x + mass.x);
      continue;
    }
    for (int k = s.first_neighbour; k < s.last_neighbour; ++k) {
      const Neighbour& n = neighbours_[k];
      n.backward(x + s.x, blocks_.data() + n.column_block, x + n.x, s.dimension, n.dimension);
    }
  }
}

template <class Scalar>
void BlockFactorOf<Scalar>::solve(Scalar* x) const {
  for (int l : trunk_.linears) linear_[l].forward(x);
  for_each_branch(team_, [&](int i) {
    for (int l : branches_[i].linears) linear_[l].forward(x);
    forward(branches_[i], x);
  });
  cross_forward(x);
  forward(trunk_, x);
  backward(trunk_, x);
  for_each_branch(team_, [&](int i) {
    backward(branches_[i], x);
    for (int l : branches_[i].linears) linear_[l].backward(x);
  });
  for (int l : trunk_.linears) linear_[l].backward(x);
}

template class BlockFactorOf<double>;
template class BlockFactorOf<std::complex<double>>;

}  // namespace lithe
