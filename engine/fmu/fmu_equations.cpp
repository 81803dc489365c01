#include "engine/fmu/fmu_equations.h"

#include <algorithm>
#include <cmath>

#include "engine/assembly/evaluator.h"
#include "engine/base/error.h"
#include "engine/base/number_text.h"
#include "engine/motion/projection.h"
#include "engine/observe/sensors.h"

namespace lithe {
namespace {

constexpr double kHysteresis = 1e-10;   // m, rad
constexpr double kElasticShare = 0.01;  // of the length
constexpr double kMove = 1e-3;          // of an input's range, or of its size

/// Forces an input as long as it lives.
struct Forced {
  const Input& input;
  Forced(const Input& forced, const Motion& motion) : input(forced) { input.force(motion); }
  ~Forced() { input.release(); }
  Forced(const Forced&) = delete;
  Forced& operator=(const Forced&) = delete;
};

/// All that the rows of joints say of a state.
VectorX rows_of(Evaluator& evaluator, const State& state) {
  const int count = evaluator.layout().row_count();
  VectorX rows(3 * count);
  evaluator.evaluate(state.time, state.q, state.v, Level::acceleration);
  int first = 0;
  for (const Level level : {Level::position, Level::velocity, Level::acceleration})
    evaluator.constraint(level, rows.segment(first, count)), first += count;
  return rows;
}

/// Whether joints feel an input: its value, or its rates.
bool prescribes_motion(const Input& input, Evaluator& evaluator, const State& state) {
  const auto& p = input.parameters();
  const double range = p.upper - p.lower;
  const double move = kMove * (std::isfinite(range) ? range : std::max(1.0, std::abs(p.value)));
  const auto rows_at = [&](const Motion& motion) {
    const Forced forced(input, motion);
    return rows_of(evaluator, state);
  };
  return rows_at({p.value, 0, 0}) != rows_at({p.value + move <= p.upper ? p.value + move : p.value - move, 1, 1});
}

}  // namespace

std::string FmuEquations::refusal(const System& system) {
  for (const ContactRecord& record : system.contacts()) {
    const std::string contact = "the contact '" + record.element->name() + "'";
    if (record.element->law() == ContactElement::Law::rigid)
      return contact + " acts by impulses, which time stepping alone knows";
    if (record.element->law() == ContactElement::Law::compliant && record.element->remembers())
      return contact + " remembers slip or the speed of impacts, which are no states";
  }
  Evaluator evaluator(system);
  for (const Input* input : system.graph().inputs())
    if (prescribes_motion(*input, evaluator, system.initial_state()))
      return "the input '" + input->name() + "' prescribes a motion, whose rates importers do not give";
  return "";
}

FmuEquations::FmuEquations(const System& system, double length)
    : system_(system), length_(length), kinks_(find_kinks(system)) {
  using Role = FmuVariable::Role;
  find_nominals();
  // Sensors have names and units of coordinates; with a dot for their dash, no sensor has the same.
  const auto add_states = [&](const Body& body, const Sensor& sensor) {
    for (std::size_t i = 0; i < sensor.columns().size(); ++i) {
      const int place = static_cast<int>(variables_.size());
      variables_.push_back({.name = body.name() + "." + sensor.columns()[i].substr(body.name().size() + 1),
                            .unit = sensor.unit(i),
                            .role = Role::state,
                            .nominal = nominals_[place],
                            .place = place});
    }
  };
  for (Sensor (*sensor)(const Body&, Located) : {coordinates, generalized_velocities})
    for (const Layout::BodySlice& b : system.layout().bodies())
      if (b.part == 0) add_states(*b.body, sensor(*b.body, ""));
  for (int i = 0; i < state_count(); ++i) {
    const auto& [name, unit] = std::pair(variables_[i].name, variables_[i].unit);
    const std::string rate = unit.empty() ? "" : unit.ends_with("/s") ? unit + "²" : unit + "/s";
    variables_.push_back({.name = "der(" + name + ")", .unit = rate, .role = Role::derivative, .place = i});
  }
  for (int i = 0; i < indicator_count(); ++i)
    variables_.push_back({.name = "kink " + std::to_string(i + 1) + " of " + kinks_[i].name,
                          .description = "changes sign where this force law changes its form",
                          .role = Role::indicator,
                          .place = i});
}

void FmuEquations::find_nominals() {
  const Layout& layout = system_.layout();
  const State& drawn = system_.initial_state();
  Evaluator evaluator(system_);
  const VectorX still = VectorX::Zero(layout.v_count()), no_load = VectorX::Zero(layout.row_count());
  evaluator.evaluate(drawn.time, drawn.q, drawn.v, Level::velocity);
  evaluator.factorize({0, 0, 1}, still, no_load, nullptr);
  VectorX mass = still;
  evaluator.visit_blocks([&](int row, int column, ConstMatrixRef block) {
    if (row == column && row < mass.size()) mass.segment(row, block.rows()) = block.diagonal();
  });
  nominals_.setConstant(layout.q_count() + layout.v_count(), length_);
  const Layout::BodySlice* first = nullptr;  // of the body's slices
  for (const Layout::BodySlice& b : layout.bodies()) {
    if (b.part == 0) first = &b;
    if (!first->frame) continue;
    const int at = b.frame ? 6 : 0;  // of the linear coordinates
    if (b.frame) {
      nominals_.segment<4>(b.q + 3).setOnes();
      nominals_.segment<3>(layout.q_count() + b.v + 3).setOnes();
    }
    for (int i = at; i < at + b.linear; ++i)
      nominals_[b.q + i + (b.frame ? 1 : 0)] = nominals_[layout.q_count() + b.v + i] =
          kElasticShare * length_ * std::sqrt(mass[first->v] / mass[b.v + i]);
  }
}

VectorX FmuEquations::states_of(const State& state) const {
  VectorX x(state_count());
  x << state.q, state.v;
  return x;
}

void FmuEquations::read(const VectorX& x, State& state) const {
  const Layout& layout = system_.layout();
  for (int i = 0; i < state_count(); ++i)
    if (!std::isfinite(x[i]))
      throw SimulationError("state '" + variables_[i].name + "' is not finite", time_text(state.time),
                            "take a smaller step");
  state.q = x.head(layout.q_count());
  state.v = x.tail(layout.v_count());
  for (const Layout::BodySlice& b : layout.bodies()) {
    if (!b.frame) continue;
    auto e = state.q.segment<4>(b.q + 3);
    const double norm = e.norm();
    if (!(norm > 0) || !std::isfinite(norm))
      throw SimulationError("the quaternion of '" + b.name + "' has the norm " + number_text(norm),
                            time_text(state.time), "take a smaller step");
    e /= norm;
  }
}

void FmuEquations::evaluate(const State& state, Snapshot& now) const {
  now.evaluate(state, Accelerations::solved);
  if (!now.accelerations().allFinite())
    throw SimulationError("the equations give no acceleration", time_text(state.time),
                          "take a smaller step; if it does not help, look for a locked mechanism, friction that locks, "
                          "constraints that lose rank");
}

VectorX FmuEquations::derivatives(Snapshot& now, const VectorX& x) const {
  const State& state = now.state();
  VectorX rates(state_count());
  for (const Layout::BodySlice& b : system_.layout().bodies()) {
    int iq = b.q, iv = b.v;
    if (b.frame) {
      rates.segment<3>(iq) = state.v.segment<3>(iv);
      Vector4 omega = Vector4::Zero();
      omega.tail<3>() = state.v.segment<3>(iv + 3);
      rates.segment<4>(iq + 3) = 0.5 * quaternion_product(x.segment<4>(iq + 3), omega);
      iq += 7, iv += 6;
    }
    rates.segment(iq, b.linear) = state.v.segment(iv, b.linear);
  }
  rates.tail(state.v.size()) = now.accelerations();
  return rates;
}

double FmuEquations::allowed_drift(double tolerance) const {
  constexpr double kLeast = 1e-9, kSteps = 10;  // of an importer's errors
  return std::max(kLeast, kSteps * tolerance * std::min(1.0, length_));
}

double FmuEquations::drift(Snapshot& now, const VectorX& x) const {
  VectorX rows(system_.layout().row_count());
  double largest = 0;
  for (const Level level : {Level::position, Level::velocity}) {
    now.evaluator().constraint(level, rows);
    if (rows.size() > 0) largest = std::max(largest, rows.cwiseAbs().maxCoeff());
  }
  for (const Layout::BodySlice& b : system_.layout().bodies())
    if (b.frame) largest = std::max(largest, std::abs(x.segment<4>(b.q + 3).norm() - 1));
  return largest;
}

void FmuEquations::project(Snapshot& now, State& state) const {
  constexpr double kTolerance = 1e-13;  // in the units of the rows; or round-off if larger
  constexpr int kMaxIterations = 20;
  Evaluator& equations = now.evaluator();
  Projector projector(equations);
  equations.recall(state.quarter_turns);
  equations.recall_rows(state.left_out);
  if (!projector.position(state.time, state.q, kTolerance, kMaxIterations).converged)
    throw SimulationError("the state cannot be moved onto the constraints", time_text(state.time),
                          "take smaller steps: it has drifted too far, or the mechanism cannot be closed there");
  equations.track(state.quarter_turns);
  projector.velocity(state.time, state.q, state.v);
  equations.track_rows(state.left_out);
  equations.check(state);
}

bool FmuEquations::track(Snapshot& now, State& state) const {
  Evaluator& equations = now.evaluator();
  const std::vector<int> left_out = state.left_out;
  equations.track(state.quarter_turns);
  equations.track_rows(state.left_out);
  if (equations.reacts()) state.lambda = now.multipliers();  // where the search for the next ones begins
  return equations.reacts() || state.left_out != left_out;
}

double FmuEquations::indicator(int number, Snapshot& now, const std::vector<int>& sides) const {
  const Kink& kink = kinks_[static_cast<std::size_t>(number)];
  return kink.function(now) - kink.level + kHysteresis * sides[static_cast<std::size_t>(number)];
}

std::vector<int> FmuEquations::sides(Snapshot& now) const {
  std::vector<int> sides;
  for (const Kink& kink : kinks_) sides.push_back(kink.function(now) >= kink.level ? 1 : -1);
  return sides;
}

}  // namespace lithe
