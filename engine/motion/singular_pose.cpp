#include "engine/motion/singular_pose.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace lithe {
namespace {

constexpr int kMost = 4;  // nodes

/// Nodes of Gauss on (0, 1), with the weights of the stages and of the end; exact to order 2 n.
struct Gauss {
  int n;
  std::array<double, kMost> c{}, b{};
  std::array<std::array<double, kMost>, kMost> a{};

  explicit Gauss(std::initializer_list<double> of_interval) : n(static_cast<int>(of_interval.size())) {
    int i = 0;
    for (double x : of_interval) c[i++] = (1 + x) / 2;
    // Integrals of Lagrange's polynomials, by their coefficients.
    for (int j = 0; j < n; ++j) {
      std::array<double, kMost + 1> p{1};
      for (int k = 0, degree = 0; k < n; ++k) {
        if (k == j) continue;
        for (int m = ++degree; m >= 0; --m) p[m] = ((m > 0 ? p[m - 1] : 0) - c[k] * p[m]) / (c[j] - c[k]);
      }
      const auto integral = [&](double x) {
        double sum = 0;
        for (int m = n - 1; m >= 0; --m) sum = (sum + p[m] / (m + 1)) * x;
        return sum;
      };
      for (int k = 0; k < n; ++k) a[k][j] = integral(c[k]);
      b[j] = integral(1);
    }
  }

  double distance(double x) const {
    double least = 1;
    for (int i = 0; i < n; ++i) least = std::min(least, std::abs(c[i] - x));
    return least;
  }
};

/// Of most nodes, none of which is near to the fraction x of the step.
const Gauss& choose(double x) {
  constexpr double kAway = 0.1;
  static const Gauss rules[] = {Gauss{-0.8611363115940526, -0.3399810435848563, 0.3399810435848563, 0.8611363115940526},
                                Gauss{-0.7745966692414834, 0, 0.7745966692414834},
                                Gauss{-0.5773502691896258, 0.5773502691896258}};
  for (const Gauss& rule : rules)
    if (rule.distance(x) > kAway) return rule;
  return rules[2];
}

/// Anything without a pattern; the same each time.
double any(int i) { return 1.5 + std::sin(1 + 2.4 * i + 0.37 * std::sin(5.1 * i)); }

}  // namespace

SingularPose::SingularPose(EquationsOfMotion& equations) : equations_(equations), projector_(equations) {
  const Layout& layout = equations.layout();
  for (VectorX* x : {&d_, &v_, &watched_}) x->setZero(layout.v_count());
  for (VectorX* x : {&rows_, &probe_}) x->setZero(layout.row_count());
  q_.setZero(layout.q_count());
  for (int i = 0; i < probe_.size(); ++i) probe_[i] = any(i + 7) * (i % 3 ? 1 : -1);
}

/// 1/(c·x) with G x = b, b and c arbitrary, at the pose that lies `later` on the way: a smooth function of time with a
/// simple zero where G loses a rank.
double SingularPose::nearness(const State& state, double later) {
  const Layout& layout = equations_.layout();
  equations_.memory().recall_rows(left_out_);  // at the pose itself no choice can be told from another
  d_ = later * state.v + 0.5 * later * later * state.v_dot;
  layout.retract(state.q, d_, q_);
  v_.setZero();
  equations_.evaluate(state.time + later, q_, v_, Level::velocity);
  rows_.setZero();
  equations_.factorize({0, 0, 1}, v_, rows_, nullptr);
  rows_ = probe_;
  equations_.solve(v_, rows_);
  return 1 / watched_.dot(v_);
}

std::optional<double> SingularPose::find(const State& state, double step, double reach) {
  constexpr int kSamples = 20;
  if (rows_.size() == 0 || equations_.parts().rigid_contacts || state.v_dot.size() != d_.size()) return {};
  equations_.memory().track_rows(left_out_);
  // Where the way bends, or a pole lies near, secants from afar lead out: again from nearer, watching another sum, and
  // from between changes of sign.
  std::optional<double> found;
  for (int seed : {0, 11}) {
    for (int i = 0; i < watched_.size(); ++i) watched_[i] = any(i + seed) * (i % 2 ? 1 : -1);
    for (double first : {step, step / 8, step / 64})
      if (!found) found = search(state, step, 0, first, reach);
  }
  double before = -step, value = found ? 0 : nearness(state, before);
  for (int i = 1; i <= kSamples && !found; ++i) {
    const double next = (-1 + 5.0 * i / kSamples) * step, value_next = nearness(state, next);
    if (value * value_next < 0) found = search(state, step, before, next, reach);
    before = next, value = value_next;
  }
  equations_.memory().recall_rows(left_out_);
  return found;
}

