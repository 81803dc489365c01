#include "engine/base/error.h"
#include "engine/motion/chart_maps.h"
#include "integrators/radau.h"
#include "integrators/refinement.h"

namespace lithe {

namespace {

[[noreturn]] void refuse_step(double time, const std::string& why) {
  throw SimulationError("the step to t = " + std::to_string(time) + " s " + why, "Radau, derivative of a step",
                        "look for what is not smooth there, or give smaller steps or a smaller tolerance");
}

/// What Newton may leave of a step in a run. The first iterations are judged by rates that are none of theirs: some ten
/// times what its tolerance says or, of a share of the run's tolerance, this itself.
RepeatedStep::Rest left_by_newton(const Radau::Parameters& parameters, const State& from, const State& to) {
  constexpr double kMore = 10, kOfFixedSteps = 1e-9;
  const double h = to.time - from.time;
  double largest = parameters.newton_tolerance;
  if (largest == 0 && parameters.step > 0) largest = kOfFixedSteps;
  if (largest > 0) return {kMore * largest, kMore * largest / h};
  const Tolerance& t = parameters.tolerance;
  return {t.absolute + t.relative * to.q.lpNorm<Eigen::Infinity>(),
          t.absolute + t.relative * to.v.lpNorm<Eigen::Infinity>()};
}

class RepeatedRadau final : public RepeatedStep {
 public:
  RepeatedRadau(EquationsOfMotion& equations, const Radau::Parameters& parameters)
      : equations_(equations), parameters_(parameters) {}

  Rest left_by_iterations(const State& from, const State& to) const override {
    return left_by_newton(parameters_, from, to);
  }

  void take(const State& from, const StepRecord* record, MatrixX& /*history*/, State& to) override {
    if (!stages_.solve_again(equations_, from, to.time, to.time - from.time, dynamic_cast<const RadauRecord&>(*record)))
      refuse_step(to.time, "cannot be taken again nearby");
    to.q.resize(from.q.size());
    equations_.layout().retract(from.q, stages_.increment(), to.q);
    to.v = stages_.velocity();
    to.contacts = from.contacts;
    equations_.memory().track_contacts(to);
  }

 private:
  EquationsOfMotion& equations_;
  const Radau::Parameters parameters_;
  RadauStages stages_;
};

constexpr int kMostRefinements = 80;
constexpr double kSameEnd = 1e-9;       // m, rad: of a step and its record
constexpr double kSameSolution = 1e-6;  // m, rad: likewise solved to round-off, beside what Newton left in the run

}  // namespace

/// The step, equation by equation, backwards. With q_i = q_n ⊕ d_i, R = Jr⁻¹(d), and b_i the corrections of positions:
///   v_i = v_n + h Σ a_ij v̇_j,   d_i = h Σ a_ij R_j v_j + R_i b_i,   M v̇_i + Gᵀλ_i = f,   G v_i + ∂g/∂t = 0,
///   g(q_i) = 0,   S b_i + Gᵀy_i = 0 at the middle stage, S = s²M + sD + K.
/// With multipliers μ, κ, ν, ξ, ζ of dynamics, velocities, positions, d and b, the derivatives by v_i, q_i, v̇_j, d_j
/// and b_j are
///   p_i = Dᵀμ_i + Gᵀκ_i - R_iᵀΞ_i + [what is wanted of v'],   Ξ_i = h Σ a_ki ξ_k,
///   z_i = Kᵀμ_i + Ġᵀκ_i + Gᵀν_i + [what is wanted of q'],
///   M μ_j + h Σ a_ij p_i = 0,   T_jᵀz_j + ξ_j = (∂Rv/∂d)ᵀΞ_j + (∂Rb/∂d)ᵀξ_j,   G μ_j = 0,
///   Sᵀζ_j = R_jᵀξ_j,   G ζ_j = 0,   and at the middle stage the derivatives of Σ ζ_j · (S b_j + Gᵀy_j) besides.
/// Solved by corrections: with one M, D, K, G and R = 1 for all stages they fall apart in the eigenvectors of A⁻¹ into
/// a real and a complex system with Sᵀ, for μ and s κ + ν; what the last equation lacks is the correction of ν.
class RadauAdjoint final : public StepAdjoint {
 public:
  explicit RadauAdjoint(const Radau::Parameters& parameters) : parameters_(parameters) {}

