#include <map>

#include "engine/base/error.h"
#include "engine/motion/chart_maps.h"
#include "integrators/lie_bdf.h"
#include "integrators/refinement.h"

namespace lithe {

std::size_t BdfRecord::bytes() const {
  Eigen::Index numbers = 0;
  for (const Step& s : steps)
    numbers += s.to.q.size() + s.to.v.size() + s.to.v_dot.size() + s.to.lambda.size() + s.d.size() + s.past_d.size();
  return sizeof(BdfRecord) + steps.size() * sizeof(Step) + sizeof(double) * static_cast<std::size_t>(numbers);
}

/// The step with q' = base ⊕ d, p' = Σ w_i of d and of v over the points of the past, P the part of these alone:
///   v = Jr(d) (w d + P_d) - w b,   v̇ = w v + P_v,   M v̇ + Gᵀλ = f,   g = 0,   G v + ∂g/∂t = 0,   S b + Gᵀy = 0
/// S = K + w D + w² M, made anew here; how it and G turn in S b + Gᵀy is left out, b is as small as the step's error.
/// Points of the past are states of the run: their changes, and what is wanted of them, are kept by their times.
class LieBdfDerivative final : public StepDerivative {
 public:
  explicit LieBdfDerivative(const LieBdf& method) : method_(method) {}

  MatrixX history(const State& state) const override { return MatrixX(state.v.size(), 0); }

  std::string refuse_step(const State&, const State&) const override {
    const auto record = method_.step_record();
    if (!record) return "it leads across a singular pose";
    for (const BdfRecord::Step& s : static_cast<const BdfRecord&>(*record).steps)
      if (s.times.empty() || s.times.back() < method_.begun_) return "its polynomial has points before the start";
    return "";
  }

  void tangent(LinearEquations& equations, const TakenStep& step, Variation& x) override {
    const auto& record = static_cast<const BdfRecord&>(*step.record);
    const auto& steps = record.steps;
    past_[step.from.time] = {x.turn, x.velocity};
    for (std::size_t i = 0; i < steps.size(); ++i) {
      const State& to = i + 1 < steps.size() ? steps[i].to : step.to;
      set_step(equations.layout(), steps[i], to);
      past_[to.time] = solve_tangent(equations, steps[i], to);
    }
    past_.erase(past_.begin(), past_.lower_bound(record.oldest));
    x.turn = past_[step.to.time].turn;
    x.velocity = past_[step.to.time].velocity;
  }

  void adjoint(LinearEquations& equations, const TakenStep& step, Variation& x, MatrixX& gradient) override {
    const auto& steps = static_cast<const BdfRecord*>(step.record)->steps;
    for (std::size_t i = steps.size(); i-- > 0;) {
      const bool last = i + 1 == steps.size();
      const State& to = last ? step.to : steps[i].to;
      set_step(equations.layout(), steps[i], to);
      solve_adjoint(equations, steps[i], to, last ? Point{x.turn, x.velocity} : take(to.time, x), gradient);
    }
    Point before = take(step.from.time, x);
    x.turn = std::move(before.turn);
    x.velocity = std::move(before.velocity);
  }

  void adjoint_start(LinearEquations&, const State&, Variation&, MatrixX&) override {}

 private:
  struct Point {
    MatrixX turn, velocity;
  };

  /// What has been wanted of the state at that time.
  Point take(double time, const Variation& x) {
    auto found = past_.extract(time);
    if (found) return std::move(found.mapped());
    return {MatrixX::Zero(x.turn.rows(), x.turn.cols()), MatrixX::Zero(x.turn.rows(), x.turn.cols())};
  }
  Point& wanted(double time, const MatrixX& like) {
    Point& point = past_[time];
    if (point.turn.size() == 0) point.turn.setZero(like.rows(), like.cols()), point.velocity = point.turn;
    return point;
  }

