#include "engine/motion/singular_pose.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/archive/archive.h"
#include "engine/base/error.h"

namespace lithe {
namespace {

constexpr int kRules = 5;
constexpr double kInside = 0.01;  // of an error within the way, which does not last
constexpr int kPieces = 8;  // that a way is gone along: between them the motion is a quintic to 1e-12 (dense output)

/// Most nodes first.
const GaussRule& rule(int i) {
  static const GaussRule rules[kRules] = {GaussRule(10), GaussRule(9), GaussRule(8), GaussRule(7), GaussRule(6)};
  return rules[i];
}

/// The two of most nodes, none of which is near to the fraction x of the step.
std::array<int, 2> choose_rules(double x) {
  constexpr double kAway = 0.04;
  std::array<int, 2> out{kRules - 2, kRules - 1};
  int found = 0;
  for (int i = 0; i < kRules && found < 2; ++i)
    if ((rule(i).nodes.array() - x).abs().minCoeff() > kAway) out[found++] = i;
  if (found == 1 && out[0] == out[1]) out[1] = kRules - 2;
  return out;
}

double largest(const VectorX& x) { return x.cwiseAbs().maxCoeff(); }

/// Anything without a pattern; the same each time.
double any(int i) { return 1.5 + std::sin(1 + 2.4 * i + 0.37 * std::sin(5.1 * i)); }

}  // namespace

SingularPose::SingularPose(EquationsOfMotion& equations) : equations_(equations), projector_(equations) {
  const Layout& layout = equations.layout();
  for (VectorX* x : {&d_, &v_, &rate_}) x->setZero(layout.v_count());
  for (VectorX* x : {&rows_, &probe_, &lambda_}) x->setZero(layout.row_count());
  q_.setZero(layout.q_count());
  for (int i = 0; i < probe_.size(); ++i) probe_[i] = any(i + 7) * (i % 3 ? 1 : -1);
}

/// 1/|x| with G x = b, b arbitrary: along a motion, zero where G loses a rank, and proportional to the time from there.
double SingularPose::nearness(ConstVectorRef q, double time) {
  equations_.memory().recall_rows(left_out_);  // at the pose itself no choice can be told from another
  v_.setZero();
  equations_.evaluate(time, q, v_, Level::velocity);
  rows_.setZero();
  equations_.factorize({0, 0, 1}, v_, rows_, nullptr);
  rows_ = probe_;
  equations_.solve(v_, rows_);
  return 1 / v_.norm();
}

/// Samples along the way that its acceleration tells. Seconds from `from` to the pose, if there is one.
std::optional<double> SingularPose::locate(const State& from, double window, double earliest, double latest) {
  constexpr int kFiner = 16;
  constexpr double kDip = 0.1;  // of the largest: the way leaves the constraints a little, and misses the pose
  equations_.memory().track_rows(left_out_);
  double where = 0, least = std::numeric_limits<double>::infinity(), largest = 0;
  const auto look = [&](double later) {
    d_ = later * from.v + 0.5 * later * later * from.v_dot;
    equations_.layout().retract(from.q, d_, q_);
    const double near = nearness(q_, from.time + later);
    largest = std::max(largest, near);
    if (near < least && later >= earliest && later <= latest) least = near, where = later;
    return near;
  };
  window_ = window;
  for (int i = 0; i <= kSamples; ++i) near_[i] = look(window * i / kSamples);
  const double middle = where, apart = window / kSamples;
  for (int i = 1; i < kFiner; ++i) look(std::max(0.0, middle + apart * (2.0 * i / kFiner - 1)));
  equations_.memory().recall_rows(left_out_);
  if (!(least < kDip * largest)) return {};
  return where;
}

/// How near to a pose the nodes of a step come: the less, the worse.
double SingularPose::clearance(double length, double pose) const {
  const auto [best, other] = choose_rules(pose / length);
  double least = std::numeric_limits<double>::infinity();
  for (int r : {best, other})
    for (double node : rule(r).nodes) {
      const double at = std::min(node * length / window_ * kSamples, kSamples - 1e-9), part = at - std::floor(at);
      const auto i = static_cast<std::size_t>(at);
      least = std::min(least, (1 - part) * near_[i] + part * near_[i + 1]);
    }
  return least;
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

/// Rates at the nodes of a step, from those given, each time from all. False where that does not converge.
bool SingularPose::collocate(const State& from, double length, const GaussRule& gauss, MatrixX& d_rates,
                             MatrixX& rates) {
  constexpr int kMostPasses = 40;
  constexpr double kConverged = 1e-15, kSlow = 0.5;  // of the fastest velocity; rate
  constexpr double kNoise = 1e-7;                    // where corrections no longer shrink
  const Layout& layout = equations_.layout();
  const double size = std::max({from.v.cwiseAbs().maxCoeff(), length * rates.cwiseAbs().maxCoeff(), 1e-12});
  MatrixX next = rates, d_next = d_rates;
  double last = 0;
  for (int k = 0;; ++k) {
    if (k == kMostPasses) return false;
    for (int i = 0; i < gauss.count(); ++i) {
      d_.noalias() = length * (d_rates * gauss.stages.row(i).transpose());
      v_ = from.v + length * (rates * gauss.stages.row(i).transpose());
      layout.retract(from.q, d_, q_);
      const double at = from.time + gauss.nodes[i] * length;
      if (!place(at, q_, v_)) return false;
      layout.difference(from.q, q_, d_);
      layout.chart_rates(d_, v_, rate_);
      d_next.col(i) = rate_;
      projector_.accelerations(at, q_, v_, rate_, lambda_);
      if (!rate_.allFinite()) return false;
      next.col(i) = rate_;
    }
    const double change =
        std::max(length * (next - rates).cwiseAbs().maxCoeff(), (d_next - d_rates).cwiseAbs().maxCoeff()) / size;
    rates = next, d_rates = d_next;
    if (change <= kConverged) return true;
    if (k > 2 && change > kSlow * last) return change <= kNoise;  // the step is too long for this way, or round-off
    last = change;
  }
}

/// Two rules, the second of which begins where the first one leads; `off`: how far their ends are apart, of the fastest
/// velocity. The way is then that of the first.
bool SingularPose::agree(const State& from, double length, double pose, double& off) {
  const auto [best, other] = choose_rules(pose / length);
  const GaussRule &gauss = rule(best), &check = rule(other);
  const auto nv = equations_.layout().v_count();
  MatrixX rates(nv, gauss.count()), d_rates(nv, gauss.count());
  for (int i = 0; i < gauss.count(); ++i) {
    rates.col(i) = from.v_dot;
    d_rates.col(i) = from.v + gauss.nodes[i] * length * from.v_dot;
  }
  lambda_ = from.lambda.size() == lambda_.size() ? from.lambda : VectorX::Zero(lambda_.size()).eval();
  if (!collocate(from, length, gauss, d_rates, rates)) return false;
  MatrixX check_rates(nv, check.count()), check_d_rates(nv, check.count());
  for (int i = 0; i < check.count(); ++i) {
    const VectorX basis = gauss.basis(check.nodes[i]);
    check_rates.col(i) = rates * basis;
    check_d_rates.col(i) = d_rates * basis;
  }
  if (!collocate(from, length, check, check_d_rates, check_rates)) return false;
  const double size = std::max({from.v.cwiseAbs().maxCoeff(), length * rates.cwiseAbs().maxCoeff(), 1e-12});
  const auto apart = [&](const VectorX& a, const VectorX& b) {
    const double of_v = length * (rates * a - check_rates * b).cwiseAbs().maxCoeff();
    return std::max(of_v, (d_rates * a - check_d_rates * b).cwiseAbs().maxCoeff()) / size;
  };
  const double end = apart(gauss.weights, check.weights);
  double inside = 0;
  for (double x : {0.25, 0.5, 0.75}) inside = std::max(inside, apart(gauss.integrals(x), check.integrals(x)));
  off = std::max(end, kInside * inside);
  take(from, length, best, d_rates, rates);
  return true;
}

void SingularPose::take(const State& from, double length, int rule, const MatrixX& d_rates, const MatrixX& rates) {
  rule_ = rule;
  begin_ = from.time, end_ = from.time + length;
  q_begin_ = from.q, v_begin_ = from.v;
  d_rates_ = d_rates, rates_ = rates;
}

/// In which the body that turns fastest turns by an angle, at most; infinite where nothing turns.
double SingularPose::time_to_turn(const State& state, double angle) const {
  double rate = 0, growth = 0;
  for (const auto& b : equations_.layout().bodies()) {
    if (!b.frame) continue;
    rate = std::max(rate, state.v.segment<3>(b.v + 3).squaredNorm());
    if (state.v_dot.size() > 0) growth = std::max(growth, state.v_dot.segment<3>(b.v + 3).squaredNorm());
  }
  rate = std::sqrt(rate);
  return 2 * angle / (rate + std::sqrt(rate * rate + 2 * angle * std::sqrt(growth)));
}

void SingularPose::remember(const State& state) {
  constexpr double kApart = 0.05;  // rad
  const State &last = kept_[last_], &before = kept_[(last_ + kKept - 1) % kKept];
  if (last.q.size() > 0 && (before.q.size() == 0 || last.time - before.time >= time_to_turn(last, kApart))) {
    last_ = (last_ + 1) % kKept;
    if (last_ == anchor_) last_ = (last_ + 1) % kKept;
  }
  kept_[last_] = state;
}

/// The earliest kept state that is less than a fraction of a turn away.
int SingularPose::begin_of_way(double now) const {
  constexpr double kFarthest = 0.3;  // rad
  int first = last_;
  for (int i = 0; i < kKept; ++i) {
    const State& state = kept_[i];
    if (state.q.size() > 0 && now - state.time < time_to_turn(state, kFarthest) && state.time < kept_[first].time)
      first = i;
  }
  return first;
}

bool SingularPose::cross(const State& now, double step) {
  rule_ = -1;
  blocked_ = false;
  if (lambda_.size() == 0 || equations_.parts().rigid_contacts) return false;
  if (now.time > keep_until_) anchor_ = -1;
  // From afar first: what is nearer knows less.
  const int first = begin_of_way(now.time);
  int tried = -1;
  for (int i : {anchor_, first, last_}) {
    if (i < 0 || i == tried || kept_[i].v_dot.size() != d_.size()) continue;
    tried = i;
    const State& from = kept_[i];
    equations_.memory().recall(from.quarter_turns);
    equations_.memory().recall(from.contacts);
    equations_.memory().recall_rows(from.left_out);
    if (!cross_from(from, now.time, step)) continue;
    anchor_ = i;
    keep_until_ = 2 * end_ - begin_;
    break;
  }
  equations_.memory().recall(now.quarter_turns);
  equations_.memory().recall(now.contacts);
  if (rule_ < 0) return false;
  message_ = "passed a pose where constraints lose rank at t = " + std::to_string(pose_) +
             " s, on the branch that the velocity tells";
  return true;
}

bool SingularPose::cross_from(const State& from, double now, double step) {
  constexpr double kTurn = 0.4;  // rad
  constexpr int kHalvings = 4;
  constexpr double kEnough = 1e-11, kAllowed = 1e-7;
  constexpr double kLook = 0.01, kReach = 8, kBehind = 2;  // rad; steps
  const double past = now - from.time, all = time_to_turn(from, kTurn), turn = std::isfinite(all) ? all : 0;
  step = std::max(step, kLook / kTurn * turn);
  const auto pose = locate(from, std::max({2.5 * past, past + kReach * step, 1.5 * turn}), past - kBehind * step,
                           past + kReach * step);
  if (!pose) return false;
  pose_ = from.time + *pose;
  // As long as a fraction of a turn, or shorter, whichever length nearby keeps nodes farthest from poses.
  const double least = std::max(1.5 * *pose, 1.1 * past + step);
  double best = kAllowed, best_length = 0;
  for (int i = 0; i <= kHalvings; ++i) {
    // First with the pose in the middle, where rules of most nodes are clear of it.
    const double wished = std::max(least, i == 0 ? 2 * *pose : std::ldexp(turn, 1 - i));
    constexpr double kFactors[] = {1, 1.1, 1.2, 1.33, 1.5};
    double clear = 0, length = wished;
    for (double factor : kFactors) clear = std::max(clear, clearance(factor * wished, *pose));
    for (double factor : kFactors)
      if (clearance(length = factor * wished, *pose) >= 0.5 * clear) break;
    double off = 0;
    const bool found = agree(from, length, *pose, off);
    if (found && off < best) best = off, best_length = length;
    if (best < kEnough || (i > 0 && wished == least)) break;
  }
  double off = 0;
  if (best_length == 0 || (end_ - begin_ != best_length && !agree(from, best_length, *pose, off))) {
    rule_ = -1;
    blocked_ = true;
    return false;
  }
  blocked_ = false;
  return true;
}

double SingularPose::next_stop(double time, double at_most) const {
  const double piece = (end_ - begin_) / kPieces;
  const double next = time + piece < end_ - 0.1 * piece ? time + piece : end_;
  return std::min(next, at_most);
}

void SingularPose::follow(State& state, double time) {
  constexpr double kMoves = 1e-5;  // beside the size of coordinates: farther only where round-off decides
  const Layout& layout = equations_.layout();
  const double length = end_ - begin_, x = (time - begin_) / length;
  const GaussRule& gauss = rule(rule_);
  const VectorX integrals = x < 1 ? gauss.integrals(x) : gauss.weights;
  d_.noalias() = length * (d_rates_ * integrals);
  state.v = v_begin_ + length * (rates_ * integrals);
  layout.retract(q_begin_, d_, state.q);
  state.time = time;
  q_ = state.q, v_ = state.v;
  if (place(time, q_, v_)) {
    layout.difference(state.q, q_, d_);
    if (d_.cwiseAbs().maxCoeff() <= kMoves * (1 + state.q.cwiseAbs().maxCoeff())) state.q = q_, state.v = v_;
  }
  if (state.lambda.size() != lambda_.size()) state.lambda = lambda_;
  state.v_dot.resize(layout.v_count());
  projector_.accelerations(time, state.q, state.v, rate_, lambda_);
  if (lambda_.allFinite()) state.lambda = lambda_;
  state.v_dot = rates_ * gauss.basis(x);
  if (x >= 1) rule_ = -1;
}

/// The acceleration t (t·f)/(t·M t) along the branch with the tangent t: where the constraints lead that are nearest to
/// a small motion the way the forces pull, then nearer to the pose.
bool SingularPose::find_branch(const State& state, VectorX& v_dot) {
  constexpr double kFirst = 1e-2, kNearer = 1e-3, kNearest = 1e-4;  // rad, or m where nothing turns
  constexpr double kFalls = 0.1;  // nearness, in a hundredth of the distance; at the pose itself rows give way
  constexpr int kIterations = 30;
  const Layout& layout = equations_.layout();
  VectorX tangent = v_dot;
  const auto move = [&](double reach) {
    d_ = tangent * (reach / largest(tangent));
    layout.retract(state.q, d_, q_);
  };
  move(kFirst);
  const double afar = nearness(q_, state.time);
  move(kNearest);
  if (!(nearness(q_, state.time) < kFalls * afar)) return false;
  for (double reach : {kFirst, kNearer}) {
    move(reach);
    if (!(projector_.position(state.time, q_, 0, kIterations).residual < 1e-12)) return false;
    layout.difference(state.q, q_, tangent);
    if (!(largest(tangent) > 0.1 * reach)) return false;  // no branch leads that way
  }
  tangent /= tangent.norm();
  v_.setZero(), rows_.setZero();
  equations_.evaluate(state.time, state.q, v_, Level::velocity);
  equations_.residual(v_, rows_, d_);  // -f
  equations_.residual(tangent, rows_, rate_);
  v_dot = tangent * (-tangent.dot(d_) / tangent.dot(rate_ - d_));
  return v_dot.allFinite() && largest(v_dot) > 0;
}

bool SingularPose::leave(State& state) {
  constexpr double kAtRest = 1e-12, kAllowed = 1e-7, kEnough = 1e-11;  // m/s, rad/s; of the velocity reached
  if (lambda_.size() == 0 || equations_.parts().rigid_contacts || !(largest(state.v) <= kAtRest)) return false;
  left_out_ = state.left_out;  // as before anything was factorised in this pose, where rows are as good as others
  State from = state;
  from.v_dot.resize(d_.size());
  projector_.accelerations(state.time, state.q, state.v, from.v_dot, lambda_);
  if (!(largest(from.v_dot) > 0)) return false;
  if (!find_branch(state, from.v_dot)) return false;
  // Where it leads, up to a fraction of a turn.
  double best = kAllowed, best_length = 0, off = 0;
  for (double turn : {0.5, 0.25, 0.12, 0.06}) {  // rad
    const double length = std::sqrt(2 * turn / largest(from.v_dot));
    if (agree(from, length, 0, off) && off < best) best = off, best_length = length;
    if (best < kEnough) break;
  }
  if (best_length == 0 || (end_ - begin_ != best_length && !agree(from, best_length, 0, off))) {
    rule_ = -1;
    return false;
  }
  state.v_dot = from.v_dot;
  pose_ = state.time;
  message_ =
      "begins at rest in a pose where constraints lose rank and several motions are possible: takes the one whose "
      "acceleration is nearest to that of the forces alone, in the metric of the mass";
  return true;
}

void SingularPose::history(Archive& archive) {
  archive("last", last_);
  archive("anchor", anchor_);
  archive("keep_until", keep_until_);
  last_ = std::clamp(last_, 0, kKept - 1), anchor_ = std::clamp(anchor_, -1, kKept - 1);
  std::vector<int> kept;
  for (int i = 0; i < kKept; ++i)
    if (kept_[i].q.size() > 0) kept.push_back(i);
  archive("kept", kept);
  for (int i : kept)
    if (i >= 0 && i < kKept) {
      archive("state " + std::to_string(i), kept_[i]);
      const Layout& layout = equations_.layout();
      if (kept_[i].q.size() != layout.q_count() || kept_[i].v.size() != layout.v_count())
        throw FileError("the checkpoint's earlier states do not fit the scene", archive.source(),
                        "resume from an older one");
    }
  archive("rule", rule_);
  if (rule_ < 0) return;
  rule_ = std::min(rule_, kRules - 1);
  archive("begin", begin_);
  archive("end", end_);
  archive("q_begin", q_begin_);
  archive("v_begin", v_begin_);
  archive("d_rates", d_rates_);
  archive("rates", rates_);
  archive("lambda", lambda_);  // where searches for reactions begin
}

}  // namespace lithe
