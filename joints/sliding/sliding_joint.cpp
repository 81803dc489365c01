#include "joints/sliding/sliding_joint.h"

#include <array>
#include <cmath>

#include "engine/assembly/batch_of.h"
#include "engine/base/checks.h"
#include "engine/model/marker_motions.h"
#include "engine/observe/snapshot.h"

namespace lithe {
namespace {

constexpr std::size_t kSlider = 1;  // the marker whose reaction friction takes, as of joints of two markers
constexpr double kFarthest = 0.1;

/// The slider and the markers of the rail at its place: where rows keep a wrench, in this order.
void act_on(const RailCurve::Place& at, ActingMarkers& rows) {
  std::array<int, 5> acting{static_cast<int>(kSlider)};
  for (int a = 0; a < at.count; ++a) acting[static_cast<std::size_t>(a) + 1] = RailMarkers::of_joint(at.first + a);
  rows.act_on(std::span(acting).first(static_cast<std::size_t>(at.count) + 1));
}

/// A unit force on the slider and its reaction on the rail.
void fill(const RailCurve::Place& at, const Vector3& direction, Wrench* wrenches) {
  wrenches[0] = force(direction);
  for (int a = 0; a < at.count; ++a) wrenches[a + 1] = force(-at.w[static_cast<std::size_t>(a)] * direction);
}

}  // namespace

SlidingJoint::SlidingJoint(Parameters parameters) : rail_markers_(parameters.rail_markers) {
  if (rail_markers_ < 3 || rail_markers_ > kMostMarkers - 1)
    throw SceneError("its rail has " + std::to_string(rail_markers_) + " markers", "",
                     "give 3 to " + std::to_string(kMostMarkers - 1));
}

void SlidingJoint::initialize(std::span<const MarkerView> markers) {
  const RailMarkers rail{markers};
  rail_.draw(rail);
  const Vector3& p = markers[kSlider].p;
  const RailCurve::Place at = rail_.nearest(rail, p);
  const double apart = (p - RailCurve::positions(rail, at, at.w)).norm();
  if (!(apart <= kFarthest * rail_.length()))
    throw SceneError("its slider is drawn " + std::to_string(apart) + " m from the rail", "",
                     "draw it on the rail, which is " + std::to_string(rail_.length()) + " m long");
}

SlidingJoint::Slide SlidingJoint::slide(std::span<const MarkerView> markers) const {
  const RailMarkers rail{markers};
  const MarkerView& slider = markers[kSlider];
  const RailCurve::Place at = rail_.nearest(rail, slider.p);
  const Vector3 direction = RailCurve::positions(rail, at, at.dw).normalized();
  return {at.u, direction.dot(slider.v - RailCurve::velocities(rail, at, at.w)), direction};
}

void SlidingJoint::evaluate(double, std::span<const MarkerView> markers, ConstraintRows& rows) const {
  const RailMarkers rail{markers};
  const MarkerView& slider = markers[kSlider];
  const RailCurve::Place at = rail_.nearest(rail, slider.p);
  act_on(at, rows);
  const Vector3 d = slider.p - RailCurve::positions(rail, at, at.w), slope = RailCurve::positions(rail, at, at.dw);
  const double u_dot = slope.dot(slider.v - RailCurve::velocities(rail, at, at.w)) / slope.squaredNorm();
  const Vector3 passing =
      2 * u_dot * RailCurve::velocities(rail, at, at.dw) + u_dot * u_dot * RailCurve::positions(rail, at, at.ddw);
  for (const Vector3& n : rail_.across(rail, at)) {
    fill(at, n, rows.open());
    rows.finish(n.dot(d), -n.dot(passing));
  }
}

SlidingFriction::SlidingFriction(Parameters parameters)
    : parameters_(parameters),
      law_({parameters.coefficient, parameters.static_coefficient, parameters.stribeck_speed, parameters.creep_speed}) {
  const Parameters& p = parameters_;
  if (!p.joint) throw SceneError("names no joint", "", "give .joint = &slider: whose reaction presses");
  require::not_negative(p.viscous, "viscous");
  require::not_negative(p.preload, "preload");
}

void SlidingFriction::evaluate(double, std::span<const MarkerView> markers, ForceRows& rows) const {
  const Parameters& p = parameters_;
  const RailMarkers rail{markers};
  const MarkerView& slider = markers[kSlider];
  const RailCurve& curve = p.joint->rail_;
  const RailCurve::Place at = curve.nearest(rail, slider.p);
  const Vector3 t = RailCurve::positions(rail, at, at.dw).normalized();
  const double s = t.dot(slider.v - RailCurve::velocities(rail, at, at.w));
  const Vector3 across = rows.reaction().force - t.dot(rows.reaction().force) * t;
  const double pressing = across.norm(), N = pressing + p.preload;

  const auto [mu, mu_slope] = law_.at(s);
  act_on(at, rows);
  fill(at, t, rows.open());
  rows.finish(mu * N + p.viscous * s, 0, mu_slope * N + p.viscous);
  if (pressing > 0) rows.depends_on_reaction(force(mu / pressing * across));
}

SlidingJoint& add_sliding_joint(SystemGraph& graph, Located name, Marker slider, const std::vector<Marker>& rail) {
  std::vector<Marker> markers = rail;
  markers.insert(markers.begin() + std::min<std::ptrdiff_t>(1, std::ssize(markers)), slider);
  return graph.add<SlidingJoint>(std::move(name), std::move(markers), {.rail_markers = static_cast<int>(rail.size())});
}

SlidingFriction& add_sliding_friction(SystemGraph& graph, Located name, const SlidingJoint& joint,
                                      SlidingFriction::Parameters friction) {
  friction.joint = &joint;
  return graph.add<SlidingFriction>(std::move(name), joint.markers(), friction);
}

namespace {

Sensor slide_sensor(const SlidingJoint& joint, Located name, const std::string& ending, const std::string& unit,
                    double SlidingJoint::Slide::*value) {
  if (name.text.empty()) name.text = joint.name() + ending;
  const std::string column = name.text;
  return Sensor(std::move(name), {column},
                [&joint, value](Snapshot& now, std::span<double> values) {
                  const MarkerMotions views(joint.markers(), [&](const Marker& m) { return now.marker(m); });
                  values[0] = joint.slide(views).*value;
                },
                {unit});
}

}  // namespace

Sensor place_on_rail(const SlidingJoint& joint, Located name) {
  return slide_sensor(joint, std::move(name), "_place", "m", &SlidingJoint::Slide::place);
}
Sensor speed_on_rail(const SlidingJoint& joint, Located name) {
  return slide_sensor(joint, std::move(name), "_speed", "m/s", &SlidingJoint::Slide::speed);
}

template std::unique_ptr<ConstraintBatch> make_constraint_batch<SlidingJoint>();
template std::unique_ptr<ForceBatch> make_force_batch<SlidingFriction>();

}  // namespace lithe