/// A zero by secants, from two times on.
std::optional<double> SingularPose::search(const State& state, double step, double from, double to, double reach) {
  constexpr int kSecants = 8;
  constexpr double kSmall = 1e-3, kNear = 1e-3, kEven = 0.3;
  const double now = nearness(state, from);
  double before = from, ahead = to, value_before = now, value = nearness(state, to);
  for (int k = 0; k < kSecants && std::abs(value) > kSmall * std::abs(now); ++k) {
    const double next = ahead - value * (ahead - before) / (value - value_before);
    if (!(next > -step) || !(next < reach)) return {};  // or not finite
    const bool between = (next - before) * (next - ahead) < 0;
    const double least = std::min(std::abs(value), std::abs(value_before));
    before = ahead, value_before = value;
    ahead = next;
    // At the pose itself rows give way, and the sum means nothing: no use to go on from there.
    if (std::abs(ahead - before) < kNear * step) break;
    value = nearness(state, next);
    if (between && !(std::abs(value) < least)) break;
  }
  if (!(ahead > -step) || !(ahead < reach)) return {};
  // Neither a pole nor a near miss: the signs before and behind it differ, the sizes hardly, and nearer they are
  // smaller. Not looked at too near: the way leaves the constraints a little, which splits the zero there.
  const double length = 0.1 * step, behind = nearness(state, ahead + length), ago = nearness(state, ahead - length);
  const double change = std::abs(behind - ago);
  if (!(std::abs(behind + ago) < kEven * change)) return {};
  const double inner = std::abs(nearness(state, ahead + length / 2) - nearness(state, ahead - length / 2));
  if (!(inner < 0.75 * change)) return {};
  return ahead;
}

/// q onto the constraints, then v; false where that fails.
bool SingularPose::place(double time, VectorX& q, VectorX& v) {
  // As far as round-off lets: an error in g moves q by 1/δ of it.
  constexpr double kAllowed = 1e-13;
  constexpr int kIterations = 6;
  if (!(projector_.position(time, q, 0, kIterations).residual <= kAllowed)) return false;
  projector_.velocity(time, q, v);
  return q.allFinite() && v.allFinite();
}

bool SingularPose::pass(State& state, double ahead, double step, double t_stop) {
  constexpr int kMostPasses = 30;
  constexpr double kConverged = 1e-14, kSlow = 0.3;  // of the fastest velocity; rate
  // Round-off of g across the branch, over δ³, which the end's projection takes away again.
  constexpr double kNoise = 1e-6;
  const Layout& layout = equations_.layout();
  double h = 2 * std::max(ahead, step);
  const bool stops = !(state.time + h < t_stop * (1 - 1e-12));
  if (stops) h = t_stop - state.time;
  if (!(h > ahead)) return false;  // it ends before
  const double time = stops ? t_stop : state.time + h;
  const Gauss& rule = choose(ahead / h);
  // 1. Nodes by the present acceleration at first, then from each other.
  const auto nv = layout.v_count();
  MatrixX d_rates = MatrixX::Zero(nv, rule.n), rates(nv, rule.n), d_next(nv, rule.n);
  VectorX lambda = state.lambda.size() == layout.row_count() ? state.lambda : VectorX::Zero(layout.row_count()).eval();
  VectorX q(layout.q_count()), v(nv), d(nv), rate(nv);
  for (int i = 0; i < rule.n; ++i) {
    rates.col(i) = state.v_dot;
    d_rates.col(i) = state.v + rule.c[i] * h * state.v_dot;
  }
  double last = 0;
  const double size = std::max(state.v.cwiseAbs().maxCoeff(), 1e-12);
  for (int k = 0;; ++k) {
    if (k == kMostPasses) return false;
    MatrixX next(nv, rule.n);
    for (int i = 0; i < rule.n; ++i) {
      d.setZero();
      v = state.v;
      for (int j = 0; j < rule.n; ++j) d += h * rule.a[i][j] * d_rates.col(j), v += h * rule.a[i][j] * rates.col(j);
      layout.retract(state.q, d, q);
      const double at = state.time + rule.c[i] * h;
      if (!place(at, q, v)) return false;
      layout.difference(state.q, q, d);
      layout.chart_rates(d, v, rate);
      d_next.col(i) = rate;
      projector_.accelerations(at, q, v, rate, lambda);
      if (!rate.allFinite()) return false;
      next.col(i) = rate;
    }
    const double change = std::max(h * (next - rates).cwiseAbs().maxCoeff(), (d_next - d_rates).cwiseAbs().maxCoeff());
    rates = next, d_rates = d_next;
    if (change <= kConverged * size) break;
    if (k > 2 && change > kSlow * last) {
      if (change > kNoise * size) return false;  // the step is too long for this way
      break;
    }
    last = change;
  }
  // 2. The end; near to the pose the polynomial alone tells it.
  d.setZero();
  v = state.v;
  for (int j = 0; j < rule.n; ++j) d += h * rule.b[j] * d_rates.col(j), v += h * rule.b[j] * rates.col(j);
  layout.retract(state.q, d, q);
  if (h - ahead > 0.05 * h && !place(time, q, v)) return false;
  rate.resize(nv);
  projector_.accelerations(time, q, v, rate, lambda);
  if (!rate.allFinite()) return false;
  state.time = time;
  state.q = q, state.v = v, state.v_dot = rate, state.lambda = lambda;
  return true;
}

}  // namespace lithe