  void adjoint(LinearEquations& equations, const TakenStep& step, Variation& x, MatrixX& gradient) override {
    begin(equations, step, x);
    const double s = method_.gamma_ / h_;
    const std::complex<double> c = method_.alpha_ / h_;
    equations.at(stages_[1]);
    find_corrections(equations, s);
    equations.factorize({1, s, s * s}, VectorX::Zero(step.from.v.size()), true);
    equations.factorize_complex({1.0, c, c * c});
    const bool solved = refine([&] { return correct(equations, x); }, kMostRefinements);
    if (!solved) refuse_step(step.to.time, "has an adjoint that was not found to 1e-6");
    for (int i = 0; i < 3; ++i) {
      equations.at(stages_[i]);
      equations.add_parameter_products(mu_[i], nu_[i], 1, gradient);
      MatrixX turn = MatrixX::Zero(x.turn.rows(), x.turn.cols()), velocity = turn;
      equations.add_rate_sums(kappa_[i], turn, velocity, gradient);
    }
    const MatrixX no_rows = MatrixX::Zero(equations.layout().row_count(), x.turn.cols());
    for (const Turning& turning : turning_)
      for (const bool ahead : {true, false}) {
        equations.at(ahead ? turning.ahead : turning.behind);
        equations.add_parameter_products(zeta_[turning.stage], no_rows, (ahead ? 0.5 : -0.5) / turning.moved, gradient);
      }
    x.turn = of_q_;
    x.velocity = of_v_;
  }

  void adjoint_start(LinearEquations&, const State&, Variation&, MatrixX&) override {}

 private:
  using Stages = std::array<MatrixX, 3>;

  /// Σ x_i w_ij.
  static Stages combine(const Stages& x, const Matrix3& w) {
    Stages out;
    for (int j = 0; j < 3; ++j) out[j] = w(0, j) * x[0] + w(1, j) * x[1] + w(2, j) * x[2];
    return out;
  }

  void begin(LinearEquations& equations, const TakenStep& step, const Variation& x) {
    const Layout& layout = equations.layout();
    const Eigen::Index n = x.turn.rows(), wants = x.turn.cols(), rows = layout.row_count();
    h_ = step.to.time - step.from.time;
    VectorX off(n), end(step.to.q.size()), rate(n);
    const auto is_end = [&](ConstVectorRef d, double tolerance) {
      layout.retract(step.from.q, d, end);
      layout.difference(end, step.to.q, off);
      return off.lpNorm<Eigen::Infinity>() <= tolerance;
    };
    const auto* taken = dynamic_cast<const RadauRecord*>(step.record);
    if (!taken || !is_end(taken->d.col(2), kSameEnd)) refuse_step(step.to.time, "is not one of the method");
    // To round-off: what Newton left of the step would be in its derivative, and in that of a step taken again not.
    equations.at(step.from);
    if (!solved_.solve_again(equations.equations(), step.from, step.to.time, h_, *taken))
      refuse_step(step.to.time, "cannot be taken again");
    const auto record = solved_.record();
    if (!is_end(record->d.col(2), kSameSolution + left_by_newton(parameters_, step.from, step.to).turn))
      refuse_step(step.to.time, "ends elsewhere when it is taken again");
    MatrixX rates(n, 3);
    for (int i = 0; i < 3; ++i) {
      State& state = stages_[i] = step.from;
      state.time = i == 2 ? step.to.time : step.from.time + method_.c_[i] * h_;
      layout.retract(step.from.q, record->d.col(i), state.q);
      state.v = record->v.col(i);
      state.v_dot = record->v_dot.col(i);
      state.lambda = record->lambda.col(i);
      d_[i] = record->d.col(i);
      maps_[i].at(layout, d_[i]);
      layout.chart_rates(d_[i], state.v, rate);
      rates.col(i) = rate;
      mu_[i].setZero(n, wants), kappa_[i].setZero(rows, wants), nu_[i].setZero(rows, wants);
      zeta_[i].setZero(n, wants);
    }
    const MatrixX corrections = record->d - h_ * rates * method_.A_.transpose();
    for (int i = 0; i < 3; ++i) {
      MatrixX b = corrections.col(i);
      maps_[i].turn(b);
      b_[i] = b;
    }
    of_q_.setZero(n, wants), of_v_.setZero(n, wants);
  }

