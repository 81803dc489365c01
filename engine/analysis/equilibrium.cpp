#include "engine/analysis/equilibrium.h"

#include <algorithm>
#include <limits>

#include "engine/analysis/rest_stability.h"
#include "engine/analysis/static_equations.h"
#include "engine/assembly/least_norm.h"
#include "engine/base/error.h"
#include "engine/base/log.h"
#include "engine/base/number_text.h"
#include "engine/motion/projection.h"
#include "engine/observe/observer.h"

namespace lithe {
namespace {

constexpr double kFarthest = 0.3;      // rad, or of the size of the scene: what a step may turn and move
constexpr double kSmooth = 1e-5;       // of the size of the scene, or rad: for differences of the balance
constexpr double kSmoother = 1e-4;     // likewise, for those of fourth order
constexpr double kLeast = 1e-4;        // of the shift σ, 1/s²
constexpr double kMost = 1e16;         // likewise; where it is reached nothing helps
constexpr double kContraction = 0.7;   // of a correction beside the one before
constexpr double kSettled = 1e-4;      // of corrections beside the step: the rest is left to the next one
constexpr double kGood = 0.05;         // likewise, where they do not contract any more
constexpr int kMaxTangents = 8;        // a step, besides its own
constexpr int kMaxCorrections = 15;    // a step
constexpr double kLeastShare = 0.02;   // of a step; below, the shift grows
constexpr int kMaxTries = 2;           // shares of a step, each 0.3 of the last
constexpr double kLonger = 2;          // a share beside the one taken last
constexpr double kGrowth = 10;         // of the shift where a step is refused without saying by how much
constexpr double kRowsClosed = 1e-9;   // |g| of an equilibrium
constexpr double kHardlyMoves = 1e-6;  // m, rad: too small a move to judge the energy by
constexpr double kHeld = 1e-13;        // of the size of the scene, or rad: a step of round-off, joints hold everything
constexpr double kPerfect = 1e-15;     // out of balance, of the force scale

void tell_stability(const Layout& layout, const Equilibrium& found) {
  if (found.stability != RestStability::unstable) return;
  int largest = 0;
  found.softest.cwiseAbs().maxCoeff(&largest);
  log::warn("find_equilibrium: the rest found is " + found.stability_text() +
            ": a motion away from it, most of all of " + layout.velocity_name(largest) + ", grows e-fold in " +
            three_digits(1 / std::sqrt(-found.lowest_stiffness)) +
            " s\n  fix:  start aside of it where another rest is wanted.");
}

/// Newton's way from a start at rest to the balance.
class Search {
 public:
  Search(Evaluator& equations, State& state, double force_scale, double tolerance)
      : equations_(equations),
        layout_(equations.layout()),
        balance_(equations),
        state_(state),
        force_scale_(force_scale),
        tolerance_(tolerance) {
    balance_.leave_out_redundant(state_.lambda);
    balance_.evaluate(state_.time, state_.q, state_.lambda);
    size_ = size_of_scene();
    look();
  }

  void run(int max_steps, Equilibrium& found) {
    double longest_share = 1;  // that is worth a try
    int steps = 0;
    for (; steps < max_steps && shift_ < kMost && out_of_balance_ > kPerfect * force_scale_; ++steps) {
      if (!find_step()) {
        if (balanced_) break;
        shift_ *= kGrowth * kGrowth;
        continue;
      }
      // Stiffness along the step, and whether the energy is convex there.
      const double convex = gap_.dot(step_lambda_) - force_.dot(step_);
      const double inertia = std::max(step_.dot(inertial_), std::numeric_limits<double>::min());
      const bool moves = step_.lpNorm<Eigen::Infinity>() > kHardlyMoves;
      const double stiffness = moves ? convex / inertia - shift_ : 0;  // of round-off it could be anything
      if (!(convex > 0) && moves) {
        if (balanced_) break;
        shift_ = std::max(1.2 * -stiffness, 2 * shift_);
        continue;
      }
      const double far = farthest_move() / kFarthest;
      if (far * kLeastShare > 1) {
        shift_ = (stiffness + shift_) * far - stiffness;
        continue;
      }
      const double share = take(std::min({1.0, 1 / far, longest_share}));
      longest_share = share > 0 ? kLonger * share : 1;
      if (share == 0) {
        if (balanced_) break;
        shift_ = std::max(kGrowth * shift_, 3 * stiffness);
        continue;
      }
      const double before = out_of_balance_;
      const bool was_balanced = balanced_;
      look();
      if (was_balanced && !(balanced_ && out_of_balance_ < 0.5 * before)) {  // round-off ends progress
        if (!(balanced_ && out_of_balance_ <= before)) go_back();
        break;
      }
      if (share < 1 || shift_ > kLeast) ++found.load_steps;
      keep();
      const double longer = std::clamp(share * far, 1e-2, 1.0);
      shift_ = std::max(kLeast, (stiffness + shift_) * longer - stiffness);
    }
    used_up_ = steps == max_steps;
    found.iterations = iterations_;
    found.out_of_balance = out_of_balance_;
    found.round_off = balance_.round_off().size() > 0 ? balance_.round_off().maxCoeff() : 0;
  }

