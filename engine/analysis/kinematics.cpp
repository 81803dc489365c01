#include "engine/analysis/kinematics.h"

#include <algorithm>
#include <cmath>

#include "engine/analysis/free_motions.h"
#include "engine/archive/archive.h"
#include "engine/assembly/evaluator.h"
#include "engine/base/checks.h"
#include "engine/base/error.h"
#include "engine/base/number_text.h"

namespace lithe {
namespace {

constexpr int kMaxIterations = 25;
constexpr double kSmallestStep = 1e-6;  // of the step asked for
// A correction that moves bodies farther than this beside the prediction may have changed to another way of assembly.
constexpr double kFarShare = 0.5, kFarFloor = 0.05;  // share of the predicted move; m, rad
constexpr double kRateTolerance = 1e-7;              // of ġ beside |∂g/∂t| and |v|
// At a change point two ways of assembly cross; only one goes on with the velocity that the mechanism had.
constexpr double kVelocityJump = 0.3,
                 kFromRest = 0.1;    // of v; below kFromRest of the new v there is nothing to compare
constexpr double kAtRest = 1e-6;     // of the speed before
constexpr double kNearby = 1e-3;     // of the step: so near to a change point velocities may be carried on
constexpr double kCarriedOn = 1e-2;  // of ġ beside |v|, for velocities carried on

}  // namespace

Kinematics::Kinematics(Parameters parameters) : parameters_(parameters) {
  require::at("Kinematics", [&] {
    require::positive(parameters.step, "step");
    require::positive(parameters.tolerance, "tolerance");
  });
}

void Kinematics::prepare(EquationsOfMotion& equations, State& state) {
  const Layout& layout = equations.layout();
  statistics_ = {};
  predicted_.setZero(layout.v_count());
  moved_.setZero(layout.v_count());
  rows_.setZero(layout.row_count());

  equations.evaluate(state.time, state.q, state.v, Level::velocity);
  const int driven = layout.row_count() - static_cast<int>(equations.redundant_rows().size());
  if (driven < layout.v_count()) {
    const std::vector<FreeMotion> free = free_motions(equations);
    std::string names;
    for (std::size_t k = 0; k < free.size() && k < 10; ++k) names += (k ? ", " : "") + free[k].name;
    if (free.size() > 10) names += ", …";
    throw SceneError("the motion is not prescribed: " + std::to_string(layout.v_count() - driven) +
                         " freedoms remain (" + names + ")",
                     "Kinematics", "drive them too, or run the dynamics with the drives as they are");
  }
  state.v.setZero();
  state.v_dot.setZero(layout.v_count());
  state.lambda.setZero(layout.row_count());
  if (!reach(equations, state.time, state))
    throw SimulationError("the mechanism cannot be placed where its drives begin: " + worst(equations, state.time),
                          time_text(state.time) + ", kinematic analysis",
                          "draw it nearer to that pose, or let the drives begin where it is drawn");
}

/// Places trial_ = state at `time`: positions from the prediction, then velocities, accelerations, multipliers.
bool Kinematics::reach(EquationsOfMotion& equations, double time, State& state) {
  const Layout& layout = equations.layout();
  const double h = time - state.time;
  trial_ = state;
  trial_.time = time;
  predicted_ = h * state.v + 0.5 * h * h * state.v_dot;
  layout.retract(state.q, predicted_, trial_.q);
  VectorX q_predicted = trial_.q;

  // 1. Positions, without a change to another way of assembly.
  Projector projector(equations);
  const auto placed = projector.position(time, trial_.q, parameters_.tolerance, kMaxIterations);
  statistics_.newton_iterations += placed.iterations;
  ++statistics_.evaluations;
  if (!placed.converged || !trial_.q.allFinite() || placed.residual > 1e-8) return false;
  layout.difference(q_predicted, trial_.q, moved_);
  if (h != 0 && moved_.lpNorm<Eigen::Infinity>() > kFarShare * predicted_.lpNorm<Eigen::Infinity>() + kFarFloor)
    return false;

  // 2. Velocities. Against a lock no velocity satisfies the rows; at a change point more than one does.
  const VectorX v_expected = state.v + h * state.v_dot;
  const auto rate_error = [&](const VectorX& v) {
    equations.evaluate(time, trial_.q, v, Level::velocity);
    equations.constraint(Level::velocity, rows_);
    return rows_.lpNorm<Eigen::Infinity>();
  };
  const double asked = rate_error(VectorX::Zero(layout.v_count()));
  for (int round = 0; round < 2; ++round) projector.velocity(time, trial_.q, trial_.v);  // the second fixes round-off
  const double speed = trial_.v.lpNorm<Eigen::Infinity>(), former = state.v.lpNorm<Eigen::Infinity>();
  const bool solved = trial_.v.allFinite() && rate_error(trial_.v) <= kRateTolerance * (asked + 1e-9 * speed) + 1e-12;
  // A drive that ends at rest slows down by more than its acceleration at the step's start tells, at any step.
  const double change = h * state.v_dot.lpNorm<Eigen::Infinity>();
  const bool rests = speed <= kAtRest * former && former <= change;
  const bool smooth = h == 0 || rests || former <= kFromRest * speed ||
                      (trial_.v - v_expected).lpNorm<Eigen::Infinity>() <= kVelocityJump * (former + change);

  // 3. Accelerations and the forces of drives and joints.
  if (solved && smooth) {
    projector.accelerations(time, trial_.q, trial_.v, trial_.v_dot, trial_.lambda);
    ++statistics_.factorizations;
    if (trial_.v_dot.allFinite() && trial_.lambda.allFinite()) {
      state = trial_;
      return true;
    }
  }
  // 4. Upon a change point the rows do not tell: what was true just before is carried on.
  if (!(h > 0 && h <= kNearby * parameters_.step) || rate_error(v_expected) > kCarriedOn * (asked + former))
    return false;
  trial_.v = v_expected;
  trial_.v_dot = state.v_dot, trial_.lambda = state.lambda;
  state = trial_;
  return true;
}

StepResult Kinematics::advance(EquationsOfMotion& equations, State& state, double t_stop) {
  // The step shrinks until the time is reached; below kSmallestStep of it the mechanism is locked.
  double h = std::min(parameters_.step, t_stop - state.time);
  if (t_stop - state.time < 1.5 * h) h = t_stop - state.time;
  const double smallest = kSmallestStep * h;
  for (; h >= smallest; h /= 2, ++statistics_.rejected) {
    const double time = h == t_stop - state.time ? t_stop : state.time + h;
    if (!reach(equations, time, state)) continue;
    ++statistics_.steps;
    return {};
  }
  return {StepResult::Outcome::failed, "the mechanism cannot follow its drives (lock-up or dead centre): " +
                                           worst(equations, state.time + 2 * smallest)};
}

bool Kinematics::keep(Archive& archive, EquationsOfMotion& /*equations*/, const State& /*state*/) {
  archive.same("step", parameters_.step);
  archive.same("tolerance", parameters_.tolerance);
  archive("statistics", statistics_);
  return true;
}

/// The row that the last trial violates most.
std::string Kinematics::worst(EquationsOfMotion& equations, double time) {
  int row = 0;
  equations.evaluate(time, trial_.q, trial_.v, Level::velocity);
  for (const Level level : {Level::position, Level::velocity}) {
    equations.constraint(level, rows_);
    const double off = rows_.cwiseAbs().maxCoeff(&row);
    if (off > 1e-9 || level == Level::velocity)
      return equations.layout().row_name(row) +
             (level == Level::position ? " stays off by " : " moves off at a rate of ") +
             step_text(off).substr(0, step_text(off).find(' '));
  }
  return "";
}

Sensor drive_force(const Constraint& drive, Located name) {
  if (name.text.empty()) name.text = drive.name() + "_drive";
  const std::string column = name.text;
  return {std::move(name), {column}, [&drive](Snapshot& now, std::span<double> values) {
            const Layout::RowSlice& rows = now.system().rows(drive);
            values[0] = -now.multipliers()[rows.first + rows.count - 1];
          }};
}

Sensor drive_power(const Constraint& drive, Located name) {
  if (name.text.empty()) name.text = drive.name() + "_power";
  const std::string column = name.text;
  return {std::move(name), {column}, [&drive](Snapshot& now, std::span<double> values) {
            const Layout::RowSlice& rows = now.system().rows(drive);
            const VectorX& rate = now.evaluator().workspace().rate;
            values[0] = now.multipliers().segment(rows.first, rows.count).dot(rate.segment(rows.first, rows.count));
          }};
}

}  // namespace lithe