  void set_step(const Layout& layout, const BdfRecord::Step& step, const State& to) {
    const int order = static_cast<int>(step.times.size());
    BdfHistory::derivative_weights(
        to.time, order, [&](int i) { return step.times[static_cast<std::size_t>(i)]; }, w_);
    maps_.at(layout, step.d);
    past_maps_.resize(step.times.size());
    rate_ = w_[0] * step.d;
    for (int i = 0; i < order; ++i) {
      past_maps_[static_cast<std::size_t>(i)].at(layout, step.past_d.col(i));
      rate_ += w_[static_cast<std::size_t>(i) + 1] * step.past_d.col(i);
    }
    // d/dd of Jr(d) (w d + P_d), at the rates.
    turning_.clear();
    for (const auto& b : layout.bodies()) {
      if (!b.frame) continue;
      auto& [at, by] = turning_.emplace_back(b.v + 3, Matrix3());
      for (int k = 0; k < 3; ++k)
        by.col(k) = right_jacobian_change(step.d.segment<3>(at), Vector3::Unit(k), rate_.segment<3>(at));
    }
  }
  MatrixX turning(MatrixX of_turn) const {
    maps_.change(of_turn);
    MatrixX out = MatrixX::Zero(of_turn.rows(), of_turn.cols());
    for (const auto& [at, by] : turning_) out.middleRows<3>(at) = by * of_turn.middleRows<3>(at);
    return out;
  }
  MatrixX turning_transposed(const MatrixX& of_velocity) const {
    MatrixX out = MatrixX::Zero(of_velocity.rows(), of_velocity.cols());
    for (const auto& [at, by] : turning_) out.middleRows<3>(at) = by.transpose() * of_velocity.middleRows<3>(at);
    maps_.change_transposed(out);
    return out;
  }

  Point solve_tangent(LinearEquations& equations, const BdfRecord::Step& step, const State& to) {
    const double w = w_[0];
    MatrixX turn = past_.at(step.base_time).turn, base = turn;
    MatrixX P_d = MatrixX::Zero(turn.rows(), turn.cols()), P_v = P_d;
    for (std::size_t i = 0; i < step.times.size(); ++i) {
      const Point& point = past_.at(step.times[i]);
      MatrixX d = base;
      past_maps_[i].carry(d);
      d = point.turn - d;
      past_maps_[i].change(d);
      P_d += w_[i + 1] * d;
      P_v += w_[i + 1] * point.velocity;
    }
    maps_.carry(turn);
    maps_.turn(P_d);
    MatrixX velocity = P_d, force_columns, row_columns, rate_columns;
    equations.at(to);
    equations.parameter_columns(force_columns, row_columns, &rate_columns);
    equations.factorize({1, w, w * w}, to.v / w, false);
    VectorX force, rows, rates, more, none, more_rates;
    for (Eigen::Index k = 0; k < turn.cols(); ++k) {
      VectorX u = VectorX::Zero(to.v.size()), b = u;
      LinearEquations::Direction direction{{}, {}, {}, VectorX::Zero(row_columns.rows())};
      const auto along = [&] {
        direction.turn = turn.col(k) + u;
        direction.velocity = velocity.col(k) + w * (u - b) + turning(u);
        direction.acceleration = w * direction.velocity + P_v.col(k);
      };
      const bool solved = refine([&] {
        along();
        // Apart: in short steps velocities change by far more than positions.
        equations.along({direction.turn, {}, {}, {}}, force, rows, &rates);
        equations.along({{}, direction.velocity, direction.acceleration, direction.multipliers}, more, none,
                        &more_rates);
        force += more + force_columns.col(k);
        rates = (rates + more_rates + rate_columns.col(k)) / w;
        rows += row_columns.col(k) - rates;
        for (int row : equations.velocity_rows()) rows[row] = 0;
        equations.solve(force, rates);
        direction.multipliers -= rates;
        VectorX correction = VectorX::Zero(force.size());
        equations.solve(correction, rows);
        u -= force + correction;
        b -= correction;
        // The two cancel in u, not in v.
        return std::pair(std::max(force.lpNorm<Eigen::Infinity>(), correction.lpNorm<Eigen::Infinity>()),
                         direction.turn.lpNorm<Eigen::Infinity>() + direction.velocity.lpNorm<Eigen::Infinity>() / w);
      });
      if (!solved) give_up(to);
      along();
      turn.col(k) = direction.turn;
      velocity.col(k) = direction.velocity;
    }
    return {turn, velocity};
  }

