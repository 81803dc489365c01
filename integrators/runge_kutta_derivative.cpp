#include "engine/base/error.h"
#include "engine/motion/chart_maps.h"
#include "integrators/explicit_runge_kutta.h"

namespace lithe {

namespace {

constexpr int kMostCorrections = 12;
constexpr double kSolved = 1e-14;  // of what is wanted

class RepeatedRungeKutta final : public RepeatedStep {
 public:
  RepeatedRungeKutta(const RungeKuttaTableau& tableau, EquationsOfMotion& equations)
      : equations_(equations), step_(tableau, equations) {}

  void take(const State& from, const StepRecord* /*record*/, MatrixX& /*history*/, State& to) override {
    start_ = from;
    step_.accelerations(start_);
    if (step_.attempt(start_, to.time - from.time, to.time) != RungeKuttaStep::Outcome::taken)
      throw SimulationError("the step to t = " + std::to_string(to.time) + " s cannot be taken again nearby",
                            "explicit Runge-Kutta, derivative of a step", "look for what is not smooth there");
    step_.finish(to, Multipliers::later);
    to.contacts = from.contacts;
    equations_.memory().track_contacts(to);
  }

 private:
  EquationsOfMotion& equations_;
  RungeKuttaStep step_;
  State start_;
};

/// The step, equation by equation, backwards. With q_i = q_n ⊕ d_i, rates ḋ_i = Jr⁻¹(d_i) v_i, v̇_i = A(t_i, q_i, v_i):
///   d_i = h Σ a_ij ḋ_j,   v_i = v_n + h Σ a_ij v̇_j
/// At the end q* = q_n ⊕ d, v* move onto the constraints, q along those of the stage before (s):
///   q' = q* ⊕ c,   M_s c + G_sᵀ y = 0,   g(q') = 0;      M (v' - v*) + Gᵀ z = 0,   G v' + ∂g/∂t = 0
class RungeKuttaAdjoint final : public StepAdjoint {
 public:
  explicit RungeKuttaAdjoint(const RungeKuttaTableau& tableau) : tableau_(tableau) {}

  void adjoint(LinearEquations& equations, const TakenStep& step, Variation& x, MatrixX& gradient) override {
    const State &from = step.from, &to = step.to;
    const Layout& layout = equations.layout();
    const Eigen::Index n = from.v.size(), wants = x.turn.cols();
    const int last = tableau_.stages - 1, rows = layout.row_count();
    run_stages(equations, from, to);
    MatrixX of_q = x.turn, of_v = x.velocity;  // at the step's end

    // 1. v' moved onto the constraints at q'.
    if (rows > 0) {
      State end = to;
      end.v_dot.setZero(n), end.lambda.setZero(rows);
      equations.at(end);
      // z, of M (v' - v*) + Gᵀ z = 0.
      WeightedSum sum{.rows = WeightedSum::Rows::velocity, .forces = false, .a = to.v - v_.col(last), .l = {}, .u = {}};
      LinearEquations::Pulled pulled;
      equations.pull(sum.a, VectorX::Zero(rows), pulled);
      MatrixX force = -pulled.acceleration, no_rows = MatrixX::Zero(rows, 1);
      equations.solve_mass(force, no_rows);
      sum.l = no_rows.col(0);
      MatrixX mu = of_v, nu = MatrixX::Zero(rows, wants);
      equations.solve_mass(mu, nu);
      MatrixX direct = MatrixX::Zero(n, wants);
      equations.add_weighted(sum, mu, nu, -1, of_q, direct, gradient);
      // v* alone moves on by what is left: M μ.
      for (Eigen::Index k = 0; k < wants; ++k) {
        equations.pull(mu.col(k), VectorX::Zero(rows), pulled);
        of_v.col(k) = pulled.acceleration;
      }
    }

    // 2. q' moved onto the constraints along those of the stage before.
    MatrixX of_stage_q = MatrixX::Zero(n, wants), of_stage_v = of_stage_q;  // at the stage before the last
    if (rows > 0) {
      VectorX star(layout.q_count()), c(n);
      layout.retract(from.q, d_.col(last), star);
      layout.difference(star, to.q, c);
      // With δq' = E δq* + T δc:  M_s μ + Tᵀ G'ᵀ ν = Tᵀ w,  G_s μ = 0.  G_s stands for G' T, and is corrected.
      ChartMaps moved;
      moved.at(layout, c);
      const State before = stage_state(from, to, last - 1, layout);
      MatrixX nu = MatrixX::Zero(rows, wants), mu = MatrixX::Zero(n, wants), left = of_q;
      moved.turn_transposed(left);
      LinearEquations::Pulled pulled;
      double size = left.lpNorm<Eigen::Infinity>(), last_size = 2 * size;
      for (int i = 0; i < kMostCorrections && size > kSolved * of_q.lpNorm<Eigen::Infinity>() && size < last_size;
           ++i) {
        MatrixX no_rows = MatrixX::Zero(rows, wants);
        equations.at(before);
        equations.solve_mass(left, no_rows);
        mu += left;
        nu += no_rows;
        left = of_q;
        equations.at(to);
        for (Eigen::Index k = 0; k < wants; ++k) {
          equations.pull(VectorX::Zero(n), nu.col(k), pulled);
          left.col(k) -= pulled.turn;
        }
        moved.turn_transposed(left);
        equations.at(before);
        for (Eigen::Index k = 0; k < wants; ++k) {
          equations.pull(mu.col(k), VectorX::Zero(rows), pulled);
          left.col(k) -= pulled.acceleration;
        }
        last_size = size;
        size = left.lpNorm<Eigen::Infinity>();
      }
      // g(q') = 0 by q' and the parameters: -ν.
      equations.at(to);
      WeightedSum position{.rows = WeightedSum::Rows::position, .forces = false, .a = {}, .l = {}, .u = {}};
      MatrixX none = MatrixX::Zero(n, wants);
      equations.add_weighted(position, MatrixX(n, 0), nu, -1, of_q, none, gradient);
      // M_s c + G_sᵀ y by the stage and the parameters: -μ.
      WeightedSum along{.rows = WeightedSum::Rows::product, .forces = false, .a = c, .l = {}, .u = VectorX::Zero(n)};
      equations.at(before);
      equations.pull(c, VectorX::Zero(rows), pulled);
      MatrixX force = -pulled.acceleration, no_rows = MatrixX::Zero(rows, 1);
      equations.solve_mass(force, no_rows);
      along.l = no_rows.col(0);
      equations.add_weighted(along, mu, MatrixX::Zero(rows, wants), -1, of_stage_q, none, gradient);
      moved.carry_transposed(of_q);
    }

    // 3. Stages, backwards. w_d, w_v: what is wanted of d_i and v_i.
    const auto stages = static_cast<std::size_t>(tableau_.stages);
    std::vector<MatrixX> of_d_dot(stages, MatrixX::Zero(n, wants)), of_v_dot = of_d_dot;
    MatrixX of_start_q = MatrixX::Zero(n, wants), of_start_v = of_start_q;
    for (int i = last; i >= 0; --i) {
      const auto stage = static_cast<std::size_t>(i);
      MatrixX q = MatrixX::Zero(n, wants), v = q, d = q;
      if (i == last) {
        q = of_q, v = of_v;
      } else {
        if (i == last - 1) q = of_stage_q, v = of_stage_v;
        equations.at(stage_state(from, to, i, layout));
        equations.add_accelerations(of_v_dot[stage], q, v, gradient);
        // ḋ = Jr⁻¹(d) v.
        add_chart_rate_products(layout, d_.col(i), v_.col(i), of_d_dot[stage], d, v);
      }
      // q_i = q_n ⊕ d_i.
      maps_.at(layout, d_.col(i));
      MatrixX turned = q;
      maps_.turn_transposed(turned);
      maps_.carry_transposed(q);
      d += turned;
      of_start_q += q;
      of_start_v += v;
      for (int j = 0; j < i; ++j) {
        const double weight = h_ * tableau_.a[stage][static_cast<std::size_t>(j)];
        if (weight == 0) continue;
        of_d_dot[static_cast<std::size_t>(j)] += weight * d;
        of_v_dot[static_cast<std::size_t>(j)] += weight * v;
      }
    }
    x.turn = of_start_q;
    x.velocity = of_start_v;
  }