  /// What turns as S b_i + Gᵀy_i, the derivative of r along these directions at the middle stage; none, where
  /// corrections of positions are next to round-off.
  void find_corrections(LinearEquations& equations, double s) {
    constexpr double kLeast = 1e-11, kSmall = 1e-8, kMoved = 1e-4;
    constexpr int kFew = 5;
    const Eigen::Index n = b_[0].size(), rows = equations.layout().row_count();
    const State& middle = stages_[1];
    turning_.clear();
    left_changes_ = kFew;
    LinearEquations::Pulled pulled;
    for (int i = 0; i < 3; ++i) {
      const double size = b_[i].lpNorm<Eigen::Infinity>();
      if (rows == 0 || !(size > kLeast)) continue;
      if (size > kSmall) left_changes_ = kMostRefinements;
      if (turning_.empty()) equations.factorize({1, s, s * s}, VectorX::Zero(n), false);
      equations.pull(b_[i], VectorX::Zero(rows), pulled);
      VectorX force = VectorX::Zero(n), push = pulled.rows;
      equations.solve(force, push);
      const auto beside = [](const VectorX& x, const VectorX& base) {
        return x.lpNorm<Eigen::Infinity>() / (1 + base.lpNorm<Eigen::Infinity>());
      };
      const VectorX velocity = s * b_[i], acceleration = s * velocity;
      const double moved = kMoved / std::max({size, beside(velocity, middle.v), beside(acceleration, middle.v_dot),
                                              beside(push, middle.lambda)});
      Turning& turning = turning_.emplace_back(Turning{i, moved, middle, middle});
      for (const double t : {moved, -moved}) {
        State& near = t > 0 ? turning.ahead : turning.behind;
        equations.layout().retract(middle.q, t * b_[i], near.q);
        near.v += t * velocity, near.v_dot += t * acceleration, near.lambda += t * push;
      }
    }
  }

  /// Of the sums ζ_i · (S b_i + Gᵀy_i), by the symmetry of second derivatives, where directions turn with the bodies.
  /// Where they are small those of the first refinements do.
  void find_changes(LinearEquations& equations) {
    if (turning_.empty() || left_changes_-- <= 0) return;
    const Eigen::Index n = mu_[0].rows(), rows = nu_[0].rows(), wants = mu_[0].cols();
    of_middle_ = {MatrixX::Zero(n, wants), MatrixX::Zero(n, wants), MatrixX::Zero(n, wants),
                  MatrixX::Zero(rows, wants)};
    const VectorX no_rows = VectorX::Zero(rows);
    LinearEquations::Pulled pulled;
    for (const Turning& turning : turning_) {
      for (const bool ahead : {true, false}) {
        equations.at(ahead ? turning.ahead : turning.behind);
        const double weight = (ahead ? 0.5 : -0.5) / turning.moved;
        for (Eigen::Index k = 0; k < wants; ++k) {
          equations.pull(zeta_[turning.stage].col(k), no_rows, pulled);
          of_middle_.turn.col(k) += weight * pulled.turn, of_middle_.velocity.col(k) += weight * pulled.velocity;
          of_middle_.acceleration.col(k) += weight * pulled.acceleration,
              of_middle_.rows.col(k) += weight * pulled.rows;
        }
      }
      equations.at(stages_[1]);
      for (Eigen::Index k = 0; k < wants; ++k) {
        equations.pull(zeta_[turning.stage].col(k), no_rows, pulled);
        for (const auto& body : equations.layout().bodies())
          if (body.frame)
            of_middle_.turn.col(k).segment<3>(body.v + 3) +=
                Vector3(b_[turning.stage].segment<3>(body.v + 3)).cross(Vector3(pulled.turn.segment<3>(body.v + 3)));
      }
    }
  }