  /// With multipliers μ, ν, κ of dynamics, positions and velocities, what is wanted of v' and q' comes to
  ///   p = Dᵀμ + Gᵀκ + w M μ + …,   z = Kᵀμ + Gᵀν + Ġᵀκ + …,   z + w p + (∂v/∂d)ᵀp = 0,   G μ = 0,   G S⁻ᵀ p = 0
  void solve_adjoint(LinearEquations& equations, const BdfRecord::Step& step, const State& to, const Point& want,
                     MatrixX& gradient) {
    const double w = w_[0];
    const Eigen::Index n = want.turn.rows(), wants = want.turn.cols(), row_count = equations.layout().row_count();
    equations.at(to);
    equations.factorize({1, w, w * w}, to.v / w, true);
    MatrixX mu = MatrixX::Zero(n, wants), nu = MatrixX::Zero(row_count, wants), kappa = nu, no_gradient(0, wants);
    MatrixX p(n, wants), z(n, wants), M(n, wants), p_before = mu, G(row_count, wants);
    LinearEquations::Pulled pulled;
    VectorX force, rows, lacking, lacking_rows;
    const bool solved = refine([&] {
      for (Eigen::Index k = 0; k < wants; ++k) {
        equations.pull(mu.col(k), nu.col(k), pulled);
        z.col(k) = pulled.turn, p.col(k) = pulled.velocity, M.col(k) = pulled.acceleration, G.col(k) = pulled.rows;
      }
      equations.add_rate_sums(kappa, z, p, no_gradient);
      z += want.turn;
      p += want.velocity + w * M;
      const MatrixX sum = z + w * p + turning_transposed(p);
      for (Eigen::Index k = 0; k < wants; ++k) {
        lacking = p.col(k), lacking_rows.setZero(row_count);
        equations.solve(lacking, lacking_rows);
        force = -sum.col(k), rows = -G.col(k);
        equations.solve(force, rows);
        mu.col(k) += force;
        kappa.col(k) -= lacking_rows;
        nu.col(k) += rows + w * lacking_rows;
      }
      const double change = (p - p_before).lpNorm<Eigen::Infinity>();
      p_before = p;
      return std::pair(change, p.lpNorm<Eigen::Infinity>() + want.turn.lpNorm<Eigen::Infinity>() / w);
    });
    if (!solved) give_up(to);
    equations.add_parameter_products(mu, nu, 1, gradient);
    MatrixX unused = MatrixX::Zero(n, wants), unused_too = unused;
    equations.add_rate_sums(kappa, unused, unused_too, gradient);
    maps_.carry_transposed(z);
    maps_.turn_transposed(p);
    MatrixX& base = wanted(step.base_time, z).turn;
    base += z;
    for (std::size_t i = 0; i < step.times.size(); ++i) {
      Point& point = wanted(step.times[i], z);
      MatrixX of_point = w_[i + 1] * p;
      past_maps_[i].change_transposed(of_point);
      point.turn += of_point;
      point.velocity += w_[i + 1] * M;
      past_maps_[i].carry_transposed(of_point);
      base -= of_point;
    }
  }

  [[noreturn]] static void give_up(const State& to) {
    throw SimulationError("the derivative of the step to t = " + std::to_string(to.time) + " s was not found to 1e-6",
                          "Lie-group BDF, derivative of a step",
                          "look for what is not smooth there, or give a smaller tolerance");
  }

  const LieBdf& method_;
  std::map<double, Point> past_;  // by time: changes of points, or what is wanted of them
  BdfHistory::Weights w_{};
  VectorX rate_;
  ChartMaps maps_;
  std::vector<ChartMaps> past_maps_;
  std::vector<std::pair<int, Matrix3>> turning_;  // of each frame, from its first turn on
};

BdfRecord::Step LieBdf::last_step() const {
  BdfRecord::Step step{{}, history_.base_time(), history_.d(0), {}, MatrixX(history_.d(0).size(), last_order_)};
  for (int i = 0; i < last_order_; ++i) {
    step.times.push_back(history_.time(i + 1));
    step.past_d.col(i) = history_.d(i + 1);
  }
  return step;
}

std::shared_ptr<const StepRecord> LieBdf::step_record() const {
  if (started_.empty() && last_order_ == 0) return nullptr;
  const auto record = std::make_shared<BdfRecord>();
  record->steps = started_.empty() ? std::vector{last_step()} : started_;
  record->oldest = std::min(history_.base_time(), history_.time(history_.size() - 1));
  return record;
}

std::unique_ptr<StepDerivative> LieBdf::step_derivative() const { return std::make_unique<LieBdfDerivative>(*this); }

}  // namespace lithe