  /// Of the rest that was found.
  void judge(Equilibrium& found) { judge_rest(balance_, kSmoother * std::min(size_, 1.0), found); }

  bool balanced() const { return balanced_; }
  /// Whether more steps might get there.
  bool used_up() const { return used_up_; }
  int worst() const { return worst_; }
  double gap() const { return balance_.largest_gap(); }

 private:
  /// How far the state is from balance; force and gap are that state's.
  void look() {
    force_ = balance_.force;
    gap_ = balance_.gap;
    out_of_balance_ = force_.size() > 0 ? force_.cwiseAbs().maxCoeff(&worst_) : 0;
    balanced_ = force_.allFinite() && balance_.largest_gap() < kRowsClosed;
    for (int i = 0; i < force_.size() && balanced_; ++i)
      balanced_ = std::abs(force_[i]) <= std::max(tolerance_ * force_scale_, balance_.round_off()[i]);
  }

  bool factorize() {
    ++iterations_;
    return balance_.factorize(shift_, state_.lambda);
  }

  bool find_step() {
    if (!factorize()) return false;
    look();  // round-off is known now
    step_ = -force_;
    step_lambda_ = -gap_;
    if (!balance_.solve_exactly(step_, step_lambda_, state_.lambda, kSmooth * size_)) return false;
    inertial_ = balance_.mass_times(step_, state_.lambda);
    return true;
  }

  /// Of the step: the largest turn of a frame or marker, and the largest way beside the size of the scene.
  double farthest_move() {
    double turn = 0, way = 0;
    const auto add = [&](const Vector3& v, const Vector3& w) {
      turn = std::max(turn, w.norm()), way = std::max(way, v.norm());
    };
    for (const auto& b : layout_.bodies())
      if (b.frame) add(step_.segment<3>(b.v), step_.segment<3>(b.v + 3));
    equations_.evaluate(state_.time, state_.q, step_, Level::acceleration);
    for (const MarkerKinematics& marker : equations_.workspace().markers) add(marker.v, marker.w);
    balance_.evaluate(state_.time, state_.q, state_.lambda);
    return std::max(turn, way / size_);
  }

  /// Of the box around all markers and frames.
  double size_of_scene() const {
    Eigen::AlignedBox3d box;
    for (const auto& b : layout_.bodies())
      if (b.frame) box.extend(Vector3(state_.q.segment<3>(b.q)));
    for (const MarkerKinematics& marker : equations_.workspace().markers) box.extend(marker.p);
    const double size = box.isEmpty() ? 0 : box.sizes().maxCoeff();
    return size > 0 ? size : 1;
  }

  /// Moves on by the largest good share of the step, from the given one downwards; 0: none is good.
  double take(double share) {
    const State before = state_;
    for (int tries = 0; tries < kMaxTries; ++tries, share *= 0.3)
      if (follow(before, share)) {
        last_q_ = before.q, last_lambda_ = before.lambda;
        return share;
      }
    state_ = before;
    balance_.evaluate(state_.time, state_.q, state_.lambda);
    return 0;
  }

