#include "engine/assembly/lost_angles.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "engine/assembly/evaluated.h"
#include "engine/assembly/evaluator.h"
#include "engine/base/error.h"
#include "engine/base/number_text.h"
#include "engine/model/marker_motions.h"

namespace lithe {
namespace {

constexpr double kTurn = 4;  // quarter turns

/// The nearest that the shortest way from a to b comes to the third axis, rad.
double nearest_to_axis(const Vector3& a, const Vector3& b) {
  const Vector3 normal = a.cross(b);
  const double ends = std::min(off_axis(a), off_axis(b));
  if (!(normal.norm() > 0)) return ends;
  const Vector3 n = normal.normalized(), foot = Vector3::UnitZ() - n.z() * n;
  const Vector3 nearest = a.z() + b.z() < 0 ? Vector3(-foot) : foot;
  const bool between = n.dot(a.cross(nearest)) >= 0 && n.dot(nearest.cross(b)) >= 0;
  return between ? std::asin(std::min(1.0, std::abs(n.z()))) : ends;
}

/// Whether the rows change with the whole turns of that angle.
bool reads(Evaluator& evaluator, const Constraint& joint, const std::vector<Marker>& on, int first, int place,
           double time) {
  const MarkerMotions views(on, [&](const Marker& m) { return marker_kinematics(evaluator, m, Level::position); });
  VectorX turns = evaluator.workspace().quarter_turns;
  const auto values = [&] {
    ConstraintRows rows(joint.marker_count());
    rows.recall(turns.data() + first);
    joint.evaluate(time, views, rows);
    VectorX out(rows.count());
    for (int r = 0; r < rows.count(); ++r) out[r] = rows.residual(r);
    return out;
  };
  const VectorX before = values();
  turns[first + place] += kTurn;
  return before != values();
}

}  // namespace

const char* const kLostAngleFix =
    "keep the two apart: measure an angle about an axis that the joint keeps, or hold the bodies in the plane of the "
    "joint";

Vector3 arm_of(const MeasuredAngle& angle, std::span<const MarkerView> markers) {
  const MarkerView &A = markers[static_cast<std::size_t>(angle.A)], &B = markers[static_cast<std::size_t>(angle.B)];
  const int next = (angle.axis + 1) % 3, after = (angle.axis + 2) % 3;
  const Vector3 arm = angle.to_point ? Vector3(B.p - A.p) : Vector3(B.R.col(next));
  return Vector3(arm.dot(A.R.col(next)), arm.dot(A.R.col(after)), arm.dot(A.R.col(angle.axis))).normalized();
}

double off_axis(const Vector3& arm) { return std::atan2(std::hypot(arm.x(), arm.y()), std::abs(arm.z())); }

LostAngles::LostAngles(Evaluator& evaluator) : evaluator_(evaluator) {
  last_.q.setZero(evaluator.layout().q_count());
  last_.quarter_turns.setZero(evaluator.workspace().quarter_turns.size());
}

void LostAngles::find_readers(const State& state) {
  const SystemGraph& graph = evaluator_.system().graph();
  int first = 0;
  for (const auto& entry : graph.constraints()) {
    const int count = static_cast<int>(entry.constraint->angles().size());
    for (int i = 0; i < count; ++i)
      if (reads(evaluator_, *entry.constraint, entry.markers, first, i, state.time))
        readers_.push_back({entry.constraint, entry.markers, first, i});
    first += count;
  }
  for (const auto& entry : graph.forces()) {
    const int count = static_cast<int>(entry.force->angles().size());
    for (int i = 0; i < count; ++i) readers_.push_back({entry.force, entry.markers, first, i});
    first += count;
  }
}

/// The first reader whose angle is lost: the arm has passed the axis at a fourth of the distance from which it came and
/// to which it went, or less, so that the step says nothing of the way round. An arm that turns about the axis passes
/// it at 0.3 of its distance at least, by the 1.6 quarter turns that methods allow themselves in a step.
LostAngles::Lost LostAngles::find(const State& state) {
  if (!found_) {
    find_readers(state);
    found_ = true;
  }
  if (readers_.empty()) return {nullptr, 0};
  // The evaluator recalls the turns that the step began with: of a state that was changed since they are others.
  if (!follows_ || evaluator_.workspace().quarter_turns != last_.quarter_turns) return {nullptr, 0};
  for (const Reader& reader : readers_) {
    const int angle = reader.first + reader.place;
    if (!(std::abs(state.quarter_turns[angle] - last_.quarter_turns[angle]) > 1)) continue;
    if (const double nearest = nearest_way(reader, state); nearest >= 0) return {&reader, nearest};
  }
  return {nullptr, 0};
}

/// How near to the axis an angle was lost, rad; -1: it was not.
double LostAngles::nearest_way(const Reader& reader, const State& state) {
  constexpr double kShare = 0.25;
  const MeasuredAngle angle = reader.connector->angles()[static_cast<std::size_t>(reader.place)];
  const auto arm_at = [&](const VectorX& q) {
    evaluator_.evaluate(state.time, q, state.v, Level::velocity);
    return arm_of(angle, MarkerMotions(reader.markers, [&](const Marker& m) {
                    return marker_kinematics(evaluator_, m, Level::position);
                  }));
  };
  const Vector3 before = arm_at(last_.q), now = arm_at(state.q);
  const double nearest = nearest_to_axis(before, now);
  return nearest <= kShare * std::min(off_axis(before), off_axis(now)) ? nearest : -1;
}

bool LostAngles::loses(const State& state) { return find(state).reader; }

void LostAngles::check(const State& state) {
  const Lost lost = find(state);
  if (readers_.empty()) return;
  if (lost.reader) {
    const Connector& connector = *lost.reader->connector;
    const bool to_point = connector.angles()[static_cast<std::size_t>(lost.reader->place)].to_point;
    char degrees[32];
    std::snprintf(degrees, sizeof degrees, "%.2g", lost.nearest * 180 / M_PI);
    throw SimulationError("the angle that '" + connector.name() + "' reads jumps by half a turn in the step to " +
                              time_text(state.time) + ": " +
                              (to_point ? "the point that it looks at passes " : "the axis that it looks at passes ") +
                              degrees + " degrees from the axis that it turns about",
                          connector.where(), kLostAngleFix);
  }
  last_.q = state.q;
  last_.quarter_turns = state.quarter_turns;
  follows_ = true;
}

}  // namespace lithe
