#include "engine/assembly/moment_check.h"

#include <algorithm>

#include "engine/assembly/batch_of.h"
#include "engine/base/error.h"
#include "engine/model/constraint.h"
#include "engine/model/force_element.h"
#include "engine/model/point_body.h"

namespace lithe {
namespace {

bool is_point(const Marker& marker) { return dynamic_cast<const PointBody*>(marker.body) != nullptr; }
bool has_point(std::span<const Marker> markers) { return std::any_of(markers.begin(), markers.end(), is_point); }

/// Markers that coincide as drawn give a wrench no arm: apart, every moment shows.
void move_apart(std::vector<MarkerKinematics>& markers) {
  double reach = 1;
  for (const MarkerKinematics& k : markers) reach = std::max(reach, (k.p - markers[0].p).norm());
  for (std::size_t i = 0; i < markers.size(); ++i)
    markers[i].p += reach * Vector3(0.31, -0.17, 0.23) * static_cast<double>(i + 1);
}

void refuse_moment(const Element& element, const Marker& marker, const Wrench& wrench) {
  if (!is_point(marker) || wrench.torque.norm() <= 1e-12 * (1 + wrench.force.norm())) return;
  throw SceneError("'" + element.name() + "' puts a moment on '" + marker.body->name() + "', which has no axes",
                   element.where(),
                   "tie it by joints and forces that act at its place alone (SphericalJoint, DistanceJoint, "
                   "PointOnLineJoint with it as second marker, SpringDamper), or put it on a RigidBody");
}

}  // namespace

void refuse_moments(const Constraint& joint, std::span<const Marker> markers, std::vector<MarkerKinematics> drawn) {
  if (!has_point(markers)) return;
  move_apart(drawn);
  const int count = static_cast<int>(markers.size());
  ConstraintRows rows(count);
  joint.evaluate(0, connector::Views(drawn.data(), count), rows);
  for (int r = 0; r < rows.count(); ++r)
    for (int m = 0; m < count; ++m) refuse_moment(joint, markers[static_cast<std::size_t>(m)], rows.wrench(r, m));
}

void refuse_moments(const ForceElement& force, std::span<const Marker> markers, std::vector<MarkerKinematics> drawn) {
  // Friction acts along a coordinate of its joint, which has been asked.
  if (!has_point(markers) || force.reaction_of()) return;
  if (force.row_count() > 0) move_apart(drawn);  // a law; else a user's function, asked where it will be
  const int count = static_cast<int>(markers.size());
  ForceRows rows(count);
  force.evaluate(0, connector::Views(drawn.data(), count), rows);
  for (int m = 0; m < count; ++m) {
    const Marker& marker = markers[static_cast<std::size_t>(m)];
    refuse_moment(force, marker, rows.load(m));
    for (int r = 0; r < rows.count(); ++r) refuse_moment(force, marker, rows.wrench(r, m));
  }
}

}  // namespace lithe