  void adjoint_start(LinearEquations&, const State&, Variation&, MatrixX&) override {}

  std::string refuse(EquationsOfMotion& equations) const override {
    if (!equations.parts().forward_dynamics) return "";
    return "forward dynamics of trees and planar mechanisms, by which explicit methods run this scene, have no adjoint "
           "yet (ParametricScene::forward_dynamics = false goes without)";
  }

 private:
  /// The stages again, from the equations themselves.
  void run_stages(LinearEquations& equations, const State& from, const State& to) {
    const Layout& layout = equations.layout();
    const int stages = tableau_.stages;
    h_ = to.time - from.time;
    for (MatrixX* x : {&d_, &v_, &d_dot_, &v_dot_}) x->setZero(from.v.size(), stages);
    lambda_.setZero(layout.row_count(), stages);
    VectorX rate(from.v.size()), v_dot, lambda;
    for (int i = 0; i < stages; ++i) {
      v_.col(i) = from.v;
      for (int j = 0; j < i; ++j) {
        const double weight = h_ * tableau_.a[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)];
        d_.col(i) += weight * d_dot_.col(j);
        v_.col(i) += weight * v_dot_.col(j);
      }
      if (i == stages - 1) break;
      layout.chart_rates(d_.col(i), v_.col(i), rate);
      d_dot_.col(i) = rate;
      equations.at(stage_state(from, to, i, layout));
      equations.accelerations(v_dot, lambda);
      v_dot_.col(i) = v_dot;
      lambda_.col(i) = lambda;
    }
  }

  State stage_state(const State& from, const State& to, int i, const Layout& layout) const {
    State state = from;
    state.time = i == 0                     ? from.time
                 : i >= tableau_.stages - 2 ? to.time
                                            : from.time + tableau_.time[static_cast<std::size_t>(i)] * h_;
    layout.retract(from.q, d_.col(i), state.q);
    state.v = v_.col(i);
    state.v_dot = v_dot_.col(i);
    state.lambda = lambda_.col(i);
    return state;
  }

  const RungeKuttaTableau& tableau_;
  double h_ = 0;
  MatrixX d_, v_, d_dot_, v_dot_, lambda_;  // a column a stage
  ChartMaps maps_;
};

}  // namespace

std::unique_ptr<RepeatedStep> ExplicitRungeKutta::repeated_step(EquationsOfMotion& equations) const {
  return std::make_unique<RepeatedRungeKutta>(*tableau_, equations);
}

std::unique_ptr<StepAdjoint> ExplicitRungeKutta::step_adjoint() const {
  return std::make_unique<RungeKuttaAdjoint>(*tableau_);
}

}  // namespace lithe
