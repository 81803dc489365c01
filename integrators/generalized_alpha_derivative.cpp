#include "engine/base/error.h"
#include "engine/motion/chart_maps.h"
#include "integrators/generalized_alpha.h"
#include "integrators/refinement.h"

namespace lithe {

namespace {

[[noreturn]] void give_up(const State& to) {
  throw SimulationError("the derivative of the step to t = " + std::to_string(to.time) + " s was not found to 1e-6",
                        "generalized-alpha, derivative of a step",
                        "look for what is not smooth there: friction at rest, a stop that closes, a clearance");
}

}  // namespace

/// δq' = E δq + T δd, and with c = 1/(1 - am)
///   δa' = c ((1 - af) δv̇' + af δv̇ - am δa)
///   δd = h δv + h² ((½ - β) δa + β δa'),   δv' = δv + h ((1 - γ) δa + γ δa')
///   K δq' + D δv' + M δv̇' + Gᵀ δλ' + ∂r/∂p δp = 0,   G δq' + ∂g/∂p δp = 0
/// λ is not carried on. In adjoint mode the same equations transposed. Steps of another length than the one before, as
/// events make them, scale what is carried (change_step()): these are taken again instead.
class GeneralizedAlphaDerivative final : public StepDerivative {
 public:
  explicit GeneralizedAlphaDerivative(const GeneralizedAlpha& method) : method_(method) {}

  MatrixX history(const State& state) const override {
    MatrixX vectors(state.v.size(), 2);
    vectors << state.v_dot, method_.a_;
    return vectors;
  }

  bool weighs_parameters() const override { return false; }

  bool by_repetition(const TakenStep& step) const override { return step.record; }

  void tangent(LinearEquations& equations, const TakenStep& step, Variation& x) override {
    const State &from = step.from, &to = step.to;
    set_step(equations.layout(), from, to);
    MatrixX &v_dot = x.history[0], &a = x.history[1];
    // What is known before the step's equations are solved.
    const MatrixX ahead = c_ * (af_ * v_dot - am_ * a);
    MatrixX carried = h_ * x.velocity + h_ * h_ * ((0.5 - beta_) * a + beta_ * ahead);
    maps_.turn(carried);
    maps_.carry(x.turn);
    x.turn += carried;
    x.velocity += h_ * ((1 - gamma_) * a + gamma_ * ahead);
    a = ahead;

    equations.at(to);
    equations.parameter_columns(force_columns_, row_columns_);
    equations.factorize({1, g1_, b1_}, d_, false);
    for (Eigen::Index k = 0; k < x.turn.cols(); ++k) {
      MatrixX y = VectorX::Zero(to.v.size()), turned;
      LinearEquations::Direction direction{{}, {}, {}, VectorX::Zero(row_columns_.rows())};
      const bool solved = refine([&] {
        turned = y;
        maps_.turn(turned);
        direction.turn = x.turn.col(k) + turned;
        direction.velocity = x.velocity.col(k) + g1_ * y;
        direction.acceleration = b1_ * y;
        equations.along(direction, force_, rows_);
        force_ += force_columns_.col(k);
        rows_ += row_columns_.col(k);
        for (int row : equations.velocity_rows()) rows_[row] /= g1_;
        equations.solve(force_, rows_);
        direction.multipliers -= rows_;
        MatrixX correction = force_;
        maps_.change(correction);
        y -= correction;
        return std::pair(correction.lpNorm<Eigen::Infinity>(),
                         direction.turn.lpNorm<Eigen::Infinity>() + h_ * direction.velocity.lpNorm<Eigen::Infinity>());
      });
      if (!solved) give_up(to);
      turned = y;
      maps_.turn(turned);
      x.turn.col(k) += turned;
      x.velocity.col(k) += g1_ * y;
      v_dot.col(k) = b1_ * y;
      a.col(k) += c_ * (1 - af_) * b1_ * y;
    }
  }

