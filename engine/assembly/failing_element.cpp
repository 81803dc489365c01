#include "engine/assembly/failing_element.h"

#include <algorithm>
#include <cmath>

#include "engine/base/error.h"
#include "engine/base/number_text.h"

namespace lithe {
namespace {

bool finite(const Vector3& a) { return a.allFinite(); }
bool finite(const Wrench& w) { return finite(w.force) && finite(w.torque); }

/// The motions of a connector's markers at the state evaluated last.
class Views {
 public:
  Views(Assembler& assembler, const std::vector<Marker>& markers) {
    kinematics_.reserve(markers.size());
    for (const Marker& marker : markers) {
      kinematics_.push_back(assembler.marker(marker, Level::velocity));
      views_.emplace_back(kinematics_.back(), static_cast<int>(views_.size()));
    }
  }
  operator std::span<const MarkerView>() const { return views_; }

 private:
  std::vector<MarkerKinematics> kinematics_;
  std::vector<MarkerView> views_;
};

bool is_finite(Assembler& assembler, const Constraint& joint, double time) {
  const Views views(assembler, joint.markers());
  ConstraintRows rows(joint.marker_count());
  rows.recall(assembler.quarter_turns_of(joint));
  joint.evaluate(time, views, rows);
  for (int r = 0; r < rows.count(); ++r) {
    bool all = std::isfinite(rows.residual(r)) && std::isfinite(rows.rate(r)) && std::isfinite(rows.bias(r));
    for (int m = 0; m < joint.marker_count(); ++m) all = all && finite(rows.wrench(r, m));
    if (!all) return false;
  }
  return true;
}

bool is_finite(Assembler& assembler, const ForceElement& force, double time) {
  const Views views(assembler, force.markers());
  ForceRows rows(force.marker_count());
  rows.recall(assembler.quarter_turns_of(force));
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

bool is_finite(Assembler& assembler, const Layout::BodySlice& slice, const VectorX& v_dot) {
  VectorX residual = VectorX::Zero(slice.body->coordinates().v_count());
  slice.body->add_residual(assembler.body_state(*slice.body), v_dot.data() + slice.v, assembler.workspace().gravity,
                           residual.data());
  return residual.allFinite();
}

std::string in_words(const Element& element, double time) {
  return "'" + element.name() + "' (" + element.where() + ") gives a value that is not finite at " + time_text(time);
}

/// At one state, whose numbers are finite.
std::string look_at(Assembler& assembler, const State& state) {
  try {
    assembler.recall(state.quarter_turns);
    assembler.recall(state.contacts);
    assembler.evaluate(state.time, state.q, state.v, Level::acceleration);
  } catch (const Error& error) {
    return error.problem() + " (" + error.where() + ")";
  }
  for (const auto& slice : assembler.layout().bodies())
    if (slice.part == 0 && !is_finite(assembler, slice, state.v_dot)) return in_words(*slice.body, state.time);
  const SystemGraph& graph = assembler.system().graph();
  for (const auto& entry : graph.constraints())
    if (!is_finite(assembler, *entry.constraint, state.time)) return in_words(*entry.constraint, state.time);
  for (const auto& entry : graph.forces())
    if (!is_finite(assembler, *entry.force, state.time)) return in_words(*entry.force, state.time);
  if (!assembler.workspace().load.allFinite()) return "a contact gives a value that is not finite";
  return "";
}

}  // namespace

std::string find_failing_element(Assembler& assembler, const State& from, double until) {
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
      assembler.layout().retract(from.q, increment, there.q);
      there.v = from.v + t * from.v_dot;
      if (!there.q.allFinite() || !there.v.allFinite()) return "";
      if (std::string found = look_at(assembler, there); !found.empty()) return found;
    }
  } catch (const std::exception&) {  // NOLINT: the failure that is looked into matters more
  }
  return "";
}

}  // namespace lithe