  /// What the equations lack, and a correction by it. Leaves what is wanted of q_n and v_n as it was before.
  std::pair<double, double> correct(LinearEquations& equations, const Variation& x) {
    const Layout& layout = equations.layout();
    const Eigen::Index n = x.turn.rows(), wants = x.turn.cols(), rows = layout.row_count();
    Stages z, p, M, G, theta;
    LinearEquations::Pulled pulled;
    MatrixX no_gradient(0, wants);
    for (int i = 0; i < 3; ++i) {
      equations.at(stages_[i]);
      for (MatrixX* m : {&z[i], &p[i], &M[i]}) m->resize(n, wants);
      G[i].resize(rows, wants);
      for (Eigen::Index k = 0; k < wants; ++k) {
        equations.pull(mu_[i].col(k), nu_[i].col(k), pulled);
        z[i].col(k) = pulled.turn, p[i].col(k) = pulled.velocity, M[i].col(k) = pulled.acceleration;
        G[i].col(k) = pulled.rows;
      }
      equations.add_rate_sums(kappa_[i], z[i], p[i], no_gradient);
    }
    find_changes(equations);
    if (!turning_.empty())
      z[1] += of_middle_.turn, p[1] += of_middle_.velocity, M[1] += of_middle_.acceleration, G[1] += of_middle_.rows;
    z[2] += x.turn;
    p[2] += x.velocity;
    // ξ of the d_j, in passes: turns within a step are small.
    Stages turned = z, xi, pulled_back;
    for (int i = 0; i < 3; ++i) maps_[i].turn_transposed(turned[i]), xi[i] = -turned[i];
    for (int pass = 0; pass < kMostRefinements; ++pass) {
      pulled_back = combine(xi, h_ * method_.A_);
      double change = 0, size = 0;
      for (int i = 0; i < 3; ++i) {
        MatrixX of_d = -turned[i], of_v = MatrixX::Zero(n, wants), unused = of_v;
        add_chart_rate_products(layout, d_[i], b_[i], xi[i], of_d, unused);
        add_chart_rate_products(layout, d_[i], stages_[i].v, pulled_back[i], of_d, of_v);
        change = std::max(change, (of_d - xi[i]).lpNorm<Eigen::Infinity>());
        size = std::max(size, of_d.lpNorm<Eigen::Infinity>());
        xi[i] = of_d;
        pulled_back[i] = of_v;
      }
      if (!(change > 1e-16 * size)) break;
    }
    MatrixX of_q = MatrixX::Zero(n, wants), of_v = of_q;
    for (int i = 0; i < 3; ++i) {
      p[i] -= pulled_back[i];
      of_v += p[i];
      maps_[i].carry_transposed(z[i]);
      of_q += z[i];
    }
    const double change = std::max((of_q - of_q_).lpNorm<Eigen::Infinity>(), (of_v - of_v_).lpNorm<Eigen::Infinity>());
    const double size = std::max(of_q.lpNorm<Eigen::Infinity>(), of_v.lpNorm<Eigen::Infinity>());
    of_q_ = of_q, of_v_ = of_v;
    // What ν lacks, at the middle stage.
    VectorX force, row;
    for (int i = 0; i < 3; ++i) {
      maps_[i].change_transposed(xi[i]);
      theta[i].resize(rows, wants);
      for (Eigen::Index k = 0; k < wants; ++k) {
        force = xi[i].col(k), row.setZero(rows);
        equations.solve(force, row);
        theta[i].col(k) = row;
        zeta_[i].col(k) = force;
      }
    }
    // μ and s κ + ν in the eigenvectors.
    Stages lacking = combine(p, h_ * method_.A_);
    for (int i = 0; i < 3; ++i) lacking[i] += M[i];
    lacking = combine(lacking, -method_.T_);
    Stages of_rows = combine(G, -method_.T_);
    const double s = method_.gamma_ / h_;
    const std::complex<double> c = method_.alpha_ / h_, imaginary(0, 1);
    for (Eigen::Index k = 0; k < wants; ++k) {
      force = s * s * lacking[0].col(k), row = of_rows[0].col(k);
      equations.solve(force, row);
      lacking[0].col(k) = force, of_rows[0].col(k) = row;
      ComplexVectorX both = c * c * (lacking[1].col(k) - imaginary * lacking[2].col(k)),
                     both_rows = of_rows[1].col(k) - imaginary * of_rows[2].col(k);
      equations.solve_complex(both, both_rows);
      lacking[1].col(k) = both.real(), lacking[2].col(k) = -both.imag();
      of_rows[1].col(k) = both_rows.real(), of_rows[2].col(k) = -both_rows.imag();
    }
    lacking = combine(lacking, method_.T_inverse_);
    of_rows = combine(of_rows, method_.T_inverse_);
    for (int i = 0; i < 3; ++i) {
      mu_[i] += lacking[i];
      nu_[i] += theta[i];
      of_rows[i] -= theta[i];
    }
    of_rows = combine(of_rows, h_ * method_.A_);
    for (int i = 0; i < 3; ++i) kappa_[i] += of_rows[i];
    return {change, size};
  }

  const Radau::Parameters parameters_;
  const RadauStages method_;
  RadauStages solved_;
  double h_ = 0;
  std::array<State, 3> stages_;
  std::array<VectorX, 3> d_, b_;
  std::array<ChartMaps, 3> maps_;
  Stages mu_, kappa_, nu_, zeta_;
  struct Turning {
    int stage;
    double moved;  // of the directions of its correction
    State ahead, behind;
  };
  std::vector<Turning> turning_;
  struct {
    MatrixX turn, velocity, acceleration, rows;
  } of_middle_;
  int left_changes_ = 0;  // of of_middle_, in the present step
  MatrixX of_q_, of_v_;
};

std::unique_ptr<RepeatedStep> Radau::repeated_step(EquationsOfMotion& equations) const {
  return std::make_unique<RepeatedRadau>(equations, parameters_);
}

std::unique_ptr<StepAdjoint> Radau::step_adjoint() const { return std::make_unique<RadauAdjoint>(parameters_); }

}  // namespace lithe