  void adjoint(LinearEquations& equations, const TakenStep& step, Variation& x, MatrixX& gradient) override {
    const State &from = step.from, &to = step.to;
    set_step(equations.layout(), from, to);
    equations.at(to);
    equations.factorize({1, g1_, b1_}, d_, true);
    MatrixX &v_dot = x.history[0], &a = x.history[1];
    const Eigen::Index wants = x.turn.cols();
    MatrixX mu_all = MatrixX::Zero(to.v.size(), wants), nu_all = MatrixX::Zero(equations.layout().row_count(), wants);
    LinearEquations::Pulled pulled;
    for (Eigen::Index k = 0; k < wants; ++k) {
      // What is wanted of the turn that solves the step: T⁻ᵀ (Tᵀ δq + γ/(hβ) δv + b₁ (δv̇ + c (1 - af) δa)).
      MatrixX wanted = g1_ * x.velocity.col(k) + b1_ * (v_dot.col(k) + c_ * (1 - af_) * a.col(k));
      maps_.change_transposed(wanted);
      wanted += x.turn.col(k);
      VectorX mu = VectorX::Zero(to.v.size()), nu = VectorX::Zero(nu_all.rows());
      bool first = true;
      const bool solved = refine([&] {
        force_ = wanted.col(0);
        rows_.setZero(nu.size());
        if (!first) {
          equations.pull(mu, nu, pulled);
          MatrixX moved = g1_ * pulled.velocity + b1_ * pulled.acceleration;
          maps_.change_transposed(moved);
          force_ -= pulled.turn + moved.col(0);
          rows_ = -pulled.rows;
        }
        first = false;
        equations.solve(force_, rows_);
        mu += force_;
        nu += rows_;
        return std::pair(largest(force_), largest(mu));
      });
      if (!solved) give_up(to);
      equations.pull(mu, nu, pulled);
      x.turn.col(k) -= pulled.turn;
      x.velocity.col(k) -= pulled.velocity;
      mu_all.col(k) = mu;
      nu_all.col(k) = nu;
    }
    equations.add_parameter_products(mu_all, nu_all, -1, gradient);
    // The known part of the step, transposed.
    MatrixX moved = x.turn;
    maps_.turn_transposed(moved);
    maps_.carry_transposed(x.turn);
    const MatrixX ahead = c_ * (h_ * h_ * beta_ * moved + h_ * gamma_ * x.velocity + a);
    v_dot = af_ * ahead;
    a = h_ * h_ * (0.5 - beta_) * moved + h_ * (1 - gamma_) * x.velocity - am_ * ahead;
    x.velocity += h_ * moved;
  }

  /// v̇ = A(t, q, v); and where start values are corrected, by the jerk j = (A(t + h, q ⊕ c, v + h v̇) - v̇)/h with
  /// c = h v + h²/2 v̇:   a = v̇ + (am - af) h j,   v' = v + h² y,   M y + Gᵀη = 0,   G (y - s) = 0,
  /// s = (1 - 6β - 3(am - af))/6 j + 1/12 (0, ω × ω̇, 0)
  void adjoint_start(LinearEquations& equations, const State& before, Variation& x, MatrixX& gradient) override {
    const Layout& layout = equations.layout();
    const double h = method_.parameters_.step, ahead = method_.am_ - method_.af_;
    MatrixX of_v_dot = x.history[0] + x.history[1];
    State state = before;
    equations.at(state);
    equations.accelerations(state.v_dot, state.lambda);
    if (method_.corrected_) {
      const double of_jerk = (1 - 6 * method_.beta_ - 3 * ahead) / 6;
      const VectorX c = h * state.v + 0.5 * h * h * state.v_dot;
      State then = state;
      then.time += h;
      layout.retract(state.q, c, then.q);
      then.v += h * state.v_dot;
      equations.at(then);
      equations.accelerations(then.v_dot, then.lambda);
      // The shift of v.
      VectorX s = of_jerk * (then.v_dot - state.v_dot) / h;
      for (const auto& b : layout.bodies())
        if (b.frame)
          s.segment<3>(b.v + 3) +=
              Vector3(state.v.segment<3>(b.v + 3)).cross(Vector3(state.v_dot.segment<3>(b.v + 3))) / 12;
      WeightedSum shift{.rows = WeightedSum::Rows::product, .forces = false, .a = {}, .l = {}, .u = {}};
      equations.at(state);
      shift_of(equations, s, shift.a, shift.l);
      shift.u = shift.a - s;
      MatrixX mu = h * h * x.velocity, nu = MatrixX::Zero(layout.row_count(), mu.cols());
      equations.solve_mass(mu, nu);
      // G (y - s) as what is wanted of s.
      MatrixX of_s = MatrixX::Zero(mu.rows(), mu.cols()), none = of_s;
      LinearEquations::Pulled pulled;
      for (Eigen::Index k = 0; k < mu.cols(); ++k) {
        equations.pull(VectorX::Zero(mu.rows()), nu.col(k), pulled);
        of_s.col(k) = pulled.turn;
      }
      MatrixX jerk = ahead * h * x.history[1] + of_jerk * of_s;
      equations.add_weighted(shift, mu, nu, -1, x.turn, none, gradient);
      for (const auto& b : layout.bodies())
        for (Eigen::Index k = 0; b.frame && k < mu.cols(); ++k) {
          const Vector3 w = state.v.segment<3>(b.v + 3), w_dot = state.v_dot.segment<3>(b.v + 3),
                        wanted = of_s.col(k).segment<3>(b.v + 3) / 12;
          x.velocity.col(k).segment<3>(b.v + 3) += w_dot.cross(wanted);
          of_v_dot.col(k).segment<3>(b.v + 3) += wanted.cross(w);
        }
      // The jerk.
      of_v_dot -= jerk / h;
      MatrixX turn = none, velocity = none;
      equations.at(then);
      equations.add_accelerations(jerk / h, turn, velocity, gradient);
      maps_.at(layout, c);
      MatrixX moved = turn;
      maps_.turn_transposed(moved);
      maps_.carry_transposed(turn);
      x.turn += turn;
      x.velocity += velocity + h * moved;
      of_v_dot += h * velocity + 0.5 * h * h * moved;
    }
    equations.at(state);
    equations.add_accelerations(of_v_dot, x.turn, x.velocity, gradient);
  }

