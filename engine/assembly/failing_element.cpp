#include "engine/assembly/failing_element.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "engine/assembly/evaluated.h"
#include "engine/assembly/lost_angles.h"
#include "engine/base/error.h"
#include "engine/base/number_text.h"
#include "engine/model/marker_motions.h"

namespace lithe {
namespace {

bool finite(const Vector3& a) { return a.allFinite(); }
bool finite(const Wrench& w) { return finite(w.force) && finite(w.torque); }

const double* measured_turns(const Evaluator& evaluator, const Connector& connector) {
  return evaluator.workspace().quarter_turns.data() + evaluator.system().first_angle(connector);
}

MarkerMotions motions_of(Evaluator& evaluator, const std::vector<Marker>& markers) {
  return {markers, [&](const Marker& m) { return marker_kinematics(evaluator, m, Level::velocity); }};
}

/// Markers are those of the graph: in a simpler one joints are as drawn, but bodies have become one, or ground.
bool is_finite(Evaluator& evaluator, const Constraint& joint, const std::vector<Marker>& markers, double time) {
  const MarkerMotions views = motions_of(evaluator, markers);
  ConstraintRows rows(joint.marker_count());
  rows.recall(measured_turns(evaluator, joint));
  joint.evaluate(time, views, rows);
  for (int r = 0; r < rows.count(); ++r) {
    bool all = std::isfinite(rows.residual(r)) && std::isfinite(rows.rate(r)) && std::isfinite(rows.bias(r));
    for (int m = 0; m < joint.marker_count(); ++m) all = all && finite(rows.wrench(r, m));
    if (!all) return false;
  }
  return true;
}

bool is_finite(Evaluator& evaluator, const ForceElement& force, const std::vector<Marker>& markers, double time) {
  const MarkerMotions views = motions_of(evaluator, markers);
  ForceRows rows(force.marker_count());
  rows.recall(measured_turns(evaluator, force));
  rows.set_reaction({Vector3::Zero(), Vector3::Zero()});
  force.evaluate(time, views, rows);
  bool all = std::isfinite(rows.energy());
  for (int m = 0; m < force.marker_count(); ++m) all = all && finite(rows.load(m));
  for (int r = 0; r < rows.count(); ++r) {
    all = all && std::isfinite(rows.tension(r)) && std::isfinite(rows.stiffness(r)) && std::isfinite(rows.damping(r));
    for (int m = 0; m < force.marker_count(); ++m) all = all && finite(rows.wrench(r, m));
  }
  return all;
}

bool is_finite(Evaluator& evaluator, const Layout::BodySlice& slice, const VectorX& v_dot) {
  VectorX residual = VectorX::Zero(slice.body->coordinates().v_count());
  slice.body->add_residual(body_state(evaluator, *slice.body), v_dot.data() + slice.v, evaluator.workspace().gravity,
                           residual.data());
  return residual.allFinite();
}

std::string in_words(const Element& element, double time) {
  return "'" + element.name() + "' (" + element.where() + ") gives a value that is not finite at " + time_text(time);
}

/// At one state, whose numbers are finite.
std::string look_at(Evaluator& evaluator, const State& state) {
  try {
    evaluator.recall(state.quarter_turns);
    evaluator.recall(state.contacts);
    evaluator.evaluate(state.time, state.q, state.v, Level::acceleration);
  } catch (const Error& error) {
    return error.problem() + " (" + error.where() + ")";
  }
  for (const auto& slice : evaluator.layout().bodies())
    if (slice.part == 0 && !is_finite(evaluator, slice, state.v_dot)) return in_words(*slice.body, state.time);
  const SystemGraph& graph = evaluator.system().graph();
  for (const auto& entry : graph.constraints())
    if (!is_finite(evaluator, *entry.constraint, entry.markers, state.time))
      return in_words(*entry.constraint, state.time);
  for (const auto& entry : graph.forces())
    if (!is_finite(evaluator, *entry.force, entry.markers, state.time)) return in_words(*entry.force, state.time);
  if (!evaluator.workspace().load.allFinite()) return "a contact gives a value that is not finite";
  return "";
}

}  // namespace

std::string find_lost_angle(Evaluator& evaluator, const State& state) try {
  constexpr double kLost = 1e-2;  // rad
  evaluator.recall(state.quarter_turns);
  evaluator.recall(state.contacts);
  evaluator.evaluate(state.time, state.q, state.v, Level::velocity);
  std::string found;
  double nearest = kLost;
  const auto look = [&](const Connector& connector, const std::vector<Marker>& on) {
    const MarkerMotions markers = motions_of(evaluator, on);
    for (const MeasuredAngle& angle : connector.angles())
      if (const double off = off_axis(arm_of(angle, markers)); off < nearest) {
        nearest = off;
        char degrees[32];
        std::snprintf(degrees, sizeof degrees, "%.2g", off * 180 / M_PI);
        found = "the angle that '" + connector.name() + "' (" + connector.where() +
                ") measures jumps by half a turn: " +
                (angle.to_point ? "the point that it looks at is " : "the axis that it looks at is ") + degrees +
                " degrees from the axis that it turns about";
      }
  };
  const SystemGraph& graph = evaluator.system().graph();
  for (const auto& entry : graph.constraints()) look(*entry.constraint, entry.markers);
  for (const auto& entry : graph.forces()) look(*entry.force, entry.markers);
  return found;
} catch (const std::exception&) {  // NOLINT: the failure that is looked into matters more
  return "";
}

std::string find_failing_element(Evaluator& evaluator, const State& from, double until) {
  constexpr int kEven = 16, kHalvings = 40;
  const double h = until - from.time;
  State there = from;
  // The earliest of even samples tells the time best; one that fails at once is seen by the shrinking ones.
  std::vector<double> parts;
  for (int k = 0; k <= kHalvings; ++k) parts.push_back(std::ldexp(1.0, k - kHalvings));
  for (int k = 1; k < kEven; ++k) parts.push_back(double(k) / kEven);
  std::sort(parts.begin(), parts.end());
  parts.insert(parts.begin(), 0.0);
  try {
    for (const double part : parts) {
      const double t = part * h;
      there.time = from.time + t;
      const VectorX increment = t * from.v + 0.5 * t * t * from.v_dot;
      evaluator.layout().retract(from.q, increment, there.q);
      there.v = from.v + t * from.v_dot;
      if (!there.q.allFinite() || !there.v.allFinite()) return "";
      if (std::string found = look_at(evaluator, there); !found.empty()) return found;
    }
  } catch (const std::exception&) {  // NOLINT: the failure that is looked into matters more
  }
  return "";
}

}  // namespace lithe
