#include "engine/gradient/tangent_equations.h"

#include <algorithm>
#include <random>
#include <set>

#include "engine/assembly/tangent_factors.h"
#include "engine/base/error.h"
#include "engine/factor/block_products.h"
#include "engine/gradient/differences.h"
#include "engine/gradient/row_rates.h"
#include "engine/motion/projection.h"

namespace lithe {

namespace {

constexpr int kFirstLooks = 8, kLooks = 32;  // at the elements' tangents: of the first states, then of every so many
constexpr double kAgree = 2e-9;              // of a body's rows, between the elements' tangents and differences
constexpr double kColumnsAgree = 1e-8;       // of a direction that moves all, with differenced columns
constexpr double kTouchesAgree = 1e-5;       // likewise where surfaces have just met, and round-off is large
constexpr double kAgreeAll = 1e-12;          // of all rows: round-off of the differences

int velocities_of(const Layout::BodySlice& b) { return (b.frame ? 6 : 0) + b.linear; }

}  // namespace

TangentEquations::TangentEquations(const System& system, ParameterDerivative* parameters, ParameterTerms* terms,
                                   bool at_rest)
    : equations_(system), parameters_(parameters), terms_(terms), at_rest_(at_rest) {}

TangentEquations::~TangentEquations() = default;

void TangentEquations::at(const State& state) {
  state_ = state;
  near_ = state;
  equations_.recall(state.quarter_turns);
  equations_.recall_rows(state.left_out);
  ready_ = evaluated_ = formed_ = false;
  scale_ = terms_of_force_ = 0;
}

/// The evaluator at the state.
void TangentEquations::stand() {
  if (!evaluated_) equations_.evaluate(state_.time, state_.q, state_.v, Level::velocity);
  evaluated_ = true;
}

void TangentEquations::evaluate(double offset, const Direction& direction, VectorX& force, VectorX& rows,
                                VectorX* rates) {
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
  if (!rates && equations_.velocity_rows().empty()) return;
  VectorX g_dot(rows.size());
  equations_.constraint(Level::velocity, g_dot);
  for (int row : equations_.velocity_rows()) rows[row] = g_dot[row];
  if (rates) *rates = g_dot;
}

void TangentEquations::along(const Direction& direction, VectorX& force, VectorX& rows, VectorX* rates) {
  if (at_rest_ && scale_ == 0)
    difference_along({VectorX::Ones(state_.v.size()), {}, {}, {}}, force, rows, nullptr, scale_);
  difference_along(direction, force, rows, rates, scale_);
}

/// `scale`: of the largest derivatives near the state, by the size of their directions.
void TangentEquations::difference_along(const Direction& direction, VectorX& force, VectorX& rows, VectorX* rates,
                                        double& scale) {
  // Linear in accelerations; multipliers and velocities count as far as they turn or move something.
  const double size =
      std::max(largest_entry(direction.turn), largest_entry(direction.velocity) / (1 + largest_entry(state_.v)));
  const double h = size > 0 ? kDirectionStep / size : 1;
  VectorX g_dot;
  const auto at = [&](double t) -> VectorX {
    evaluate(t, direction, force, rows, rates ? &g_dot : nullptr);
    VectorX all(force.size() + rows.size() + g_dot.size());
    all << force, rows, g_dot;
    return all;
  };
  double sized = size * scale;
  const VectorX all = difference(h, !at_rest_, sized, at, terms_of_force_);
  if (size > 0) scale = sized / size;
  force = all.head(force.size());
  rows = all.segment(force.size(), rows.size());
  if (rates) *rates = all.tail(g_dot.size());
}

void TangentEquations::parameter_columns(MatrixX& force, MatrixX& rows, MatrixX* rates) {
  parameters_->columns(state_, force, rows, rates);
}

void TangentEquations::add_parameter_products(const MatrixX& mu, const MatrixX& nu, double factor, MatrixX& out) {
  if (terms_) {
    const WeightedSum sum{
        .rows = WeightedSum::Rows::position, .forces = true, .a = state_.v_dot, .l = state_.lambda, .u = {}};
    return terms_->add_products(state_, sum, mu, nu, factor, out);
  }
  VectorX products;
  for (Eigen::Index k = 0; k < mu.cols(); ++k) {
    products.setZero(out.rows());
    parameters_->add_products(state_, mu.col(k), nu.col(k), products);
    out.col(k) += factor * products;
  }
}

void TangentEquations::factorize(const TangentWeights& weights, const VectorX& increment, bool transposed) {
  if (transposed && !ready_) check_tangents();
  stand();
  if (equations_.reacts()) {
    VectorX r(state_.v.size());
    equations_.residual(state_.v_dot, state_.lambda, r);  // friction learns the reactions
  }
  if (transposed && tangents_ != Tangents::differenced)
    factorize_formed(weights, increment);
  else if (transposed)
    equations_.factors().factorize_transposed(weights, state_.v_dot, state_.lambda, &increment);
  else
    equations_.factorize(weights, state_.v_dot, state_.lambda, &increment);
}

/// K, D and M from three tangents of which only one asks for stiffnesses, the dearest part, and the factor of
/// (K + (w_v D + w_a M) Jr⁻¹)ᵀ from them.
void TangentEquations::factorize_formed(const TangentWeights& weights, const VectorX& increment) {
  const BlockStructure& blocks = equations_.system().blocks();
  const Workspace& work = equations_.workspace();
  form(M_blocks_, {0, 0, 1}, state_.v_dot, state_.lambda);
  form(D_blocks_, {0, 1, 0}, state_.v_dot, state_.lambda);
  form(K_blocks_, weights, state_.v_dot, state_.lambda);
  std::vector<double>& factor = factor_blocks_;
  factor = K_blocks_;
  const double of_v = weights.velocity, of_a = weights.acceleration;
  const auto take = [&](int first, int rows, int columns, const Matrix3* chart) {
    using Block = Eigen::Map<MatrixX>;
    Block K(K_blocks_.data() + first, rows, columns), F(factor.data() + first, rows, columns);
    moved_ =
        of_v * Block(D_blocks_.data() + first, rows, columns) + of_a * Block(M_blocks_.data() + first, rows, columns);
    K -= moved_;
    F = K;
    if (chart) moved_.middleCols<3>(3) = moved_.middleCols<3>(3).lazyProduct(*chart).eval();
    F += moved_;
  };
  charts_.clear();
  for (const auto& f : blocks.frames) charts_.push_back(right_jacobian_inverse(Vector3(increment.segment<3>(f.v + 3))));
  for (std::size_t i = 0; i < blocks.frames.size(); ++i) take(blocks.frames[i].values, 6, 6, &charts_[i]);
  for (const auto& l : blocks.linears) {
    for (int f = 0; f < l.frames; ++f) {
      take(l.frame_linear + 6 * l.size * f, 6, l.size, nullptr);
      take(l.linear_frame + 6 * l.size * f, l.size, 6, &charts_[static_cast<std::size_t>(l.frame + f)]);
    }
    take(l.values, l.pattern ? static_cast<int>(l.pattern->rows.size()) : l.size, 1, nullptr);
  }
  for (const auto& c : blocks.couplings) {
    take(c.ab, 6, 6, &charts_[static_cast<std::size_t>(c.b)]);
    take(c.ba, 6, 6, &charts_[static_cast<std::size_t>(c.a)]);
  }
  const int rows = static_cast<int>(state_.lambda.size());
  for (const auto& row : blocks.rows)
    for (int i = 0; row.compliant >= 0 && i < row.count; ++i) {
      const double stiffness = work.row_stiffness[row.first - rows + i];
      K_blocks_[static_cast<std::size_t>(row.compliant + i)] = stiffness == 0 ? -1e30 : -1 / stiffness;
    }
  formed_ = true;
  equations_.factors().factorize_transposed(factor);
}

void TangentEquations::solve(VectorX& force, VectorX& rows) { equations_.solve(force, rows); }

void TangentEquations::factorize_complex(const ComplexTangentWeights& weights) {
  stand();
  equations_.factors().factorize_complex_transposed(weights, state_.v_dot, state_.lambda);
}

void TangentEquations::solve_complex(ComplexVectorX& force, ComplexVectorX& rows) {
  equations_.factors().solve_complex(force, rows);
}

void TangentEquations::solve_mass(MatrixX& force, MatrixX& rows) {
  stand();
  equations_.factorize({0, 0, 1}, VectorX::Zero(force.rows()), VectorX::Zero(rows.rows()), nullptr);
  VectorX f, g;
  for (Eigen::Index k = 0; k < force.cols(); ++k) {
    f = force.col(k), g = rows.col(k);
    equations_.solve(f, g);
    force.col(k) = f, rows.col(k) = g;
  }
}

void TangentEquations::accelerations(VectorX& v_dot, VectorX& lambda) {
  v_dot.setZero(state_.v.size());
  lambda.setZero(layout().row_count());
  Projector(equations_).accelerations(state_.time, state_.q, state_.v, v_dot, lambda);
  evaluated_ = false;
}

void TangentEquations::form(std::vector<double>& blocks, const TangentWeights& weights, const VectorX& a,
                            const VectorX& l) {
  equations_.factors().form_tangent(weights, a, l, nullptr);
  blocks = equations_.factors().formed();
}

/// Gᵀν of rows whose Jacobians are these.
void TangentEquations::add_row_products(const std::vector<double>& values, const VectorX& nu, VectorX& out) const {
  add_row_forces(equations_.system().blocks(), values, static_cast<int>(nu.size()), nu.data(), nullptr, out.data());
}

/// d/dt of all rows along the motion of the state and, where its acceleration is given, d²/dt²: differences of order 6.
void TangentEquations::find_row_rates(const VectorX* acceleration) {
  const BlockStructure& blocks = equations_.system().blocks();
  const auto accumulate = [&](std::vector<double>& sum, double weight) {
    const std::vector<double>& values = equations_.workspace().values;
    for (const auto& G : blocks.jacobians) {
      const int count = blocks.rows[static_cast<std::size_t>(G.rows)].count;
      const auto add = [&](int first, int size) {
        for (int i = first; i < first + size; ++i)
          sum[static_cast<std::size_t>(i)] += weight * values[static_cast<std::size_t>(i)];
      };
      if (G.frame >= 0) add(G.values, 6 * count);
      if (G.linear >= 0) add(G.linear_values, count * blocks.linears[static_cast<std::size_t>(G.linear)].size);
    }
  };
  struct Point {
    double steps, first, second;
  };
  static constexpr Point kSixth[] = {{0, 0, -49.0 / 18},        {1, 3.0 / 4, 3.0 / 2},     {-1, -3.0 / 4, 3.0 / 2},
                                     {2, -3.0 / 20, -3.0 / 20}, {-2, 3.0 / 20, -3.0 / 20}, {3, 1.0 / 60, 1.0 / 90},
                                     {-3, -1.0 / 60, 1.0 / 90}};
  // m, rad. Second derivatives: round-off and what is cut off are both some 1e-12. First ones, of short dampers too,
  // 5 (moved / length)⁶ beside 1e-13.
  const double moved = acceleration ? 2e-2 : 1e-3;
  double h = moved / std::max(largest_entry(state_.v), 1.0);
  if (acceleration) h = std::min(h, std::sqrt(2 * moved / std::max(largest_entry(*acceleration), 1.0)));
  G_rate_.assign(static_cast<std::size_t>(blocks.value_count), 0.0);
  G_second_.assign(acceleration ? G_rate_.size() : 0, 0.0);
  VectorX by;
  for (const Point& point : kSixth) {
    if (!acceleration && point.first == 0) continue;
    const double t = point.steps * h;
    by = t * state_.v;
    if (acceleration) by += 0.5 * t * t * *acceleration;
    layout().retract(state_.q, by, near_.q);
    equations_.evaluate(state_.time + t, near_.q, state_.v, Level::velocity);
    accumulate(G_rate_, point.first / h);
    if (acceleration) accumulate(G_second_, point.second / (h * h));
  }
  near_.q = state_.q;
  evaluated_ = false;
}

/// What elements leave out of K: tensions of dampers change as their rows turn, length' = W(q) · v. By the symmetry of
/// second derivatives that is  Wᵀ c (Ẇ - W ω×).
void TangentEquations::add_turning_rows(const VectorX& x, VectorX& out, bool transposed) const {
  const BlockStructure& blocks = equations_.system().blocks();
  const Workspace& work = equations_.workspace();
  const int rows = static_cast<int>(state_.lambda.size());
  const auto turn = [&](const VectorX& y) {  // ω × y of each body; positions and modal coordinates do not turn
    VectorX turned = VectorX::Zero(y.size());
    for (const auto& b : layout().bodies())
      if (b.frame)
        turned.segment<3>(b.v + 3) = Vector3(state_.v.segment<3>(b.v + 3)).cross(Vector3(y.segment<3>(b.v + 3)));
    return turned;
  };
  VectorX tension = VectorX::Zero(work.tension.size());
  if (transposed) {
    tension = work.row_damping.cwiseProduct(rates_of_all_rows(blocks, work.values, x).tail(tension.size()));
    add_row_forces(blocks, G_rate_, rows, nullptr, tension.data(), out.data());
    VectorX force = VectorX::Zero(x.size());
    add_row_forces(blocks, work.values, rows, nullptr, tension.data(), force.data());
    out += turn(force);
  } else {
    const VectorX turned = turn(x);
    tension = rates_of_all_rows(blocks, G_rate_, x).tail(tension.size()) -
              rates_of_all_rows(blocks, work.values, turned).tail(tension.size());
    tension = work.row_damping.cwiseProduct(tension).eval();
    add_row_forces(blocks, work.values, rows, nullptr, tension.data(), out.data());
  }
}

void TangentEquations::pull(const VectorX& mu, const VectorX& nu, Pulled& out) {
  if (!ready_) check_tangents();
  stand();
  out.turn.setZero(mu.size());
  out.velocity.setZero(mu.size());
  out.acceleration.setZero(mu.size());
  out.rows.setZero(nu.size());
  add_row_products(equations_.workspace().values, nu, out.turn);
  add_rates(equations_.system().blocks(), equations_.workspace().values, mu.data(), out.rows);
  if (tangents_ != Tangents::differenced) {
    if (!formed_) {
      form(M_blocks_, {0, 0, 1}, state_.v_dot, state_.lambda);
      form(K_blocks_, {1, 0, 0}, state_.v_dot, state_.lambda);
      form(D_blocks_, {0, 1, 0}, state_.v_dot, state_.lambda);
      formed_ = true;
    }
    equations_.factors().add_tangent_product(K_blocks_, mu, out.turn, true);
    equations_.factors().add_tangent_product(D_blocks_, mu, out.velocity, true);
    equations_.factors().add_tangent_product(M_blocks_, mu, out.acceleration, true);
    if (tangents_ == Tangents::with_row_rates) add_turning_rows(mu, out.turn, true);
    return;
  }
  out.turn += K_.transpose() * mu;
  out.velocity += D_.transpose() * mu;
  // r is linear in v̇; M is symmetric. A large one, so that little of it drowns in the forces at play.
  constexpr double kLarge = 1e8;
  const VectorX no_load = VectorX::Zero(nu.size());
  const double size = largest_entry(mu), scale = size > 0 ? kLarge / size : 1;
  force_before_.resize(mu.size());
  force_.resize(mu.size());
  equations_.residual(VectorX::Zero(mu.size()), no_load, force_before_);
  equations_.residual(scale * mu, no_load, force_);
  out.acceleration = (force_ - force_before_) / scale;
}

/// out += factor Kᵀμ, K = ∂(M a + Gᵀ l - f)/∂q at the state's t, q, v.
void TangentEquations::add_stiffness_products(const MatrixX& mu, const VectorX& a, const VectorX& l, double factor,
                                              MatrixX& out) {
  VectorX product;
  if (tangents_ == Tangents::differenced) {
    const State state = state_;
    near_.v_dot = state_.v_dot = a;
    near_.lambda = state_.lambda = l;
    difference_columns();
    near_ = state_ = state;
    ready_ = false;
    for (Eigen::Index k = 0; k < mu.cols(); ++k) out.col(k) += factor * (K_.transpose() * mu.col(k));
    return;
  }
  stand();
  std::vector<double> blocks;
  form(blocks, {1, 0, 0}, a, l);
  for (Eigen::Index k = 0; k < mu.cols(); ++k) {
    product.setZero(mu.rows());
    equations_.factors().add_tangent_product(blocks, mu.col(k), product, true);
    if (tangents_ == Tangents::with_row_rates) add_turning_rows(mu.col(k), product, true);
    out.col(k) += factor * product;
  }
}

/// Rows by the symmetry of derivatives along the motion, d/dt (∂g/∂q̇) = ∂ġ/∂q, where velocities turn with the bodies:
///   δġ = Ġ δθ + G (δv - ω × δθ),   δg̈ = G̈ δθ + 2 Ġ δθ˙ + G δθ¨,   δθ˙ = δv - ω × δθ
void TangentEquations::add_weighted(const WeightedSum& sum, const MatrixX& mu, const MatrixX& nu, double factor,
                                    MatrixX& turn, MatrixX& velocity, MatrixX& gradient) {
  if (!ready_) check_tangents();
  const Eigen::Index n = state_.v.size(), count = nu.cols();
  const VectorX no_motion = VectorX::Zero(n), no_load = VectorX::Zero(layout().row_count());
  if (mu.cols() > 0) {
    add_stiffness_products(mu, sum.a, sum.l, factor, turn);
    if (!sum.forces) add_stiffness_products(mu, no_motion, no_load, -factor, turn);
    if (sum.forces) {
      if (!ready_) check_tangents();
      stand();
      if (tangents_ != Tangents::differenced) form(D_blocks_, {0, 1, 0}, state_.v_dot, state_.lambda), formed_ = false;
      for (Eigen::Index k = 0; k < count; ++k) {
        VectorX product = VectorX::Zero(n);
        if (tangents_ == Tangents::differenced)
          product = D_.transpose() * mu.col(k);
        else
          equations_.factors().add_tangent_product(D_blocks_, mu.col(k), product, true);
        velocity.col(k) += factor * product;
      }
    }
  }
  const auto for_turns = [&](const auto& act) {
    for (const auto& b : layout().bodies())
      if (b.frame) act(b.v + 3, Vector3(state_.v.segment<3>(b.v + 3)));
  };
  const bool velocities = sum.rows == WeightedSum::Rows::velocity, second = sum.rows == WeightedSum::Rows::acceleration;
  std::vector<double> G_rate, G_second;
  if (velocities || second) {
    // Apart from the ones of the state that dampers take, which keep their order.
    G_rate.swap(G_rate_), G_second.swap(G_second_);
    find_row_rates(second ? &sum.a : &no_motion);
    G_rate.swap(G_rate_), G_second.swap(G_second_);
  }
  MatrixX one;
  for (Eigen::Index k = 0; k < count; ++k) {
    stand();
    VectorX force = VectorX::Zero(n), rate = VectorX::Zero(n), acceleration = VectorX::Zero(n);
    const VectorX weights = nu.col(k);
    add_row_products(equations_.workspace().values, weights, force);
    switch (sum.rows) {
      case WeightedSum::Rows::position:
        turn.col(k) += factor * force;
        break;
      case WeightedSum::Rows::product:
        one.setZero(n, 1);
        add_stiffness_products(sum.u, no_motion, weights, factor, one);
        add_stiffness_products(sum.u, no_motion, no_load, -factor, one);
        turn.col(k) += one;
        break;
      case WeightedSum::Rows::velocity:
        add_row_products(G_rate, weights, rate);
        for_turns([&](int at, const Vector3& w) { rate.segment<3>(at) += w.cross(force.segment<3>(at)); });
        turn.col(k) += factor * rate;
        velocity.col(k) += factor * force;
        break;
      case WeightedSum::Rows::acceleration:
        add_row_products(G_rate, weights, rate);
        add_row_products(G_second, weights, acceleration);
        for_turns([&](int at, const Vector3& w) {
          const Vector3 t = force.segment<3>(at), t_dot = rate.segment<3>(at);
          acceleration.segment<3>(at) +=
              2 * w.cross(t_dot) + Vector3(sum.a.segment<3>(at)).cross(t) + w.cross(w.cross(t));
          rate.segment<3>(at) += 0.5 * w.cross(t);
        });
        turn.col(k) += factor * acceleration;
        velocity.col(k) += 2 * factor * rate;
        break;
    }
  }
  if (terms_ && gradient.rows() > 0) terms_->add_products(state_, sum, mu, nu, factor, gradient);
}

/// The elements' tangents against differences along a random direction, body by body.
void TangentEquations::check_tangents() {
  ready_ = true;
  if (equations_.contacts()) tangents_ = Tangents::differenced;
  if (tangents_ == Tangents::differenced) return difference_columns();
  if (tangents_ == Tangents::with_row_rates) find_row_rates(nullptr);
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
  double of_columns = 0;
  difference_along(direction, force, rows, nullptr, of_columns);
  stand();
  VectorX r(state_.v.size()), own = VectorX::Zero(state_.v.size());
  equations_.residual(state_.v_dot, state_.lambda, r);
  const VectorX terms = terms_of_elements(direction.turn, direction.velocity);
  terms_of_force_ = find_terms_of_force();
  equations_.factors().form_tangent({1, 0, 0}, state_.v_dot, state_.lambda, nullptr);
  equations_.factors().add_tangent_product(direction.turn, own, false);
  equations_.factors().form_tangent({0, 1, 0}, state_.v_dot, state_.lambda, nullptr);
  equations_.factors().add_tangent_product(direction.velocity, own, false);
  const double all = largest_entry(force) + largest_entry(r);
  if (tangents_ == Tangents::of_elements) {
    if (agrees(force, own, terms, all)) return;
    tangents_ = Tangents::with_row_rates;
    find_row_rates(nullptr);
    stand();
  }
  add_turning_rows(direction.turn, own, false);
  if (agrees(force, own, terms, all)) return;
  tangents_ = Tangents::differenced;
  difference_columns();
}

/// |K| |turn| + |D| |velocity| by the elements: along some directions nearly all of it cancels.
VectorX TangentEquations::terms_of_elements(const VectorX& turn, const VectorX& velocity) {
  VectorX sum = VectorX::Zero(state_.v.size());
  const auto add = [&](const TangentWeights& weights, const VectorX& x) {
    equations_.factors().form_tangent(weights, state_.v_dot, state_.lambda, nullptr);
    std::vector<double> blocks = equations_.factors().formed();
    for (double& value : blocks) value = std::abs(value);
    VectorX product = VectorX::Zero(x.size());
    equations_.factors().add_tangent_product(blocks, x.cwiseAbs(), product, false);
    sum += product.cwiseAbs();
  };
  add({1, 0, 0}, turn);
  if (velocity.size() > 0) add({0, 1, 0}, velocity);
  return sum;
}

/// The size of what cancels in the equations: forces, and what the last bits of coordinates make of them.
double TangentEquations::find_terms_of_force() {
  stand();
  VectorX force(state_.v.size()), magnitudes(force.size());
  layout().magnitudes(state_.q, magnitudes);
  const VectorX of_coordinates = terms_of_elements(magnitudes, {});
  equations_.residual(VectorX::Zero(force.size()), VectorX::Zero(state_.lambda.size()), force);
  return largest_entry(force) + largest_entry(of_coordinates);
}

/// Of a difference along a direction of size one.
double TangentEquations::round_off() const { return kTermRoundOff * terms_of_force_ / kDirectionStep; }

bool TangentEquations::agrees(const VectorX& force, const VectorX& own, const VectorX& terms, double all) const {
  return std::all_of(layout().bodies().begin(), layout().bodies().end(), [&](const Layout::BodySlice& b) {
    const auto of = [&](const VectorX& x) { return x.segment(b.v, velocities_of(b)); };
    return largest_entry(of(force) - of(own)) <=
           kAgree * largest_entry(of(terms)) + 1e2 * kAgreeAll * all + round_off();
  });
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
  for (const ContactRecord& contact : equations_.system().contacts()) {  // any of it may touch any other
    std::set<int>& slices = of_row.emplace_back();
    for (int s = 0; s < count; ++s)
      for (int body : contact.bodies)
        if (body >= 0 && bodies[s].body == bodies[body].body) slices.insert(s);
  }
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
  const int n = layout().v_count();
  std::vector<Eigen::Triplet<double>> by_q, by_v;
  VectorX force, rows;
  // What the colours missed shows along a direction that moves all.
  std::mt19937 random(seed_++);
  Direction all{VectorX(n), VectorX(n), {}, {}}, direction;
  for (VectorX* x : {&all.turn, &all.velocity})
    for (double& value : *x) value = static_cast<double>(random()) / 2147483648.0 - 1;
  double of_all = 0;
  if (terms_of_force_ == 0) terms_of_force_ = find_terms_of_force();
  for (const auto& colour : colours_) {
    int widest = 0;
    for (int s : colour) widest = std::max(widest, velocities_of(bodies[s]));
    for (int i = 0; i < widest; ++i) {
      VectorX unit = VectorX::Zero(layout().v_count());
      for (int s : colour)
        if (i < velocities_of(bodies[s])) unit[bodies[s].v + i] = 1;
      const auto take = [&](std::vector<Eigen::Triplet<double>>& into) {
        double of_columns = 0;
        difference_along(direction, force, rows, nullptr, of_columns);
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
  K_.resize(n, n), D_.resize(n, n);
  K_.setFromTriplets(by_q.begin(), by_q.end());
  D_.setFromTriplets(by_v.begin(), by_v.end());
  difference_along(all, force, rows, nullptr, of_all);
  const VectorX own = K_ * all.turn + D_ * all.velocity;
  // Beside what is summed up, of which nearly all cancels along some directions.
  const VectorX terms = K_.cwiseAbs() * all.turn.cwiseAbs() + D_.cwiseAbs() * all.velocity.cwiseAbs();
  const double agree = equations_.contacts() ? kTouchesAgree : kColumnsAgree;
  if (largest_entry(own - force) > agree * (largest_entry(force) + largest_entry(terms)) + round_off())
    throw SimulationError(
        "the equations near t = " + std::to_string(state_.time) + " s have no derivative that differences agree on",
        "TangentEquations", "look for what is not smooth there: friction at rest, a stop that closes");
}

}  // namespace lithe