 private:
  static double largest(const VectorX& x) { return x.size() > 0 ? x.lpNorm<Eigen::Infinity>() : 0; }
  /// M y + Gᵀη = 0, G y = G s.
  static void shift_of(LinearEquations& equations, const VectorX& s, VectorX& y, VectorX& eta) {
    LinearEquations::Pulled pulled;
    equations.pull(s, VectorX::Zero(equations.layout().row_count()), pulled);
    MatrixX force = MatrixX::Zero(s.size(), 1), rows = pulled.rows;
    equations.solve_mass(force, rows);
    y = force.col(0), eta = rows.col(0);
  }

  void set_step(const Layout& layout, const State& from, const State& to) {
    h_ = to.time - from.time;
    am_ = method_.am_, af_ = method_.af_, beta_ = method_.beta_, gamma_ = method_.gamma_;
    c_ = 1 / (1 - am_);
    b1_ = (1 - am_) / (h_ * h_ * beta_ * (1 - af_));
    g1_ = gamma_ / (h_ * beta_);
    d_.resize(to.v.size());
    layout.difference(from.q, to.q, d_);
    maps_.at(layout, d_);
  }

  const GeneralizedAlpha& method_;
  double h_ = 0, am_ = 0, af_ = 0, beta_ = 0, gamma_ = 0, c_ = 1, b1_ = 0, g1_ = 0;
  VectorX d_, force_, rows_, products_;
  MatrixX force_columns_, row_columns_;
  ChartMaps maps_;
};

/// To round-off.
class RepeatedAlpha final : public RepeatedStep {
 public:
  RepeatedAlpha(const GeneralizedAlpha& method, EquationsOfMotion& equations)
      : equations_(equations), method_(exact(method.parameters_), {method.am_, method.af_}) {}

  MatrixX history(const State& from, const StepRecord* record) const override {
    if (!record)
      throw SimulationError("the step from t = " + std::to_string(from.time) + " s left no record",
                            "generalized-alpha, derivative of a step", "give another step");
    MatrixX vectors(from.v.size(), 2);
    vectors << from.v_dot, static_cast<const AlphaRecord*>(record)->a;
    return vectors;
  }

  void take(const State& from, const StepRecord* record, MatrixX& history, State& to) override {
    start_ = from;
    if (method_.a_.size() == 0) {
      method_.start(equations_, start_);
      start_ = from;
    }
    start_.v_dot = history.col(0);
    method_.a_ = history.col(1);
    if (record && !restarted_) method_.h_offset_ = static_cast<const AlphaRecord*>(record)->h_offset;
    restarted_ = false;
    method_.steady_left_ = 0;
    const double h = to.time - from.time;
    method_.change_step(equations_, start_, h);
    if (method_.take(equations_, start_, to.time, h) != GeneralizedAlpha::Newton::converged)
      throw SimulationError("the step to t = " + std::to_string(to.time) + " s cannot be taken again nearby",
                            "generalized-alpha, derivative of a step", "look for what is not smooth there");
    to.q = method_.q_;
    to.v = method_.v_;
    history.col(1) = ((1 - method_.af_) * method_.v_dot_ + method_.af_ * start_.v_dot - method_.am_ * method_.a_) /
                     (1 - method_.am_);
    history.col(0) = method_.v_dot_;
    to.contacts = from.contacts;
    equations_.memory().track_contacts(to);
  }

  void restart(State& state, MatrixX& history) override {
    method_.start(equations_, state);
    history.col(0) = state.v_dot;
    history.col(1) = method_.a_;
    restarted_ = true;
  }

 private:
  static GeneralizedAlpha::Parameters exact(GeneralizedAlpha::Parameters parameters) {
    parameters.newton_tolerance = 1e-15;
    return parameters;
  }

  EquationsOfMotion& equations_;
  GeneralizedAlpha method_;
  State start_;
  bool restarted_ = false;
};

std::unique_ptr<StepDerivative> GeneralizedAlpha::step_derivative() const {
  if (parameters_.form != Form::index3 || !(parameters_.step > 0)) return nullptr;
  return std::make_unique<GeneralizedAlphaDerivative>(*this);
}

std::shared_ptr<const StepRecord> GeneralizedAlpha::step_record() const {
  if (offset_before_ == 0) return nullptr;
  auto record = std::make_shared<AlphaRecord>();
  record->a = a_before_;
  record->h_offset = offset_before_;
  return record;
}

std::unique_ptr<RepeatedStep> GeneralizedAlpha::repeated_step(EquationsOfMotion& equations) const {
  if (parameters_.form != Form::index3 || !(parameters_.step > 0)) return nullptr;
  return std::make_unique<RepeatedAlpha>(*this, equations);
}

}  // namespace lithe
