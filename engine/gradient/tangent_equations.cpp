#include "engine/gradient/tangent_equations.h"

#include <algorithm>
#include <random>
#include <set>

#include "engine/assembly/tangent_factors.h"
#include "engine/base/error.h"
#include "engine/factor/block_products.h"
#include "engine/gradient/differences.h"

namespace lithe {

namespace {

constexpr int kFirstLooks = 8, kLooks = 8;  // at the elements' tangents: of the first states, then at every eighth
constexpr double kAgree = 2e-9;             // of a body's rows, between the elements' tangents and differences
constexpr double kAgreeAll = 1e-12;         // of all rows: round-off of the differences

int velocities_of(const Layout::BodySlice& b) { return (b.frame ? 6 : 0) + b.linear; }

}  // namespace

TangentEquations::TangentEquations(const System& system, ParameterDerivative* parameters)
    : equations_(system), parameters_(parameters) {}

TangentEquations::~TangentEquations() = default;

void TangentEquations::at(const State& state) {
  state_ = state;
  near_ = state;
  equations_.recall(state.quarter_turns);
  equations_.recall_rows(state.left_out);
  ready_ = evaluated_ = false;
}

void TangentEquations::evaluate(double offset, const Direction& direction, VectorX& force, VectorX& rows) {
  evaluated_ = false;
  const auto step = [&](const VectorX& base, const VectorX& by, VectorX& out) {
    out = base;
    if (by.size() > 0) out += offset * by;
  };
  if (direction.turn.size() > 0)
    layout().retract(state_.q, offset * direction.turn, near_.q);
  else
    near_.q = state_.q;
  step(state_.v, direction.velocity, near_.v);
  step(state_.v_dot, direction.acceleration, near_.v_dot);
  step(state_.lambda, direction.multipliers, near_.lambda);
  equations_.evaluate(state_.time, near_.q, near_.v, Level::velocity);
  force.resize(state_.v.size());
  rows.resize(state_.lambda.size());
  equations_.residual(near_.v_dot, near_.lambda, force);
  equations_.constraint(Level::position, rows);
  if (equations_.velocity_rows().empty()) return;
  VectorX rates(rows.size());
  equations_.constraint(Level::velocity, rates);
  for (int row : equations_.velocity_rows()) rows[row] = rates[row];
}

void TangentEquations::along(const Direction& direction, VectorX& force, VectorX& rows) {
  // Linear in accelerations; multipliers and velocities count as far as they turn or move something.
  const double size =
      std::max(largest_entry(direction.turn), largest_entry(direction.velocity) / (1 + largest_entry(state_.v)));
  const double h = size > 0 ? kDirectionStep / size : 1;
  VectorX f, g;
  force.setZero(state_.v.size());
  rows.setZero(state_.lambda.size());
  for (const Offset& offset : kOffsets) {
    evaluate(offset.steps * h, direction, f, g);
    force += offset.weight / h * f;
    rows += offset.weight / h * g;
  }
}

void TangentEquations::parameter_columns(MatrixX& force, MatrixX& rows) { parameters_->columns(state_, force, rows); }

void TangentEquations::add_parameter_products(const VectorX& mu, const VectorX& nu, VectorX& out) {
  parameters_->add_products(state_, mu, nu, out);
}

void TangentEquations::factorize(const TangentWeights& weights, const VectorX& increment, bool transposed) {
  equations_.evaluate(state_.time, state_.q, state_.v, Level::velocity);
  evaluated_ = true;
  VectorX r(state_.v.size());
  equations_.residual(state_.v_dot, state_.lambda, r);  // friction learns the reactions
  if (transposed)
    equations_.factors().factorize_transposed(weights, state_.v_dot, state_.lambda, &increment);
  else
    equations_.factorize(weights, state_.v_dot, state_.lambda, &increment);
}

void TangentEquations::solve(VectorX& force, VectorX& rows) { equations_.solve(force, rows); }

void TangentEquations::pull(const VectorX& mu, const VectorX& nu, Pulled& out) {
  if (!ready_) check_tangents();
  if (!evaluated_) equations_.evaluate(state_.time, state_.q, state_.v, Level::velocity);
  evaluated_ = true;
  // r is linear in v̇ and λ; M is symmetric. Large ones, so that little of them drowns in the forces at play.
  constexpr double kLarge = 1e8;
  const VectorX no_force = VectorX::Zero(mu.size()), no_load = VectorX::Zero(nu.size());
  const auto scale = [&](const VectorX& x) {
    const double size = largest_entry(x);
    return size > 0 ? kLarge / size : 1;
  };
  force_before_.resize(mu.size());
  force_.resize(mu.size());
  equations_.residual(no_force, no_load, force_before_);
  const double of_mu = scale(mu), of_nu = scale(nu);
  equations_.residual(of_mu * mu, no_load, force_);
  out.acceleration = (force_ - force_before_) / of_mu;
  equations_.residual(no_force, of_nu * nu, force_);
  out.turn = (force_ - force_before_) / of_nu;
  out.velocity.setZero(mu.size());
  out.rows.setZero(nu.size());
  add_rates(equations_.system().blocks(), equations_.workspace().values, mu.data(), out.rows);
  if (tangents_ == Tangents::of_elements) {
    equations_.factors().form_tangent({1, 0, 0}, state_.v_dot, state_.lambda, nullptr);
    equations_.factors().add_tangent_product(mu, out.turn, true);
    equations_.factors().form_tangent({0, 1, 0}, state_.v_dot, state_.lambda, nullptr);
    equations_.factors().add_tangent_product(mu, out.velocity, true);
  } else {
    out.turn += K_.transpose() * mu;
    out.velocity += D_.transpose() * mu;
  }
}

/// The elements' tangents against differences along a random direction, body by body.
void TangentEquations::check_tangents() {
  ready_ = true;
  if (tangents_ == Tangents::differenced) return difference_columns();
  // What an element leaves out it leaves out at every state, but where it vanishes: looked at first, and every so
  // often.
  if (looks_++ >= kFirstLooks && looks_ % kLooks != 0) return;
  std::mt19937 random(seed_++);
  const auto entry = [&] { return static_cast<double>(random()) / 2147483648.0 - 1; };
  Direction direction;
  direction.turn.resize(state_.v.size());
  for (double& x : direction.turn) x = entry();
  direction.velocity.resize(state_.v.size());
  for (double& x : direction.velocity) x = (1 + largest_entry(state_.v)) * entry();
  VectorX force, rows;
  along(direction, force, rows);
  equations_.evaluate(state_.time, state_.q, state_.v, Level::velocity);
  VectorX r(state_.v.size()), own = VectorX::Zero(state_.v.size());
  equations_.residual(state_.v_dot, state_.lambda, r);
  equations_.factors().form_tangent({1, 0, 0}, state_.v_dot, state_.lambda, nullptr);
  equations_.factors().add_tangent_product(direction.turn, own, false);
  equations_.factors().form_tangent({0, 1, 0}, state_.v_dot, state_.lambda, nullptr);
  equations_.factors().add_tangent_product(direction.velocity, own, false);
  const double all = largest_entry(force) + largest_entry(r);
  for (const auto& b : layout().bodies()) {
    const auto theirs = force.segment(b.v, velocities_of(b)), ours = own.segment(b.v, velocities_of(b));
    if ((theirs - ours).lpNorm<Eigen::Infinity>() <= kAgree * theirs.lpNorm<Eigen::Infinity>() + 1e2 * kAgreeAll * all)
      continue;
    tangents_ = Tangents::differenced;
    return difference_columns();
  }
}

/// Slices that no row knows both: their columns are differenced together.
void TangentEquations::find_colours() {
  const auto& bodies = layout().bodies();
  const int count = static_cast<int>(bodies.size()), velocities = layout().v_count();
  std::vector<int> slice_of(static_cast<std::size_t>(velocities));
  for (int s = 0; s < count; ++s)
    for (int i = 0; i < velocities_of(bodies[s]); ++i) slice_of[static_cast<std::size_t>(bodies[s].v + i)] = s;
  std::vector<std::set<int>> near(static_cast<std::size_t>(count));
  std::vector<std::set<int>> of_row;
  equations_.visit_blocks([&](int row, int column, ConstMatrixRef) {
    if (row < velocities && column < velocities) {
      near[slice_of[row]].insert(slice_of[column]);
      near[slice_of[column]].insert(slice_of[row]);
    } else if (row >= velocities && column < velocities) {
      if (row - velocities >= static_cast<int>(of_row.size())) of_row.resize(row - velocities + 1);
      of_row[row - velocities].insert(slice_of[column]);
    }
  });
  for (const auto& slices : of_row)
    for (int a : slices) near[a].insert(slices.begin(), slices.end());
  influence_.clear();
  for (int s = 0; s < count; ++s) {
    near[s].insert(s);
    influence_.emplace_back(near[s].begin(), near[s].end());
  }
  std::vector<std::vector<char>> taken;
  for (int s = 0; s < count; ++s) {
    std::size_t colour = 0;
    for (; colour < taken.size(); ++colour)
      if (std::none_of(influence_[s].begin(), influence_[s].end(), [&](int other) { return taken[colour][other]; }))
        break;
    if (colour == taken.size()) taken.emplace_back(count, 0), colours_.emplace_back();
    colours_[colour].push_back(s);
    for (int other : influence_[s]) taken[colour][other] = 1;
  }
}

void TangentEquations::difference_columns() {
  if (colours_.empty()) find_colours();
  const auto& bodies = layout().bodies();
  std::vector<Eigen::Triplet<double>> by_q, by_v;
  Direction direction;
  VectorX force, rows;
  for (const auto& colour : colours_) {
    int widest = 0;
    for (int s : colour) widest = std::max(widest, velocities_of(bodies[s]));
    for (int i = 0; i < widest; ++i) {
      VectorX unit = VectorX::Zero(layout().v_count());
      for (int s : colour)
        if (i < velocities_of(bodies[s])) unit[bodies[s].v + i] = 1;
      const auto take = [&](std::vector<Eigen::Triplet<double>>& into) {
        along(direction, force, rows);
        for (int s : colour) {
          if (i >= velocities_of(bodies[s])) continue;
          for (int other : influence_[s])
            for (int k = 0; k < velocities_of(bodies[other]); ++k)
              if (const int row = bodies[other].v + k; force[row] != 0)
                into.emplace_back(row, bodies[s].v + i, force[row]);
        }
      };
      direction = {unit, {}, {}, {}};
      take(by_q);
      direction = {{}, unit, {}, {}};
      take(by_v);
    }
  }
  const int n = layout().v_count();
  K_.resize(n, n), D_.resize(n, n);
  K_.setFromTriplets(by_q.begin(), by_q.end());
  D_.setFromTriplets(by_v.begin(), by_v.end());
  // What the colours missed shows along a direction that moves all.
  std::mt19937 random(seed_++);
  direction = {VectorX(n), VectorX(n), {}, {}};
  for (VectorX* x : {&direction.turn, &direction.velocity})
    for (double& value : *x) value = static_cast<double>(random()) / 2147483648.0 - 1;
  along(direction, force, rows);
  const VectorX own = K_ * direction.turn + D_ * direction.velocity;
  if ((own - force).lpNorm<Eigen::Infinity>() > 1e-8 * (largest_entry(force) + largest_entry(own)))
    throw SimulationError(
        "the equations near t = " + std::to_string(state_.time) + " s have no derivative that differences agree on",
        "TangentEquations", "look for what is not smooth there: friction at rest, a stop that closes");
}

}  // namespace lithe
