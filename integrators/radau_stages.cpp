#include "integrators/radau_stages.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <limits>

#include "engine/archive/archive.h"

namespace lithe {
namespace {

// Of the tolerance, for the last correction of Newton. A tenth of what RADAU5 takes: where stiff forces turn,
// corrections err the same way step after step (R05: a tenth of the drift of the angular momentum for a third more
// iterations).
// Least of a measured rate, too: the last correction itself is then within the tolerance. A rate is the mean of how far
// the factor is off along the first correction; where that one, of a step far too long, led through regions of no
// concern, it says nothing of where it ended (1e5 m and then 0.02 m: a rate of 1e-7).
constexpr double kShare = 0.003;
constexpr double kFarthest = 8;      // steps of the last length that its polynomial is trusted ahead
constexpr int kKinematicPasses = 2;  // of d = h A Jr⁻¹(d) v + c, an iteration
constexpr int kFirstPasses = 4;      // at the start, where d is a guess
constexpr double kSlow = 0.3;        // rate of Newton that is worth new factors

/// Values at x of the Lagrange polynomials over `nodes`.
template <int n>
Eigen::Matrix<double, n, 1> lagrange(const Eigen::Matrix<double, n, 1>& nodes, double x) {
  Eigen::Matrix<double, n, 1> out;
  for (int i = 0; i < n; ++i) {
    out[i] = 1;
    for (int j = 0; j < n; ++j)
      if (j != i) out[i] *= (x - nodes[j]) / (nodes[i] - nodes[j]);
  }
  return out;
}

}  // namespace

RadauStages::RadauStages() {
  const double r = std::sqrt(6.0);
  A_ << (88 - 7 * r) / 360, (296 - 169 * r) / 1800, (-2 + 3 * r) / 225,  //
      (296 + 169 * r) / 1800, (88 + 7 * r) / 360, (-2 - 3 * r) / 225,    //
      (16 - r) / 36, (16 + r) / 36, 1.0 / 9;
  c_ << (4 - r) / 10, (4 + r) / 10, 1;
  error_weights_ << -(13 + 7 * r) / 3, (-13 + 7 * r) / 3, -1.0 / 3;
  A_inverse_ = A_.inverse();
  // T: the real eigenvector, and (x, -y) of the complex one x + iy to α + iβ.
  const Eigen::EigenSolver<Matrix3> eigen(A_inverse_);
  for (int k = 0; k < 3; ++k) {
    const std::complex<double> value = eigen.eigenvalues()[k];
    const Eigen::Vector3cd vector = eigen.eigenvectors().col(k);
    if (std::abs(value.imag()) < 1e-8) gamma_ = value.real(), T_.col(0) = vector.real();
    if (value.imag() > 1e-8) alpha_ = value, T_.col(1) = vector.real(), T_.col(2) = -vector.imag();
  }
  T_inverse_ = T_.inverse();
}

void RadauStages::prepare(EquationsOfMotion& equations, const State& state) {
  const int nv = equations.layout().v_count(), rows = equations.layout().row_count();
  for (Stages* x : {&d_, &v_, &v_dot_, &correction_, &rv_, &dv_, &dd_, &rates_, &last_v_}) x->setZero(nv, 3);
  for (Stages* x : {&lambda_, &g_, &g_dot_, &dl_, &last_lambda_}) x->setZero(rows, 3);
  for (VectorX* x : {&x_, &d_size_, &v_size_, &pull_}) x->setZero(nv);
  y_.setZero(rows);
  q_ = state.q;
  xc_.setZero(nv);
  yc_.setZero(rows);
  last_h_ = complex_h_ = 0;
  rate_ = 1;
  allowance_ = 1e-3;
  equations.evaluate(state.time, state.q, state.v, Level::velocity);
  equations.residual(state.v_dot, state.lambda, x_);
  equations.parts().complex_factor->factorize_complex({1.0, alpha_, alpha_ * alpha_}, state.v_dot, state.lambda,
                                                      nullptr);
}

void RadauStages::predict(const Layout& layout, const State& start, double h) {
  const double ahead = last_h_ > 0 ? h / last_h_ : 2 * kFarthest;
  for (int i = 0; i < 3; ++i) {
    if (ahead <= kFarthest) {
      // v over (0, c) of the last step, 0 at its start; λ over c alone.
      const double x = 1 + c_[i] * ahead;
      const Vector4 nodes(0, c_[0], c_[1], c_[2]);
      const Vector4 of_v = lagrange<4>(nodes, x);
      const Vector3 of_lambda = lagrange<3>(c_, x);
      v_.col(i) = start.v - last_v_.col(2);
      for (int j = 0; j < 3; ++j) v_.col(i) += of_v[j + 1] * last_v_.col(j);
      lambda_.col(i).noalias() = last_lambda_.lazyProduct(of_lambda);
    } else {
      v_.col(i) = start.v + (h * c_[i]) * start.v_dot;
      lambda_.col(i) = start.lambda;
    }
    d_.col(i) = (h * c_[i]) * start.v;
  }
  correction_.setZero();
  for (int pass = 0; pass < kFirstPasses; ++pass) advance_kinematics(layout, h);
  rv_ = v_.colwise() - start.v;
  v_dot_.noalias() = rv_.lazyProduct(A_inverse_.transpose() / h);
  layout.magnitudes(start.q, d_size_);
  v_size_ = start.v.cwiseAbs().cwiseMax(v_.col(2).cwiseAbs());
}

/// One pass of d_i = h Σ a_ij Jr⁻¹(d_j) v_j + c_i.
void RadauStages::advance_kinematics(const Layout& layout, double h) {
  for (int j = 0; j < 3; ++j) layout.chart_rates(d_.col(j), v_.col(j), rates_.col(j));
  d_.noalias() = rates_.lazyProduct(h * A_.transpose());
  d_ += correction_;
}

/// Residuals of all stages; the middle one comes last, for the tangents.
void RadauStages::evaluate(EquationsOfMotion& equations, const State& start, double time, double h) {
  for (int i : {0, 2, 1}) {
    equations.layout().retract(start.q, d_.col(i), q_);
    equations.evaluate(i == 2 ? time : start.time + c_[i] * h, q_, v_.col(i), Level::velocity);
    equations.residual(v_dot_.col(i), lambda_.col(i), rv_.col(i));
    equations.constraint(Level::position, g_.col(i));
    equations.constraint(Level::velocity, g_dot_.col(i));
  }
}

/// At the middle stage, evaluated last.
void RadauStages::factorize(EquationsOfMotion& equations, const State& start, double h, bool with_complex) {
  const double s = gamma_ / h;
  const TangentWeights real{1, s, s * s};
  if (!with_complex) return equations.factorize(real, v_dot_.col(1), lambda_.col(1), nullptr);
  const std::complex<double> z = alpha_ / h;
  complex_factor_.make_complex(equations, real, {1.0, z, z * z}, start.time + c_[1] * h, start, q_, v_.col(1),
                               v_dot_.col(1), lambda_.col(1));
  complex_h_ = h;
}

void RadauStages::history(Archive& archive, EquationsOfMotion& equations) {
  archive("last_v", last_v_);
  archive("last_lambda", last_lambda_);
  archive("last_h", last_h_);
  archive("complex_h", complex_h_);
  archive("rate", rate_);
  archive("allowance", allowance_);
  if (!archive.loads() && complex_h_ == 0) complex_factor_.forget();
  complex_factor_.history(archive, equations);
}

void RadauStages::correct(EquationsOfMotion& equations, double h) {
  const Layout& layout = equations.layout();
  const double s = gamma_ / h;
  const std::complex<double> z = alpha_ / h, i(0, 1);
  // 1. Into the eigenvectors of A⁻¹.
  dv_.noalias() = rv_.lazyProduct(-T_inverse_.transpose());
  dl_.noalias() = g_dot_.lazyProduct(-T_inverse_.transpose());
  // 2. Velocities w = s x with G w = -ġ: the real system and the complex one.
  x_ = dv_.col(0);
  y_ = dl_.col(0) / s;
  equations.solve(x_, y_);
  dv_.col(0) = s * x_;
  dl_.col(0) = y_;
  xc_ = dv_.col(1) + i * dv_.col(2);
  yc_ = (dl_.col(1) + i * dl_.col(2)) / z;
  equations.parts().complex_factor->solve_complex(xc_, yc_);
  xc_ *= z;
  dv_.col(1) = xc_.real();
  dv_.col(2) = xc_.imag();
  dl_.col(1) = yc_.real();
  dl_.col(2) = yc_.imag();
  // 3. Back to stages.
  rv_.noalias() = dv_.lazyProduct(T_.transpose());
  dv_ = rv_;
  v_ += dv_;
  v_dot_ += dv_.lazyProduct(A_inverse_.transpose() / h);
  lambda_ += dl_.lazyProduct(T_.transpose());
  // 4. Positions follow velocities by h A; what that leaves of g is fixed along one direction B for all stages (of the
  // real factor alone: the complex one may be older, and a second direction would cost the order).
  g_ -= g_dot_.lazyProduct(h * A_.transpose());
  for (int row : equations.velocity_rows()) g_.row(row).setZero();
  for (int k = 0; k < 3; ++k) {
    x_.setZero();
    y_ = -g_.col(k);
    equations.solve(x_, y_);
    layout.chart_rates(d_.col(k), x_, dd_.col(k));
  }
  correction_ += dd_;
  dd_ = -d_;
  for (int pass = 0; pass < kKinematicPasses; ++pass) advance_kinematics(layout, h);
  dd_ += d_;
}

/// The last correction over what it may be.
double RadauStages::size(double h, const Target& target) const {
  if (target.largest > 0) return std::max(dd_.cwiseAbs().maxCoeff(), h * dv_.cwiseAbs().maxCoeff()) / target.largest;
  double sum = 0;
  for (int i = 0; i < 3; ++i) {
    const double of_d = error_ratio(dd_.col(i), d_size_, target.tolerance);
    const double of_v = error_ratio(dv_.col(i), v_size_, target.tolerance);
    sum += std::max(of_d, of_v) * std::max(of_d, of_v);
  }
  return std::sqrt(sum / 3) / kShare;
}

/// That corrections no longer shrink is round-off: they are tiny beside the coordinates; or well below the tolerance
/// while the constraints hold to the last digits, which rows that nearly depend on each other make many more of in q.
bool RadauStages::at_round_off(double h, double gap, double size, const Target& target) const {
  constexpr double kTiny = 1e-13, kClosed = 1e-14, kOfTolerance = 0.3;
  const double scale = 1 + q_.cwiseAbs().maxCoeff();
  if (std::max(dd_.cwiseAbs().maxCoeff(), h * dv_.cwiseAbs().maxCoeff()) <= kTiny * scale) return true;
  return gap <= kClosed * scale && size <= (target.largest > 0 ? 1 : kOfTolerance / kShare);
}

/// Largest |g| of the rows that corrections close.
double RadauStages::gap(const EquationsOfMotion& equations) const {
  double largest = 0;
  const auto& left_out = equations.redundant_rows();
  for (int row = 0; row < g_.rows(); ++row)
    if (!std::binary_search(left_out.begin(), left_out.end(), row))
      largest = std::max(largest, g_.row(row).cwiseAbs().maxCoeff());
  return largest;
}

bool RadauStages::solve(EquationsOfMotion& equations, const State& start, double time, double h, const Target& target,
                        IntegratorStatistics& statistics) {
  // The real factor is made anew each step: others (accelerations) use its place. The complex one, some four times as
  // dear, is kept while steps stay as long and Newton goes fast.
  bool fresh = !(complex_h_ > 0 && std::abs(h / complex_h_ - 1) < 1e-6);
  bool factors = true, renewed = false;  // factors are to be made; have been within these iterations
  worst_rate_ = 0;
  // No correction reaches them: what was extrapolated for them would grow from step to step.
  for (int row : equations.redundant_rows()) lambda_.row(row).setZero();
  double allowance = std::max(kShare, std::pow(allowance_, 0.8)), last = 0;
  for (int k = 0; k < kMaxNewton; ++k) {
    evaluate(equations, start, time, h);
    statistics.evaluations += 3;
    if (factors) {
      factorize(equations, start, h, fresh);
      ++statistics.factorizations;
      factors = false;
    }
    const double gap_before = k > 0 ? gap(equations) : 0;
    correct(equations, h);
    ++statistics.newton_iterations;
    iterations_ = k + 1;
    const double now = size(h, target);
    if (!std::isfinite(now) || !lambda_.allFinite()) break;
    const double slowest = worst_rate_;
    if (k > 0) {
      rate_ = now / last;
      worst_rate_ = std::max(worst_rate_, rate_);
      allowance = rate_ < 1 ? std::max(kShare, rate_ / (1 - rate_)) : std::numeric_limits<double>::infinity();
    }
    const bool round_off = k > 0 && rate_ > kSlow && at_round_off(h, gap_before, now, target);
    if (allowance * now <= 1 || now == 0 || round_off) {
      // The next step's first correction: the slowest rate of this step's. The last one of an iteration that goes ever
      // faster says nothing of it.
      if (k > 0) allowance = worst_rate_ < 1 ? worst_rate_ / (1 - worst_rate_) : 1;
      allowance_ = std::min(allowance, 1.0);
      // That of round-off is no reason for shorter steps, in which there is as much of it.
      if (round_off) worst_rate_ = slowest;
      return true;
    }
    // Too slow: new factors once, where Newton has come to.
    const bool hopeless = k > 0 && (rate_ >= 1 || now * std::pow(rate_, kMaxNewton - 1 - k) / (1 - rate_) > 1);
    if (hopeless && renewed) break;
    if (k > 0 && !renewed && (hopeless || (!fresh && rate_ > kSlow))) {
      factors = fresh = renewed = true;
      begin_again(equations.layout(), h);  // corrections lay along the old factor
    }
    last = now;
  }
  complex_h_ = 0;
  allowance_ = rate_ = 1;
  return false;
}

void RadauStages::accept(const State& start, double h) {
  last_v_ = v_.colwise() - start.v;
  last_lambda_ = lambda_;
  last_h_ = h;
  if (!worth_keeping()) complex_h_ = 0;
}

/// The stages as they are, as start values of the same step; corrections of positions begin at zero.
void RadauStages::begin_again(const Layout& layout, double h) {
  correction_.setZero();
  allowance_ = 1;  // a rate that Newton had before says nothing of the first iteration from here
  advance_kinematics(layout, h);
}

bool RadauStages::solve_again(EquationsOfMotion& equations, const State& start, double time, double h,
                              const RadauRecord& record) {
  if (v_.rows() != start.v.size() || lambda_.rows() != equations.layout().row_count()) prepare(equations, start);
  v_dot_ = record.v_dot;
  lambda_ = record.lambda;
  for (int row : equations.redundant_rows()) lambda_.row(row).setZero();
  v_.noalias() = v_dot_.lazyProduct(h * A_.transpose());
  v_.colwise() += start.v;
  d_ = record.d;
  begin_again(equations.layout(), h);
  if (!iterate_to_round_off(equations, start, time, h, false)) return false;
  // Corrections lie along factors on the way: once more along that of the solution, until this is the one it leads to.
  constexpr int kMostPasses = 8;
  constexpr double kSame = 1e-15;
  Stages last;
  for (int pass = 0; pass < kMostPasses; ++pass) {
    if (pass > 0 && (correction_ - last).lpNorm<Eigen::Infinity>() <= kSame) return true;
    last = correction_;
    if (pass == 0 && last.lpNorm<Eigen::Infinity>() <= kSame) return true;
    evaluate(equations, start, time, h);
    factorize(equations, start, h, true);
    begin_again(equations.layout(), h);
    if (!iterate_to_round_off(equations, start, time, h, true)) return false;
  }
  return true;
}

/// Newton as far as it goes, along the factor that there is, or along new ones where it is slow: long steps of stiff
/// forces that turn need them.
bool RadauStages::iterate_to_round_off(EquationsOfMotion& equations, const State& start, double time, double h,
                                       bool one_factor) {
  constexpr int kMost = 150, kStands = 3;
  constexpr double kRoundOff = 1e-16, kGood = 1e-11;
  double last = 0, least = std::numeric_limits<double>::infinity();
  bool slow = true;
  for (int k = 0, stands = 0; k < kMost; ++k) {
    evaluate(equations, start, time, h);
    if (slow && !one_factor) factorize(equations, start, h, true);
    correct(equations, h);
    const double now = std::max(dd_.cwiseAbs().maxCoeff(), h * dv_.cwiseAbs().maxCoeff());
    if (!std::isfinite(now) || !lambda_.allFinite()) return false;
    const double scale = 1 + q_.cwiseAbs().maxCoeff();
    if (now <= kRoundOff * scale) return true;
    stands = now > 0.9 * least ? stands + 1 : 0;
    if (stands >= kStands && now <= kGood * scale) return true;
    slow = k > 0 && now > kSlow * last;
    least = std::min(least, now);
    last = now;
  }
  return false;
}

std::shared_ptr<const RadauRecord> RadauStages::record() const {
  const auto record = std::make_shared<RadauRecord>();
  record->d = d_, record->v = v_, record->v_dot = v_dot_, record->lambda = lambda_;
  return record;
}

void RadauStages::estimate(EquationsOfMotion& equations, const State& start, double h, bool again, VectorX& d_error,
                           VectorX& v_error) {
  const double s = gamma_ / h;
  // s e_q - e_v = φ and (s M + D) e_v + K e_q + Gᵀ e_λ = f(q_n) + M Σ w_i (v_i - v_n)/h, G e_v = 0, where
  // φ = v_n + Σ w_i d_i/h: with e_v = s x and e_q = x + φ/s the K φ/s is had by looking at f from q_n ⊕ φ/s.
  if (!again) {
    d_error.setZero();
    v_error.setZero();
  }
  x_ = start.v + v_error;
  rv_ = v_.colwise() - start.v;
  pull_.noalias() = rv_.lazyProduct(-error_weights_ / h);
  v_error = x_;
  v_error.noalias() += d_.lazyProduct(error_weights_ / h);  // φ
  d_error += v_error / s;
  equations.layout().retract(start.q, d_error, q_);
  equations.evaluate(start.time, q_, x_, Level::velocity);
  equations.residual(pull_, start.lambda, x_);
  x_ = -x_;
  y_.setZero();
  equations.solve(x_, y_);
  d_error = x_ + v_error / s;
  v_error = s * x_;
}

int RadauStages::worst() const {
  Eigen::Index worst = 0, stage = 0;
  for (int i = 0; i < dv_.rows(); ++i)
    if (!dv_.row(i).allFinite() || !dd_.row(i).allFinite()) return i;
  if (dv_.rows() > 0) dd_.cwiseAbs().maxCoeff(&worst, &stage);
  return static_cast<int>(worst);
}

}  // namespace lithe
