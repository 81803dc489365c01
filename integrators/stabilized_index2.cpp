#include "integrators/stabilized_index2.h"

#include <algorithm>

namespace lithe {
namespace {

/// Multipliers are sums of accelerations, one order of h less exact than velocities: how much more they may err.
constexpr double kMultiplierSlack = 1e10;

Vector4 conjugate(const Vector4& e) { return {e[0], -e[1], -e[2], -e[3]}; }

}  // namespace

StabilizedIndex2::StabilizedIndex2(EquationsOfMotion& equations)
    : equations_(equations),
      nq_(equations.layout().q_count()),
      nv_(equations.layout().v_count()),
      rows_(equations.layout().row_count()),
      redundant_(rows_, 0),
      rolling_(rows_, 0) {
  for (const auto& b : equations.layout().bodies()) {
    int q = b.q;
    if (b.frame) {
      for (int axis = 0; axis < 3; ++axis) coordinates_.push_back({q++, -1, 0});
      for (int axis = 0; axis < 3; ++axis) coordinates_.push_back({q, static_cast<int>(rotations_.size()), axis});
      rotations_.push_back({q, b.v + 3, {}, {}});
      q += 4;
    }
    for (int i = 0; i < b.linear; ++i) coordinates_.push_back({q++, -1, 0});
  }
  for (int row : equations.redundant_rows()) redundant_[row] = 1;
  for (int row : equations.velocity_rows()) rolling_[row] = 1;
  for (VectorX* x : {&q_, &moved_q_}) x->setZero(nq_);
  for (VectorX* x : {&v_, &u_, &v_dot_, &zero_v_, &force_, &increment_}) x->setZero(nv_);
  for (VectorX* x : {&lambda_, &mu_, &zero_rows_, &rate_, &moved_rate_}) x->setZero(rows_);
}

std::string StabilizedIndex2::name(int index) const {
  const Layout& layout = equations_.layout();
  if (index >= nq_ + nv_) return "the multiplier of " + layout.row_name((index - nq_ - nv_) % std::max(rows_, 1));
  if (index >= nq_) return layout.velocity_name(index - nq_);
  int at = 0;
  while (at + 1 < nv_ && coordinates_[at + 1].q <= index) ++at;
  const Coordinate& c = coordinates_[at];
  if (c.rotation >= 0) at = rotations_[c.rotation].v + std::clamp(index - c.q - 1, 0, 2);
  return layout.velocity_name(at);
}

void StabilizedIndex2::pack(const State& state, VectorRef y, VectorRef y_dot) const {
  y << state.q, state.v, state.lambda, zero_rows_;
  y_dot.setZero();
  for (int i = 0; i < nv_; ++i)
    if (coordinates_[i].rotation < 0) y_dot[coordinates_[i].q] = state.v[i];
  for (const Rotation& r : rotations_) {  // ė = ½ e ∘ (0, ω)
    Vector4 omega;
    omega << 0, state.v.segment<3>(r.v);
    y_dot.segment<4>(r.q) = 0.5 * quaternion_product(state.q.segment<4>(r.q), omega);
  }
  y_dot.segment(nq_, nv_) = state.v_dot;
}

void StabilizedIndex2::unpack(ConstVectorRef y, ConstVectorRef y_dot, State& state) const {
  state.q = y.head(nq_);
  for (const Rotation& r : rotations_) state.q.segment<4>(r.q).normalize();
  state.v = y.segment(nq_, nv_);
  state.v_dot = y_dot.segment(nq_, nv_);
  state.lambda = y.segment(nq_ + nv_, rows_);
}

void StabilizedIndex2::allowances(ConstVectorRef y, const Tolerance& tolerance, VectorRef out) const {
  const double a = tolerance.absolute, r = tolerance.relative;
  out.head(nq_ + nv_) = a + r * y.head(nq_ + nv_).array().abs();
  for (const Rotation& rotation : rotations_) out.segment<4>(rotation.q).setConstant((a + r) / 2);  // e turns by half
  out.segment(nq_ + nv_, rows_) = kMultiplierSlack * (a + r * y.segment(nq_ + nv_, rows_).array().abs());
  out.tail(rows_).setConstant(kMultiplierSlack * (a + r));
  // The mean runs over q and v, not over the multipliers that are not tested.
  out = (out * std::sqrt(static_cast<double>(differential_count()) / size())).cwiseMax(1e-100);
}

/// The state that the engine is to see, the velocities u, and how both turn with e.
void StabilizedIndex2::load(double time, ConstVectorRef y, ConstVectorRef y_dot) {
  q_ = y.head(nq_);
  v_ = y.segment(nq_, nv_);
  v_dot_ = y_dot.segment(nq_, nv_);
  lambda_ = y.segment(nq_ + nv_, rows_);
  mu_ = y.tail(rows_);
  for (int i = 0; i < nv_; ++i)
    if (coordinates_[i].rotation < 0) u_[i] = y_dot[coordinates_[i].q];
  for (const Rotation& r : rotations_) {
    const Vector4 e = y.segment<4>(r.q), e_dot = y_dot.segment<4>(r.q);
    q_.segment<4>(r.q) = e / e.norm();
    u_.segment<3>(r.v) = 2 / e.squaredNorm() * quaternion_product(conjugate(e), e_dot).tail<3>();
  }
  equations_.evaluate(time, q_, v_, Level::velocity);
}

void StabilizedIndex2::residual(double time, ConstVectorRef y, ConstVectorRef y_dot, VectorRef F) {
  load(time, y, y_dot);
  // M x + Gᵀ μ is what x and μ add to the residual at rest.
  equations_.residual(zero_v_, zero_rows_, force_);
  u_ -= v_;
  equations_.residual(u_, mu_, F.head(nv_));
  F.head(nv_) -= force_;
  for (std::size_t i = 0; i < rotations_.size(); ++i)
    F[nv_ + static_cast<int>(i)] = y.segment<4>(rotations_[i].q).squaredNorm() - 1;
  equations_.residual(v_dot_, lambda_, F.segment(nq_, nv_));
  equations_.constraint(Level::position, F.segment(nq_ + nv_, rows_));
  equations_.constraint(Level::velocity, F.tail(rows_));
  for (int row = 0; row < rows_; ++row) {
    if (redundant_[row] || rolling_[row]) F[nq_ + nv_ + row] = mu_[row];
    if (redundant_[row]) F[nq_ + nv_ + rows_ + row] = lambda_[row];
  }
}

void StabilizedIndex2::collect(const TangentWeights& weights, std::vector<Entry>& entries) {
  entries.clear();
  equations_.factorize(weights, v_dot_, lambda_, nullptr);
  equations_.visit_blocks([&](int row, int column, ConstMatrixRef block) {
    for (int k = 0; k < block.cols(); ++k)
      for (int i = 0; i < block.rows(); ++i) entries.push_back({row + i, column + k, block(i, k)});
  });
}

void StabilizedIndex2::emit(int row, int column, double value) {
  if (values_)
    values_[places_[emitted_++]] += value;
  else
    pattern_.emplace_back(column, row);
}

/// `value` acts on the increment of a velocity's coordinate; of a rotation, on the turn ψ.
void StabilizedIndex2::emit_turn(int row, const Coordinate& at, double value) {
  if (at.rotation < 0) return emit(row, at.q, value);
  for (int k = 0; k < 4; ++k) emit(row, at.q + k, value * rotations_[at.rotation].turn(at.axis, k));
}

/// Colours the frames so that those of one colour share no constraint; a colour and one of six motions make a group.
void StabilizedIndex2::group_columns() {
  std::vector<int> frame(nv_, -1), colour;  // frame of each velocity, colour of each frame
  for (const auto& b : equations_.layout().bodies()) {
    if (!b.frame) continue;
    for (int axis = 0; axis < 6; ++axis) frame[b.v + axis] = static_cast<int>(colour.size());
    colour.push_back(-1);
  }
  std::vector<std::vector<int>> tied(rows_);  // frames of each row
  for (const Entry& e : mass_)
    if (e.row >= nv_ && e.row < nv_ + rows_ && e.column < nv_ && frame[e.column] >= 0)
      tied[e.row - nv_].push_back(frame[e.column]);
  std::vector<std::vector<int>> rows_of(colour.size());
  for (int row = 0; row < rows_; ++row)
    for (int f : tied[row]) rows_of[f].push_back(row);
  int colours = 0;
  for (std::size_t f = 0; f < colour.size(); ++f) {
    std::vector<char> taken(colours + 1, 0);
    for (int row : rows_of[f])
      for (int other : tied[row])
        if (colour[other] >= 0) taken[colour[other]] = 1;
    colour[f] = static_cast<int>(std::find(taken.begin(), taken.end(), 0) - taken.begin());
    colours = std::max(colours, colour[f] + 1);
  }
  shifts_.resize(6 * colours);
  moved_.resize(6 * colours);
  rates_.assign(mass_.size(), 0);
  const auto group = [&](int velocity) {
    int axis = 0;
    while (axis < 5 && velocity - axis > 0 && frame[velocity - axis - 1] == frame[velocity]) ++axis;
    return 6 * colour[frame[velocity]] + axis;
  };
  for (int i = 0; i < nv_; ++i)
    if (frame[i] >= 0) moved_[group(i)].push_back(i);
  for (std::size_t k = 0; k < mass_.size(); ++k) {
    const Entry& e = mass_[k];
    if (e.row >= nv_ && e.row < nv_ + rows_ && e.column < nv_ && frame[e.column] >= 0)
      shifts_[group(e.column)].push_back({static_cast<int>(k), e.row - nv_});
  }
}

void StabilizedIndex2::difference_rates(double time) {
  constexpr double step = 1e-7;  // m, rad
  equations_.constraint(Level::velocity, rate_);
  for (std::size_t g = 0; g < shifts_.size(); ++g) {
    if (shifts_[g].empty()) continue;
    increment_.setZero();
    for (int velocity : moved_[g]) increment_[velocity] = step;
    equations_.layout().retract(q_, increment_, moved_q_);
    equations_.evaluate(time, moved_q_, v_, Level::velocity);
    equations_.constraint(Level::velocity, moved_rate_);
    for (const Shift& s : shifts_[g]) rates_[s.entry] = (moved_rate_[s.row] - rate_[s.row]) / step;
  }
}

void StabilizedIndex2::form(double time, double c, ConstVectorRef y) {
  const int dynamics = nq_, position = nq_ + nv_, velocity = position + rows_;  // first rows, and columns of λ and μ
  // 1. The engine's blocks. A share of M keeps each of them regular; it is taken out again.
  collect({1, 0, 1}, stiffness_);
  collect({0, 1, c}, damping_);
  collect({0, 0, 1}, mass_);
  if (rates_.empty()) group_columns();
  difference_rates(time);
  int compliant_rows = 0;
  for (const Entry& e : mass_) compliant_rows = std::max(compliant_rows, e.row - nv_ - rows_ + 1);
  compliant_.resize(compliant_rows);
  for (auto& row : compliant_) row.clear();
  reactive_.clear();

  for (std::size_t k = 0; k < mass_.size(); ++k) {
    const auto [row, column, value] = mass_[k];
    if (column >= nv_ && row != column) {  // Gᵀ: written with G
      if (row >= nv_ + rows_) reactive_.push_back({row - nv_ - rows_, column - nv_, value});
      continue;
    }
    if (row < nv_) {
      // 2. M (u - v) and M v̇ - f. The derivatives of M and Gᵀ beside u - v = 0 and μ = 0 are left out.
      const Coordinate& at = coordinates_[column];
      if (at.rotation < 0) {
        emit(row, at.q, c * value);
      } else {
        const Rotation& r = rotations_[at.rotation];
        for (int i = 0; i < 4; ++i) emit(row, at.q + i, value * (c * r.turn(at.axis, i) + r.rate(at.axis, i)));
      }
      emit(row, nq_ + column, -value);
      emit_turn(dynamics + row, at, stiffness_[k].value - value);
      emit(dynamics + row, nq_ + column, damping_[k].value);
    } else if (row < nv_ + rows_) {
      // 3. G, four times, and what G v changes with q: h ω beside c G, without it Newton fails on fast tops.
      const int i = row - nv_;
      if (!redundant_[i]) {
        if (!rolling_[i]) emit_turn(position + i, coordinates_[column], value);
        emit(velocity + i, nq_ + column, value);
        emit_turn(velocity + i, coordinates_[column], rates_[k]);
      }
      emit(column, velocity + i, value);
      emit(dynamics + column, position + i, value);
    } else if (column < nv_) {
      compliant_[row - nv_ - rows_].push_back(mass_[k]);
    } else {
      // 4. A compliant row: its block is eliminated, Gᵀ k G.
      const auto& G = compliant_[row - nv_ - rows_];
      for (const Entry& a : G)
        for (const Entry& r : reactive_)  // visited before the diagonal
          if (r.row == row - nv_ - rows_) emit(dynamics + a.column, position + r.column, -a.value * r.value / value);
      for (const Entry& a : G)
        for (const Entry& b : G) {
          emit_turn(dynamics + a.column, coordinates_[b.column], -a.value * b.value / stiffness_[k].value);
          emit(dynamics + a.column, nq_ + b.column, -a.value * b.value / damping_[k].value);
        }
    }
  }
  // 5. Norms of quaternions; redundant rows.
  for (std::size_t i = 0; i < rotations_.size(); ++i)
    for (int k = 0; k < 4; ++k) emit(nv_ + static_cast<int>(i), rotations_[i].q + k, 2 * y[rotations_[i].q + k]);
  for (int row = 0; row < rows_; ++row) {
    if (redundant_[row] || rolling_[row]) emit(position + row, velocity + row, 1);
    if (redundant_[row]) emit(velocity + row, position + row, 1);
  }
}

void StabilizedIndex2::jacobian(double time, ConstVectorRef y, ConstVectorRef y_dot, double c, double* values) {
  load(time, y, y_dot);
  for (Rotation& r : rotations_) {
    const Vector4 e = y.segment<4>(r.q), e_dot = y_dot.segment<4>(r.q);
    const double n = e.squaredNorm();
    r.turn << -e.tail<3>(), e[0] * Matrix3::Identity() - skew(e.tail<3>());
    r.turn *= 2 / n;
    r.rate << e_dot.tail<3>(), skew(e_dot.tail<3>()) - e_dot[0] * Matrix3::Identity();
    r.rate *= 2 / n;
    r.rate -= (2 / n) * u_.segment<3>(r.v) * e.transpose();
  }
  if (places_.empty()) {  // the first time: record what is emitted where
    values_ = nullptr;
    form(time, c, y);
    std::vector<std::pair<int, int>> sorted = pattern_;
    std::sort(sorted.begin(), sorted.end());
    sorted.erase(std::unique(sorted.begin(), sorted.end()), sorted.end());
    for (const auto& entry : pattern_)
      places_.push_back(static_cast<int>(std::lower_bound(sorted.begin(), sorted.end(), entry) - sorted.begin()));
    column_starts_.assign(size() + 1, 0);
    for (const auto& [column, row] : sorted) {
      ++column_starts_[column + 1];
      row_indices_.push_back(row);
    }
    for (int k = 0; k < size(); ++k) column_starts_[k + 1] += column_starts_[k];
    pattern_ = {};
  }
  if (!values) return;
  std::fill_n(values, row_indices_.size(), 0.0);
  values_ = values;
  emitted_ = 0;
  form(time, c, y);
}

}  // namespace lithe
