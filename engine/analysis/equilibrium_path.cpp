#include "engine/analysis/equilibrium_path.h"

#include <algorithm>
#include <cmath>

#include "engine/analysis/static_equations.h"
#include "engine/assembly/least_norm.h"
#include "engine/base/checks.h"
#include "engine/base/error.h"
#include "engine/base/number_text.h"
#include "engine/observe/observer.h"

namespace lithe {
namespace {

constexpr double kShift = 1e-4;       // 1/s²: what nothing holds keeps its place
constexpr double kRowsClosed = 1e-9;  // |g|
constexpr double kDifference = 1e-6;  // of the whole time, for derivatives by it
constexpr int kMaxIterations = 8;     // of Newton, a step
constexpr double kWanted = 5;         // likewise: even the shortest step of a stiff beam takes three
constexpr double kShortest = 1e-7;    // of the first step

class Path {
 public:
  Path(Evaluator& equations, const State& start, const EquilibriumPathOptions& options)
      : equations_(equations),
        layout_(equations.layout()),
        balance_(equations),
        options_(options),
        span_(options.end - start.time),
        state_(start) {}

  void run(EquilibriumPath& path) {
    find_tangent(true);
    if (!is_small())
      throw SceneError("the start is not in balance", "follow_equilibria", "take it from find_equilibrium()");
    path.states.push_back(state_);
    double step = options_.first_step;
    while (state_.time != options_.end) {
      if (static_cast<int>(path.states.size()) >= options_.max_states) fail("max_states are used up");
      if (path.states.size() > 1) find_tangent(false);
      const State from = state_;
      const VectorX tangent = tangent_;
      const double rate = rate_;
      int iterations = 0;
      while (true) {
        double length = std::min(step, options_.max_step / std::max(std::abs(rate), 1e-12));
        length = std::min(length, options_.max_turn / std::max(turn_of(tangent), 1e-12));
        const double left = (options_.end - from.time) / span_;  // of the whole time
        const bool last = rate > 0 && length * rate >= left * (1 - 1e-9);
        if (last) length = left / rate;
        iterations = advance(from, tangent, rate, length, last);
        if (iterations > 0) {
          step = length * std::clamp(std::sqrt(kWanted / iterations), 0.5, 2.0);
          break;
        }
        step = 0.25 * length;
        if (step < kShortest * options_.first_step) fail("Newton does not return to it");
      }
      last_tangent_ = tangent, last_rate_ = rate;
      equations_.track(state_.quarter_turns);
      equations_.recall(state_.quarter_turns);
      path.states.push_back(state_);
    }
    path.iterations = iterations_;
  }

 private:
  [[noreturn]] void fail(const std::string& why) const {
    throw SimulationError("the path of equilibria ends: " + why, "follow_equilibria, " + time_text(state_.time),
                          "give shorter steps, or look whether anything still holds the bodies there");
  }

  /// Whether force and gap of the state are zero.
  bool is_small() const {
    if (!balance_.force.allFinite() || !(balance_.largest_gap() < kRowsClosed)) return false;
    for (int i = 0; i < balance_.force.size(); ++i)
      if (!(std::abs(balance_.force[i]) <= std::max(options_.tolerance * force_scale_, balance_.round_off()[i])))
        return false;
    return true;
  }

  double turn_of(const VectorX& d) const {
    double turn = 0;
    for (const auto& b : layout_.bodies())
      if (b.frame) turn = std::max(turn, d.segment<3>(b.v + 3).norm());
    return turn;
  }

  /// a and its multipliers: how the balance moves with time, for the whole of it; the factor is the state's.
  bool find_drift(VectorX& a, VectorX& l) {
    const double h = kDifference * span_;
    balance_.evaluate(state_.time + h, state_.q, state_.lambda);
    a = balance_.force, l = balance_.gap;
    balance_.evaluate(state_.time - h, state_.q, state_.lambda);
    a = (balance_.force - a) / (2 * kDifference);
    l = (balance_.gap - l) / (2 * kDifference);
    force_scale_ = std::max(force_scale_, a.size() > 0 ? a.lpNorm<Eigen::Infinity>() : 0);
    balance_.evaluate(state_.time, state_.q, state_.lambda);
    return balance_.solve(a, l);
  }

