#include "integrators/generalized_alpha.h"

#include <algorithm>
#include <array>

#include "engine/archive/archive.h"
#include "engine/base/checks.h"
#include "engine/base/error.h"
#include "engine/base/lane_rotations.h"
#include "engine/motion/share_bodies.h"

namespace lithe {
namespace {

constexpr int kMaxNewton = 10;
constexpr int kMany = 32;              // linear coordinates of a body, from which on loops of their own are faster
constexpr int kMaxSplits = 12;         // a step that will not converge is halved that often
constexpr int kSteadySteps = 50;       // that a steady prediction goes first where the other failed
constexpr double kLargestGrowth = 10;  // of a step, by which offsets may be scaled

GeneralizedAlpha::Coefficients coefficients(double rho) {
  if (!(rho >= 0 && rho < 1))
    throw SceneError("spectral_radius is " + std::to_string(rho), "GeneralizedAlpha",
                     "give 0 <= rho < 1; 0.8 to 0.9 keeps energy well, 1 leaves algebraic modes undamped");
  return {(2 * rho - 1) / (rho + 1), rho / (rho + 1)};
}

}  // namespace

GeneralizedAlpha::GeneralizedAlpha(Parameters parameters)
    : GeneralizedAlpha(parameters, coefficients(parameters.spectral_radius)) {}

GeneralizedAlpha::GeneralizedAlpha(Parameters parameters, Coefficients coefficients)
    : parameters_(parameters), am_(coefficients.am), af_(coefficients.af) {
  require::at("GeneralizedAlpha", [&] {
    require::not_negative(parameters.step, "step");
    require::not_negative(parameters.first_step, "first_step");
    require::not_negative(parameters.max_step, "max_step");
    require::not_negative(parameters.newton_tolerance, "newton_tolerance");
    require::positive(parameters.tolerance.relative + parameters.tolerance.absolute, "tolerance");
  });
  gamma_ = 0.5 + af_ - am_;
  beta_ = 0.25 * (gamma_ + 0.5) * (gamma_ + 0.5);
}

std::string GeneralizedAlpha::name() const {
  return parameters_.form == Form::index3 ? "generalized-alpha, index 3" : "generalized-alpha, stabilized index 2";
}

void GeneralizedAlpha::prepare(EquationsOfMotion& equations, State& state) {
  const int nv = equations.layout().v_count(), rows = equations.layout().row_count();
  if (!resumes()) statistics_ = {}, steady_left_ = 0;
  for (VectorX* x : {&a_, &a_before_, &v_, &v_dot_, &d_, &v_dot_last_, &jerk_, &delta_, &change_, &rv_, &magnitudes_})
    x->setZero(nv);
  for (VectorX* x : {&lambda_, &rl_, &rl2_}) x->setZero(rows);
  projector_.emplace(equations);
  restart(equations, state);
}

void GeneralizedAlpha::restart(EquationsOfMotion& equations, State& state, const VectorX* drift) {
  const int nv = equations.layout().v_count(), rows = equations.layout().row_count();
  q_ = state.q;
  if (state.v_dot.size() != nv) state.v_dot.setZero(nv);
  if (state.lambda.size() != rows) state.lambda.setZero(rows);
  projector_->accelerations(state.time, state.q, state.v, state.v_dot, state.lambda);
  h_ = parameters_.step > 0 ? parameters_.step : first_step(state);
  begin(equations, state, h_);
  if (drift) a_ += h_ * *drift;
}

/// Start values for steps of h from consistent v̇: a₀ = v̇₀ + (am - af) h v̈₀ and the shift of v₀ that spares the
/// multipliers of index 3 their first-order transient (docs/equations.md 8.1).
void GeneralizedAlpha::begin(EquationsOfMotion& equations, State& state, double h) {
  a_ = state.v_dot;
  h_offset_ = h;
  has_last_ = corrected_ = false;
  if (parameters_.form != Form::index3 || !parameters_.correct_start || lambda_.size() == 0) return;
  // The jerk by one difference along the motion.
  const auto find_jerk = [&](double ahead) -> VectorX {
    change_ = ahead * state.v + 0.5 * ahead * ahead * state.v_dot;
    equations.layout().retract(state.q, change_, q_);
    v_ = state.v + ahead * state.v_dot;
    projector_->accelerations(state.time + ahead, q_, v_, v_dot_, lambda_);
    return (v_dot_ - state.v_dot) / ahead;
  };
  jerk_ = find_jerk(h);
  // Not where stiff modes make it: a slender body's nodes, moved on by a long step, would be torn back by what no step
  // resolves, and that would be taken for the motion.
  const double size = jerk_.lpNorm<Eigen::Infinity>();
  if (h * size > state.v_dot.lpNorm<Eigen::Infinity>() &&
      (find_jerk(0.1 * h) - jerk_).lpNorm<Eigen::Infinity>() > 0.5 * size)
    return;
  corrected_ = true;
  a_ += (am_ - af_) * h * jerk_;
  shift_velocity(equations, state, h * h);
}

double GeneralizedAlpha::first_step(const State& state) const {
  if (parameters_.first_step > 0) return parameters_.first_step;
  // A step that moves every coordinate by less than a thousandth of its magnitude.
  const double speed = state.v.cwiseAbs().maxCoeff(), pull = state.v_dot.cwiseAbs().maxCoeff();
  double h = 1e-3;
  if (speed > 0) h = std::min(h, 1e-2 / speed);
  if (pull > 0) h = std::min(h, std::sqrt(1e-3 / pull));
  return parameters_.max_step > 0 ? std::min(h, parameters_.max_step) : h;
}

/// v += h² M⁻¹Gᵀ(G M⁻¹Gᵀ)⁻¹ G ((1 - 6β - 3(am - af))/6 v̈ + 1/12 (0, ω × ω̇, 0))
void GeneralizedAlpha::shift_velocity(EquationsOfMotion& equations, State& state, double h_squared) {
  change_ = (1 - 6 * beta_ - 3 * (am_ - af_)) / 6 * jerk_;
  for (const auto& b : equations.layout().bodies())
    if (b.frame) change_.segment<3>(b.v + 3) += state.v.segment<3>(b.v + 3).cross(state.v_dot.segment<3>(b.v + 3)) / 12;
  rv_.setZero();
  equations.evaluate(state.time, state.q, rv_, Level::velocity);
  equations.constraint(Level::velocity, rl2_);
  equations.evaluate(state.time, state.q, change_, Level::velocity);
  equations.constraint(Level::velocity, rl_);
  rl_ -= rl2_;
  for (int row : equations.velocity_rows()) rl_[row] = 0;  // velocity rows hold exactly
  equations.factorize({0, 0, 1}, state.v_dot, state.lambda, nullptr);
  equations.solve(rv_, rl_);
  state.v += h_squared * rv_;
}

/// A new step size: the acceleration-like state sits (am - af) h beside v̇ and moves with h; in index 3 the velocity
/// sits h² beside G v + ∂g/∂t = 0 and moves with h². Without this the multipliers fall to first order (stability
/// laboratory S30); with the offset predicted from v̈ instead of measured, alternating steps blow up. After a sliver
/// (t_stop just ahead) both offsets are round-off, and the method begins anew.
void GeneralizedAlpha::change_step(EquationsOfMotion& equations, State& state, double h) {
  const double ratio = h / h_offset_;
  if (std::abs(ratio - 1) < 1e-9) return;
  if (offset_before_ == 0) a_before_ = a_, offset_before_ = h_offset_;
  if (ratio > kLargestGrowth) {
    projector_->accelerations(state.time, state.q, state.v, state.v_dot, state.lambda);
    return begin(equations, state, h);
  }
  a_ = state.v_dot + (a_ - state.v_dot) * ratio;
  h_offset_ = h;
  if (parameters_.form != Form::index3 || rl_.size() == 0) return;
  equations.evaluate(state.time, state.q, state.v, Level::velocity);
  equations.constraint(Level::velocity, rl_);
  rl_ *= ratio * ratio - 1;
  rv_.setZero();
  equations.factorize({0, 0, 1}, state.v_dot, state.lambda, nullptr);
  equations.solve(rv_, rl_);
  state.v += rv_;
}

double GeneralizedAlpha::natural_step(const State& state, double t_stop) const {
  const double left = t_stop - state.time;
  const double count = std::ceil(left / h_ - 1e-9);
  if (count <= 1) return left;
  if (parameters_.step == 0) return std::min(h_, left / 2);  // no sliver at the end
  return std::abs(count * h_ - left) > 1e-9 * left ? left / count : h_;
}

/// The old acceleration goes on; with it two Newton iterations are enough on smooth motion. Steady: the old velocity
/// does, d = h v; a worse guess of the motion, but a better one of what accelerations from step to step do not resolve,
/// such as the stretch of a cable's short elements, whose tension makes the tangent.
void GeneralizedAlpha::predict(EquationsOfMotion& equations, const State& state, double h, bool steady) {
  lambda_ = state.lambda;
  const double scale = 1 / (1 - am_);
  const Layout& layout = equations.layout();
  share_bodies(layout, equations.facts().team, [&](int, int first, int last) {
    for (int i = velocity_at(layout, first), end = velocity_at(layout, last); i < end; ++i) {
      const double a = a_[i];
      const double next = steady ? (1 - 0.5 / beta_) * a : scale * (state.v_dot[i] - am_ * a);  // a'
      v_dot_[i] = steady ? ((1 - am_) * next + am_ * a - af_ * state.v_dot[i]) / (1 - af_) : state.v_dot[i];
      d_[i] = h * state.v[i] + h * h * ((0.5 - beta_) * a + beta_ * next);
      v_[i] = state.v[i] + h * ((1 - gamma_) * a + gamma_ * next);
    }
    layout.retract(first, last, state.q, d_, q_);
  });
}

/// With the prediction that serves at present; where it fails with a fixed step, once more with the other one.
GeneralizedAlpha::Newton GeneralizedAlpha::take(EquationsOfMotion& equations, const State& state, double time,
                                                double h) {
  const bool steady = steady_left_ > 0;
  predict(equations, state, h, steady);
  Newton newton = solve(equations, state, time, h);
  if (steady) --steady_left_;
  if (newton == Newton::converged || parameters_.step == 0) return newton;
  predict(equations, state, h, !steady);
  newton = solve(equations, state, time, h);
  steady_left_ = newton == Newton::converged && !steady ? kSteadySteps : 0;
  return newton;
}

/// Takes the Newton correction -rv_ over: d, v, v̇ and q, body by body in one pass over memory. The size of the largest
/// entry of the chart's change; not finite if one is not.
double GeneralizedAlpha::correct(EquationsOfMotion& equations, const VectorX& q_start, double of_v, double of_v_dot) {
  std::array<double, kMostRanges> sizes{};
  share_bodies(equations.layout(), equations.facts().team, [&](int range, int first, int last) {
    sizes[range] = correct(equations.layout(), first, last, q_start, of_v, of_v_dot);
  });
  double size = 0, finite = 0;
  for (double of_range : sizes) size = std::max(size, of_range), finite += 0 * of_range;
  return size + finite;
}

double GeneralizedAlpha::correct(const Layout& layout, int first, int last, const VectorX& q_start, double of_v,
                                 double of_v_dot) {
  using lanes::load3;
  using lanes::store3;
  double *d = d_.data(), *v = v_.data(), *v_dot = v_dot_.data(), *q = q_.data(), *delta = delta_.data();
  const double *x = rv_.data(), *q0 = q_start.data();
  double size = 0, finite = 0;
  Lanes sizes = lanes::none(), all_finite = lanes::none();
  const auto take3 = [&](int i, const Lanes& change) {
    const Lanes moved = load3(d + i) + change, opposite = -change, absolute = change > opposite ? change : opposite;
    store3(change, delta + i);
    store3(moved, d + i);
    store3(load3(v + i) + of_v * change, v + i);
    store3(load3(v_dot + i) + of_v_dot * change, v_dot + i);
    sizes = absolute > sizes ? absolute : sizes;
    all_finite += 0.0 * change;
    return moved;
  };
  for (int body = first; body < last; ++body) {
    const Layout::BodySlice& b = layout.bodies()[body];
    int iq = b.q, iv = b.v;
    if (b.frame) {
      const Lanes turn = -lanes::chart_rate(load3(d + iv + 3), load3(x + iv + 3));
      store3(load3(q0 + iq) + take3(iv, -load3(x + iv)), q + iq);
      lanes::store4(lanes::rotated(lanes::load4(q0 + iq + 3), take3(iv + 3, turn)), q + iq + 3);
      iq += 7, iv += 6;
    }
    if (b.linear < kMany) {
      for (int i = 0; i < b.linear; ++i) {
        const double change = -x[iv + i];
        delta[iv + i] = change;
        d[iv + i] += change;
        v[iv + i] += of_v * change;
        v_dot[iv + i] += of_v_dot * change;
        size = std::max(size, std::abs(change));
        finite += 0 * change;
        q[iq + i] = q0[iq + i] + d[iv + i];
      }
      continue;
    }
    const auto at = [&](VectorX& of) { return of.segment(iv, b.linear); };
    auto change = at(delta_);
    change = -at(rv_);
    at(d_) += change;
    at(v_) += of_v * change;
    at(v_dot_) += of_v_dot * change;
    q_.segment(iq, b.linear) = q_start.segment(iq, b.linear) + at(d_);
    size = std::max(size, change.cwiseAbs().maxCoeff());
    finite += 0 * change.sum();
  }
  return std::max({size, sizes[0], sizes[1], sizes[2]}) + finite + lanes::sum(all_finite);
}

GeneralizedAlpha::Newton GeneralizedAlpha::solve(EquationsOfMotion& equations, const State& start, double time,
                                                 double h) {
  const double b1 = (1 - am_) / (h * h * beta_ * (1 - af_)), g1 = gamma_ / (h * beta_);
  const bool stabilized = parameters_.form == Form::stabilized_index2;
  double tolerance = parameters_.newton_tolerance;
  if (tolerance == 0) {
    const auto& t = parameters_.tolerance;
    tolerance = parameters_.step > 0 ? 1e-9 : 1e-2 * (t.absolute + t.relative * 1e-2);
  }
  double last = 0;
  bool slow = true;  // the factor is to be made anew: at the start, and where corrections shrink too slowly
  for (int k = 0; k < kMaxNewton; ++k) {
    equations.evaluate(time, q_, v_, Level::velocity);
    ++statistics_.evaluations;
    equations.residual(v_dot_, lambda_, rv_);
    const bool fresh = slow;
    if (fresh) {
      equations.factorize({1, g1, b1}, v_dot_, lambda_, &d_);
      ++statistics_.factorizations;
    }
    equations.constraint(Level::position, rl_);
    double size;
    const std::vector<int>& rolling = equations.velocity_rows();
    if (!stabilized) {
      if (!rolling.empty()) equations.constraint(Level::velocity, rl2_);
      for (int row : rolling) rl_[row] = rl2_[row] / g1;  // their increment is that of the velocity
      equations.solve(rv_, rl_);
      lambda_ -= rl_;
      size = correct(equations, start.q, g1, b1);
    } else {
      rv_ = -rv_;
      // Velocities first: G v' + ∂g/∂t = 0; then positions alone, along the same factor: g(q') = 0.
      equations.constraint(Level::velocity, rl2_);
      rl2_ /= -g1;
      rl_ = -rl_ - rl2_;
      for (int row : rolling) rl_[row] = 0;
      equations.solve(rv_, rl2_);
      lambda_ += rl2_;
      equations.layout().chart_rates(d_, rv_, delta_);
      v_ += g1 * delta_;
      v_dot_ += b1 * delta_;
      size = delta_.cwiseAbs().maxCoeff();
      change_.setZero();
      equations.solve(change_, rl_);
      rv_ += change_;
      equations.layout().chart_rates(d_, rv_, delta_);
      d_ += delta_;
      size = std::max(size, delta_.cwiseAbs().maxCoeff());
    }
    ++statistics_.newton_iterations;
    if (!std::isfinite(size) || (stabilized && !delta_.allFinite())) return Newton::failed;
    if (stabilized) equations.layout().retract(start.q, d_, q_);
    if (size <= tolerance) return Newton::converged;
    const double rate = k > 0 ? size / last : 0;
    if (rate > 2 && fresh) return Newton::failed;
    slow = rate > 0.3;
    // Round-off: corrections no longer shrink and are tiny beside the coordinates.
    if (slow && size <= 1e-13 * (1 + q_.cwiseAbs().maxCoeff())) return Newton::converged;
    last = size;
  }
  return Newton::slow;
}

double GeneralizedAlpha::error(const Layout& layout, const State& state, double h) {
  const double delta = am_ - af_;
  const double cq = (1 - 6 * beta_ - 3 * delta) / 6, cv = -1.0 / 12 + delta * (0.5 - am_ + delta);
  change_ = cq * h * h * (v_dot_ - state.v_dot);
  // for rotations also 1/12 h³ ω × ω̇
  for (const auto& b : layout.bodies())
    if (b.frame)
      change_.segment<3>(b.v + 3) += h * h * h / 12 * v_.segment<3>(b.v + 3).cross(v_dot_.segment<3>(b.v + 3));
  layout.magnitudes(q_, magnitudes_);
  double ratio = error_ratio(change_, magnitudes_, parameters_.tolerance);
  if (has_last_) {
    change_ = cv * h * h * (v_dot_ - state.v_dot - (h / h_last_) * (state.v_dot - v_dot_last_));
    magnitudes_ = h * v_.cwiseAbs();
    ratio = std::max(ratio, error_ratio(change_, magnitudes_, parameters_.tolerance));
  }
  return ratio;
}

bool GeneralizedAlpha::keep(Archive& archive, EquationsOfMotion& /*equations*/, const State& /*state*/) {
  archive.same("step", parameters_.step);
  archive.same("first_step", parameters_.first_step);
  archive.same("max_step", parameters_.max_step);
  archive.same("newton_tolerance", parameters_.newton_tolerance);
  archive.same("relative tolerance", parameters_.tolerance.relative);
  archive.same("absolute tolerance", parameters_.tolerance.absolute);
  archive.same("am", am_);
  archive.same("af", af_);
  archive.same("correct_start", parameters_.correct_start);
  archive("statistics", statistics_);
  archive("h", h_);
  archive("h_offset", h_offset_);
  archive("h_last", h_last_);
  archive("has_last", has_last_);
  archive("steady_left", steady_left_);
  archive("a", a_);
  archive("v_dot_last", v_dot_last_);
  archive("lambda", lambda_);  // where begin() looks for reactions first
  return true;
}

/// a' from v̇' by the method's own relation.
void GeneralizedAlpha::take_over(EquationsOfMotion& equations, const State& state) {
  const double scale = 1 / (1 - am_);
  const Layout& layout = equations.layout();
  share_bodies(layout, equations.facts().team, [&](int, int first, int last) {
    for (int i = velocity_at(layout, first), end = velocity_at(layout, last); i < end; ++i)
      a_[i] = scale * ((1 - af_) * v_dot_[i] + af_ * state.v_dot[i] - am_ * a_[i]);
  });
}

StepResult GeneralizedAlpha::advance(EquationsOfMotion& equations, State& state, double t_stop) {
  if (!(t_stop > state.time)) return {};
  const bool automatic = parameters_.step == 0;
  double h = natural_step(state, t_stop);
  offset_before_ = 0;
  for (int attempt = 0;; ++attempt) {
    change_step(equations, state, h);
    const bool last = std::abs(state.time + h - t_stop) < 1e-9 * h;
    const double time = last ? t_stop : state.time + h;
    const Newton newton = take(equations, state, time, h);
    double ratio = 0;
    if (newton == Newton::converged && automatic) ratio = error(equations.layout(), state, h);
    if (newton == Newton::converged && !(ratio > 1)) {
      take_over(equations, state);
      v_dot_last_.swap(state.v_dot);
      has_last_ = true;
      h_last_ = h;
      state.time = time;
      // Scratch and state change places: both are written anew before they are read.
      state.q.swap(q_);
      state.v.swap(v_);
      state.v_dot.swap(v_dot_);
      state.lambda.swap(lambda_);
      ++statistics_.steps;
      if (automatic) {
        const double grow = std::clamp(0.9 / std::cbrt(std::max(ratio, 1e-6)), 0.5, 2.0);
        // Small changes are not worth a new acceleration-like state.
        if (!last || h >= 0.999 * h_) h_ = grow > 1.2 || grow < 0.95 ? h * grow : h;
        if (parameters_.max_step > 0) h_ = std::min(h_, parameters_.max_step);
      } else if (attempt == 0) {
        h_ = parameters_.step;
      }
      return {};
    }
    ++statistics_.rejected;
    if (attempt >= kMaxSplits) {
      Eigen::Index worst = 0;
      delta_.cwiseAbs().maxCoeff(&worst);
      StepResult failed;
      failed.outcome = StepResult::Outcome::failed;
      failed.why = (newton == Newton::converged ? "the local error stays above the tolerance at steps of "
                                                : "Newton does not converge at steps of ") +
                   step_text(h) + "; largest correction in " +
                   equations.layout().velocity_name(static_cast<int>(worst));
      return failed;
    }
    h *= newton == Newton::converged ? std::clamp(0.9 / std::cbrt(ratio), 0.2, 0.7) : 0.5;
    if (automatic) h_ = h;
  }
}

}  // namespace lithe