  /// To the balance with what a share of the step leaves for later held back. Corrections come from the last factor
  /// as long as they contract; then with one made where they have come to. False: they do not contract.
  bool follow(const State& before, double share) {
    VectorX d = share * step_, c, c_lambda;
    state_.lambda = before.lambda + share * step_lambda_;
    // Where joints hold everything there is no motion whose contraction could be judged: reactions alone do it.
    if (!balanced_ && step_.lpNorm<Eigen::Infinity>() <= kHeld * std::max(1.0, size_)) {
      balance_.evaluate(state_.time, state_.q, state_.lambda);
      if (balance_.force.lpNorm<Eigen::Infinity>() < 0.1 * share * out_of_balance_) return true;
    }
    const double length = share * std::sqrt(step_.dot(inertial_));
    double last = length;
    int tangents = 0;
    const bool polish = balanced_;
    for (int k = 0; k < kMaxCorrections; ++k) {
      layout_.retract(before.q, d, state_.q);
      balance_.evaluate(state_.time, state_.q, state_.lambda);
      if (!balance_.force.allFinite()) return false;
      double size = 0;
      for (bool again : {false, true}) {
        if (again && polish) return true;  // judged by what it leaves out of balance
        if (again && k > 0 && last <= kGood * length) return true;
        if (again && (!factorize() || ++tangents > kMaxTangents)) return false;
        c = (1 - share) * force_ - balance_.force - shift_ * balance_.mass_times(d, state_.lambda);
        c_lambda = (1 - share) * gap_ - balance_.gap;
        const bool solved =
            again ? balance_.solve_exactly(c, c_lambda, state_.lambda, kSmooth * size_) : balance_.solve(c, c_lambda);
        size = solved ? std::sqrt(std::max(0.0, c.dot(balance_.mass_times(c, state_.lambda)))) : 1e300;
        if (size <= kContraction * (again ? length : last)) break;
        if (again) return false;
      }
      d += c;
      state_.lambda += c_lambda;
      last = size;
      if (size <= kSettled * length) break;
    }
    layout_.retract(before.q, d, state_.q);
    balance_.evaluate(state_.time, state_.q, state_.lambda);
    return balance_.force.allFinite();
  }

  void keep() {
    equations_.track(state_.quarter_turns);
    equations_.recall(state_.quarter_turns);
  }
  void go_back() {
    state_.q = last_q_, state_.lambda = last_lambda_;
    balance_.evaluate(state_.time, state_.q, state_.lambda);
    look();
  }

  Evaluator& equations_;
  const Layout& layout_;
  StaticEquations balance_;
  State& state_;
  const double force_scale_, tolerance_;
  double shift_ = kLeast, out_of_balance_ = 0, size_ = 1;  // of the scene, m
  bool balanced_ = false, used_up_ = false;
  int worst_ = 0, iterations_ = 0;
  VectorX force_, gap_, step_, step_lambda_, inertial_, last_q_, last_lambda_;
};

}  // namespace

std::string Equilibrium::stability_text() const {
  const char* const word = stability == RestStability::stable     ? "stable"
                           : stability == RestStability::unstable ? "unstable"
                                                                  : "of unknown stability";
  return word + (", lowest stiffness " + three_digits(lowest_stiffness) + " 1/s²");
}

Equilibrium find_equilibrium(const System& system, const State& start, const EquilibriumOptions& options) {
  const Layout& layout = system.layout();
  if (start.q.size() != layout.q_count())
    throw SceneError("the state to start from belongs to another system", "find_equilibrium",
                     "start from system.initial_state()");
  Evaluator equations(system);
  equations.recall(start.quarter_turns);
  Projector projector(equations);

  // 1. Rest at the start: positions on the constraints; the scale of forces from the loads, and from the reactions that
  // they would cause in motion.
  Equilibrium found;
  State& state = found.state;
  state = start;
  state.v.setZero(layout.v_count());
  state.v_dot.setZero(layout.v_count());
  state.lambda.setZero(layout.row_count());
  projector.position(state.time, state.q, 1e-13, 50);
  VectorX unloaded = state.v;
  equations.evaluate(state.time, state.q, state.v, Level::velocity);
  equations.residual(state.v, state.lambda, unloaded);
  projector.accelerations(state.time, state.q, state.v, state.v_dot, state.lambda);
  const double force_scale = std::max({unloaded.lpNorm<Eigen::Infinity>(),
                                       state.lambda.size() > 0 ? state.lambda.lpNorm<Eigen::Infinity>() : 0.0, 1e-12});
  state.lambda.setZero();  // so that what is held back is a share of the loads alone

  // 2. Newton, until the balance is as good as round-off lets it be.
  Search search(equations, state, force_scale, options.tolerance);
  search.run(options.max_load_steps, found);

  // 3. Rest, or no rest.
  if (!search.balanced())
    throw SimulationError("no equilibrium was found in " + std::to_string(found.iterations) +
                              " iterations: " + layout.velocity_name(search.worst()) + " stays out of balance by " +
                              three_digits(found.out_of_balance) + " (N or N m), joints are off by " +
                              three_digits(search.gap()),
                          "find_equilibrium, " + time_text(state.time),
                          (search.used_up() ? "max_load_steps are used up: give more; " : "") +
                              std::string("does anything hold it? Add a spring, a joint or a lock; or start nearer to "
                                          "the equilibrium"));
  state.v.setZero();
  state.v_dot.setZero();
  search.judge(found);
  tell_stability(layout, found);
  equations.evaluate(state.time, state.q, state.v, Level::velocity);
  minimize_norm(equations, state.lambda);
  found.left_out = deflection_left_out(system, state);
  tell_left_out(found.left_out);
  return found;
}

}  // namespace lithe
