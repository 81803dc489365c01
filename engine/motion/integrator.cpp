#include "engine/motion/integrator.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "engine/archive/archive.h"
#include "engine/base/error.h"
#include "engine/motion/singular_pose.h"

namespace lithe {
namespace {

/// The polynomial of degree 5 in s, 0 <= s <= 1, from the origin at s = 0 to `end` at s = 1, with given first and
/// second derivatives by time at both; h = its length in time.
template <class Vector>
struct Quintic {
  Vector value, rate, acceleration;

  Quintic(double s, double h, const Vector& rate_0, const Vector& acceleration_0, const Vector& end,
          const Vector& rate_1, const Vector& acceleration_1) {
    const Vector c1 = h * rate_0, c2 = 0.5 * h * h * acceleration_0;
    const Vector a = end - c1 - c2, b = h * rate_1 - c1 - 2 * c2, c = 0.5 * h * h * acceleration_1 - c2;
    const Vector c3 = 10 * a - 4 * b + c, c4 = -15 * a + 7 * b - 2 * c, c5 = 6 * a - 3 * b + c;
    value = s * (c1 + s * (c2 + s * (c3 + s * (c4 + s * c5))));
    rate = (c1 + s * (2 * c2 + s * (3 * c3 + s * (4 * c4 + s * 5 * c5)))) / h;
    acceleration = (2 * c2 + s * (6 * c3 + s * (12 * c4 + s * 20 * c5))) / (h * h);
  }
};

/// The rotation vector of e_from -> e_to; of the two short of a full turn, the one nearer to the mean motion.
Vector3 turn_between(const Vector4& e_from, const Vector4& e_to, const Vector3& mean) {
  const Vector4 turn = quaternion_product({e_from[0], -e_from[1], -e_from[2], -e_from[3]}, e_to);
  const double s = turn.tail<3>().norm(), half = std::atan2(s, turn[0]);
  const Vector3 psi = (s > 1e-300 ? 2 * half / s : 2.0) * turn.tail<3>();
  const double angle = psi.norm();
  if (!(angle > 0)) return psi;
  const Vector3 other = (1 - 2 * M_PI / angle) * psi;
  return (other - mean).squaredNorm() < (psi - mean).squaredNorm() ? other : psi;
}

void recall(EquationsOfMotion& equations, const State& state) {
  equations.memory().recall(state.quarter_turns);
  equations.memory().recall_rows(state.left_out);
  equations.memory().recall(state.contacts);
}

}  // namespace

IntegratorStatistics& IntegratorStatistics::operator+=(const IntegratorStatistics& later) {
  steps += later.steps, rejected += later.rejected, newton_iterations += later.newton_iterations;
  factorizations += later.factorizations, evaluations += later.evaluations;
  newton_failures += later.newton_failures;
  if (later.limiting >= 0) limiting = later.limiting;
  return *this;
}

void IntegratorStatistics::keep(Archive& archive, std::string_view name) {
  std::array<long, 7> counts{steps,       rejected,        newton_iterations, factorizations,
                             evaluations, newton_failures, limiting};
  archive(name, counts);
  *this = {counts[0], counts[1], counts[2], counts[3], counts[4], counts[5], static_cast<int>(counts[6])};
}

Integrator::Integrator() = default;
Integrator::~Integrator() = default;

void Integrator::start(EquationsOfMotion& equations, State& state) {
  if (equations.parts().rigid_contacts && !handles_rigid_contacts())
    throw SceneError(
        name() + " does not support contact between rigid surfaces, nor set-valued friction in joints",
        "Integrator::start",
        "take MoreauJean or NonsmoothGeneralizedAlpha; or give contacts a compliant law: {.law = Compliance{...}}, and "
        "joints JointBristles");
  recall(equations, state);
  equations.memory().track_contacts(state);
  equations.memory().recall(state.contacts);
  quarter_turns_ = state.quarter_turns;
  turn_rates_.setZero(quarter_turns_.size());
  last_length_ = 0;
  longest_ = std::numeric_limits<double>::infinity();
  usual_ = looked_at_ = 0;
  singular_pose_.reset();
  VectorX begins;  // v̇, where the equations do not tell it
  if (!delegates() && equations.facts().has_loops) {
    singular_pose_ = std::make_unique<SingularPose>(equations);
    if (singular_pose_->leave(state)) begins = state.v_dot;
    equations.memory().recall_rows(state.left_out);
  }
  prepare(equations, state);
  if (begins.size() > 0) state.v_dot = begins;
  equations.memory().track_rows(state.left_out);
}

StepResult Integrator::step(EquationsOfMotion& equations, State& state, double t_stop, Multipliers multipliers) {
  multipliers_ = multipliers;
  recall(equations, state);
  quarter_turns_ = state.quarter_turns;
  const double begin = state.time, until = std::min(t_stop, begin + longest_);
  const bool watches = !delegates() && equations.facts().has_loops;
  constexpr double kCreeps = 1e-5;  // of usual steps: round-off moves what these reach
  StepResult result;
  const bool on_the_way = watches && singular_pose_->covers(begin);
  const bool sees = !on_the_way && chooses_steps() && quarter_turns_.size() > 0;
  if (sees) before_ = state;
  if (on_the_way) {
    result.why = pass_singular_pose(equations, state, until);
  } else {
    if (watches) singular_pose_->remember(state);
    result = advance(equations, state, until);
    // What a step has reached that shrank near a singular pose is mostly noise: the way across begins before it.
    if (watches && (!result.ok() || has_shrunk(state.time - begin, state.time == t_stop))) {
      std::vector<int> left_out;
      equations.memory().track_rows(left_out);
      if (const std::string passed = pass_singular_pose(equations, state, until); !passed.empty()) {
        result = {StepResult::Outcome::reached, passed};
      } else {
        equations.memory().recall_rows(left_out);
        if (result.ok()) equations.evaluate(state.time, state.q, state.v, Level::velocity);
        if (singular_pose_->is_blocked() && state.time - begin < kCreeps * usual_ && state.time < t_stop)
          result = {StepResult::Outcome::failed,
                    (result.ok() ? "steps have come down to " + step_text(state.time - begin) : result.why) +
                        "; constraints lose rank at t = " + std::to_string(singular_pose_->pose()) +
                        " s, and no smooth way leads across that pose"};
      }
    }
  }
  if (!result.ok()) return result;
  track(equations, state);
  if (sees && equations.memory().loses_angle(state)) {
    result = see_angles(equations, state);
    if (!result.ok()) return result;
  }
  if (!delegates()) equations.memory().check(state);  // else the inner method has
  if (turn_rates_.size() > 0 && turn_rates_.size() == state.quarter_turns.size())
    limit_turn(state.quarter_turns, state.time - begin);
  return result;
}

void Integrator::track(EquationsOfMotion& equations, State& state) const {
  equations.memory().track(state.quarter_turns);
  equations.memory().track_rows(state.left_out);
  equations.memory().track_contacts(state);
}

/// The step that has lost an angle anew and shorter, until it sees the way round; the method begins anew in it. If none
/// does, the last one tried is left, of which check() tells.
StepResult Integrator::see_angles(EquationsOfMotion& equations, State& state) {
  constexpr int kMost = 20;  // to 1e-12 of the step
  constexpr double kShorter = 0.25;
  StepResult result;
  double length = state.time - before_.time;
  for (int k = 0; k < kMost; ++k) {
    length *= kShorter;
    if (!(before_.time + length > before_.time)) break;
    state = before_;
    recall(equations, state);
    resumes_ = true;
    prepare(equations, state);
    resumes_ = false;
    result = advance(equations, state, before_.time + length);
    if (!result.ok()) break;
    track(equations, state);
    if (!equations.memory().loses_angle(state)) break;
  }
  return result;
}

/// Whether steps have become so short that it is worth looking for a singular pose ahead. A step that t_stop cut tells
/// nothing.
bool Integrator::has_shrunk(double length, bool cut) {
  constexpr double kShort = 1.0 / 16, kAgain = 1.0 / 4, kForget = 0.95;
  if (cut && length < usual_) return false;
  usual_ = std::max(length, kForget * usual_);
  if (length > kShort * usual_) {
    looked_at_ = 0;
    return false;
  }
  if (looked_at_ > 0 && length >= kAgain * looked_at_) return false;
  looked_at_ = length;
  return true;
}

/// Begins or goes on along a way across singular poses, a piece of it; behind it the method begins anew. What the log
/// is to say of it; empty: none was found.
std::string Integrator::pass_singular_pose(EquationsOfMotion& equations, State& state, double until) {
  constexpr double kShortest = 1.0 / 16;  // of the usual step
  if (!singular_pose_->covers(state.time) && !singular_pose_->cross(state, std::max(looked_at_, kShortest * usual_))) {
    lose_factor();
    return "";
  }
  singular_pose_->follow(state, singular_pose_->next_stop(state.time, until));
  const std::string message = singular_pose_->take_message();
  if (singular_pose_->covers(state.time)) return message;
  resumes_ = true;
  prepare(equations, state);
  resumes_ = false;
  usual_ = looked_at_ = 0;
  return message;
}

bool Integrator::history(Archive& archive, EquationsOfMotion& equations, const State& state) {
  archive("turn_rates", turn_rates_);
  archive("last_length", last_length_);
  archive("longest", longest_);
  archive("usual", usual_);
  archive("looked_at", looked_at_);
  if (singular_pose_) archive.group("singular pose", [&] { singular_pose_->history(archive); });
  return keep(archive, equations, state);
}

/// From the mean rates of the last two steps, how long the next may be for its fastest angle to move by 1.6 quarter
/// turns: automatic steps would else outgrow half a turn where a body spins steadily, and turns be lost.
void Integrator::limit_turn(const VectorX& quarter_turns, double length) {
  constexpr double kFarthest = 1.6, kLargestGrowth = 10;  // of a step over the one before
  if (!(length > 0)) return;
  quarter_turns_ = (quarter_turns - quarter_turns_) / length;
  const double rate = quarter_turns_.cwiseAbs().maxCoeff();
  const double growth = 2 * (quarter_turns_ - turn_rates_).cwiseAbs().maxCoeff() / (length + last_length_);
  const double now = rate + growth * length / 2;
  turn_rates_.swap(quarter_turns_);
  last_length_ = length;
  longest_ = std::numeric_limits<double>::infinity();
  const double allowed = 2 * kFarthest / (now + std::sqrt(now * now + 2 * growth * kFarthest));
  if (allowed < kLargestGrowth * length)  // in whole steps, so that fixed ones stay as they are
    longest_ = allowed > length ? std::floor(allowed / length) * length : allowed;
}

void Integrator::interpolate(const Layout& layout, const State& from, const State& to, double time, State& out) const {
  const double h = to.time - from.time;
  if (!(h > 0)) {
    out = from;
    return;
  }
  const double s = (time - from.time) / h;
  out.time = time;
  out.q.resize(from.q.size());
  for (VectorX* x : {&out.v, &out.v_dot}) x->resize(from.v.size());
  if (from.lambda.size() == to.lambda.size())
    out.lambda = (1 - s) * from.lambda + s * to.lambda;
  else
    out.lambda.resize(0);  // one end was left without
  out.quarter_turns = from.quarter_turns;
  out.left_out = to.left_out;
  out.contacts = from.contacts;
  for (const Layout::BodySlice& b : layout.bodies()) {
    int iq = b.q, iv = b.v;
    if (b.frame) {
      const auto at = [&](const VectorX& x, int place) -> Vector3 { return x.segment<3>(iv + place); };
      const Quintic<Vector3> p(s, h, at(from.v, 0), at(from.v_dot, 0), to.q.segment<3>(iq) - from.q.segment<3>(iq),
                               at(to.v, 0), at(to.v_dot, 0));
      out.q.segment<3>(iq) = from.q.segment<3>(iq) + p.value;
      out.v.segment<3>(iv) = p.rate;
      out.v_dot.segment<3>(iv) = p.acceleration;
      // Rotations in the chart of `from`:  ω = Jr ψ̇,  ω̇ = Jr ψ̈ + J̇r ψ̇,  where Jr(ψ) = Jl(-ψ), so that J̇r ψ̇ =
      // -left_jacobian_rate(-ψ, -ψ̇). At its origin ψ̇ = ω and ψ̈ = ω̇.
      const Vector4 e = from.q.segment<4>(iq + 3);
      const Vector3 end = turn_between(e, to.q.segment<4>(iq + 3), 0.5 * h * (at(from.v, 3) + at(to.v, 3)));
      const Matrix3 inverse = right_jacobian_inverse(end);
      const Vector3 rate = inverse * at(to.v, 3);
      const Vector3 acceleration = inverse * (at(to.v_dot, 3) + left_jacobian_rate(-end, -rate));
      const Quintic<Vector3> psi(s, h, at(from.v, 3), at(from.v_dot, 3), end, rate, acceleration);
      const Matrix3 Jr = left_jacobian(-psi.value);
      out.q.segment<4>(iq + 3) = rotated(e, psi.value);
      out.v.segment<3>(iv + 3) = Jr * psi.rate;
      out.v_dot.segment<3>(iv + 3) = Jr * psi.acceleration - left_jacobian_rate(-psi.value, -psi.rate);
      iq += 7, iv += 6;
    }
    for (int i = 0; i < b.linear; ++i) {
      const Quintic<double> eta(s, h, from.v[iv + i], from.v_dot[iv + i], to.q[iq + i] - from.q[iq + i], to.v[iv + i],
                                to.v_dot[iv + i]);
      out.q[iq + i] = from.q[iq + i] + eta.value;
      out.v[iv + i] = eta.rate;
      out.v_dot[iv + i] = eta.acceleration;
    }
  }
}

std::string step_text(double h) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2g s", h);
  return text;
}

double error_ratio(ConstVectorRef error, ConstVectorRef magnitudes, const Tolerance& tolerance) {
  double sum = 0;
  for (Eigen::Index i = 0; i < error.size(); ++i) {
    const double ratio = error[i] / (tolerance.absolute + tolerance.relative * magnitudes[i]);
    sum += ratio * ratio;
  }
  return error.size() > 0 ? std::sqrt(sum / static_cast<double>(error.size())) : 0;
}

int largest_share(ConstVectorRef error, ConstVectorRef magnitudes, const Tolerance& tolerance) {
  int largest = -1;
  double share = -1;
  for (Eigen::Index i = 0; i < error.size(); ++i) {
    const double ratio = std::abs(error[i]) / (tolerance.absolute + tolerance.relative * magnitudes[i]);
    if (ratio <= share) continue;  // one that is not finite is named
    largest = static_cast<int>(i);
    if (std::isnan(ratio)) break;
    share = ratio;
  }
  return largest;
}

}  // namespace lithe