  /// Unit tangent (tangent_, rate_) in the metric of the path; rate: of the whole time a unit of length.
  void find_tangent(bool first) {
    if (first) {
      balance_.leave_out_redundant(state_.lambda);
      balance_.evaluate(state_.time, state_.q, state_.lambda);
      if (state_.lambda.size() > 0) force_scale_ = state_.lambda.lpNorm<Eigen::Infinity>();
    }
    if (!balance_.factorize(kShift, state_.lambda) || !find_drift(tangent_, tangent_lambda_)) fail("it is singular");
    ++iterations_;
    inertial_ = balance_.mass_times(tangent_, state_.lambda);
    const double motion = tangent_.dot(inertial_);
    if (first) size_ = std::max(motion, 1e-300);
    rate_ = 1 / std::sqrt(motion / size_ + 1);
    if (!first && tangent_.dot(balance_.mass_times(last_tangent_, state_.lambda)) / size_ + last_rate_ < 0)
      rate_ = -rate_;  // it goes on as it came: the load turns round
    tangent_ *= rate_;
    inertial_ *= rate_;
    tangent_lambda_ *= rate_;
  }

  /// To the path, `length` further on; the number of Newton's iterations, 0: not reached.
  int advance(const State& from, const VectorX& tangent, double rate, double length, bool at_end) {
    const VectorX direction = inertial_ / size_;
    state_ = from;
    layout_.retract(from.q, length * tangent, state_.q);
    state_.lambda += length * tangent_lambda_;
    state_.time = at_end ? options_.end : from.time + length * rate * span_;
    VectorX a, l, d, d_lambda;
    double last = 0;
    for (int k = 1; k <= kMaxIterations; ++k) {
      balance_.evaluate(state_.time, state_.q, state_.lambda);
      if (!balance_.force.allFinite() || !balance_.factorize(kShift, state_.lambda)) break;
      ++iterations_;
      d = -balance_.force, d_lambda = -balance_.gap;
      const bool small = is_small();
      if (!balance_.solve(d, d_lambda)) break;
      if (!at_end) {
        if (!find_drift(a, l)) break;
        const double by = -direction.dot(d) / (direction.dot(a) + rate);
        d += by * a, d_lambda += by * l;
        state_.time += by * span_;
      }
      const double size = std::sqrt(std::max(d.dot(balance_.mass_times(d, state_.lambda)), 0.0) / size_);
      if (!(size < 0.5 * length) || (k > 2 && !small && size > 0.5 * last)) break;
      layout_.retract(state_.q, d, state_.q);
      state_.lambda += d_lambda;
      if (small) {
        balance_.evaluate(state_.time, state_.q, state_.lambda);
        return k;
      }
      last = size;
    }
    state_ = from;
    balance_.evaluate(state_.time, state_.q, state_.lambda);
    return 0;
  }

  Evaluator& equations_;
  const Layout& layout_;
  StaticEquations balance_;
  const EquilibriumPathOptions options_;
  const double span_;  // s, from start to end
  State state_;
  double force_scale_ = 0, size_ = 1, rate_ = 0, last_rate_ = 0;
  VectorX tangent_, tangent_lambda_, inertial_, last_tangent_;
  int iterations_ = 0;
};

}  // namespace

EquilibriumPath follow_equilibria(const System& system, const State& start, const EquilibriumPathOptions& options) {
  const Layout& layout = system.layout();
  require::at("follow_equilibria", [&] {
    require::finite(options.end, "end");
    require::positive(options.first_step, "first_step");
    require::positive(options.max_turn, "max_turn");
    require::positive(options.max_step, "max_step");
    require::positive(options.tolerance, "tolerance");
  });
  if (start.q.size() != layout.q_count() || start.lambda.size() != layout.row_count())
    throw SceneError("the state to start from belongs to another system", "follow_equilibria",
                     "start from find_equilibrium()");
  Evaluator equations(system);
  equations.recall(start.quarter_turns);
  State state = start;
  state.v.setZero(layout.v_count());
  state.v_dot.setZero(layout.v_count());
  EquilibriumPath path;
  Path(equations, state, options).run(path);
  for (State& s : path.states) {
    equations.recall(s.quarter_turns);
    equations.evaluate(s.time, s.q, s.v, Level::velocity);
    minimize_norm(equations, s.lambda);
  }
  return path;
}

}  // namespace lithe
