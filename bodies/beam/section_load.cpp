#include "bodies/beam/section_load.h"

#include <algorithm>
#include <cmath>

#include "bodies/beam/beam_cache_internal.h"
#include "bodies/beam/se3_internal.h"
#include "bodies/resultant_sensor.h"
#include "engine/observe/snapshot.h"

namespace lithe {
namespace {

double middle(const Beam& beam, int element) { return 0.5 * (beam.arc(element) + beam.arc(element + 1)); }

/// Whether loads may jump between the elements before and behind a node.
bool is_station(const Beam& beam, int node) {
  const auto& stations = beam.parameters().stations;
  return std::any_of(stations.begin(), stations.end(),
                     [&](double arc) { return std::abs(arc - beam.arc(node)) < 1e-9 * beam.length(); });
}

void check_arc(const Beam& beam, double arc) {
  if (!(arc >= 0 && arc <= beam.length() * (1 + 1e-9)))
    throw SceneError("beam '" + beam.name() + "' has no section at " + std::to_string(arc) + " m", beam.where(),
                     "give an arc length from 0 to " + std::to_string(beam.length()));
}

}  // namespace

Vector6 section_load(const Beam& beam, const BodyState& state, double arc) {
  check_arc(beam, arc);
  const int e = beam.element_at(std::min(arc, beam.length()));
  const bool before = e > 0 && !is_station(beam, e), behind = e + 1 < beam.element_count() && !is_station(beam, e + 1);
  const double from_middle = arc - middle(beam, e);
  const Vector6 here = beam.resultants(state, e);
  const int other = (from_middle < 0 && before) || !behind ? e - 1 : e + 1;
  if (before || behind) {
    const double share = from_middle / (middle(beam, other) - middle(beam, e));
    return (1 - share) * here + share * beam.resultants(state, other);
  }
  // The same wrench about another point of the element's helix, in the axes there.
  const Vector6 along = from_middle / beam.element(e).length() * static_cast<const Beam::Cache&>(*state.cache).d[e];
  const se3::Pose there = se3::exp(along);
  Vector6 moved;
  moved.head<3>() = there.R.transpose() * here.head<3>();
  moved.tail<3>() = there.R.transpose() * (here.tail<3>() - there.p.cross(Vector3(here.head<3>())));
  return moved;
}

Sensor section_load(const Beam& beam, double arc, Located name) {
  check_arc(beam, arc);
  if (name.text.empty()) name.text = beam.name() + "_s" + std::to_string(arc);
  return resultant_sensor(std::move(name),
                          [&beam, arc](Snapshot& now) { return section_load(beam, now.body_state(beam), arc); });
}

}  // namespace lithe
