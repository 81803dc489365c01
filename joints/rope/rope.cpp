#include "joints/rope/rope.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/assembly/batch_of.h"
#include "engine/base/checks.h"
#include "joints/coordinate_coupling.h"
#include "joints/rope/rope_elements_internal.h"

namespace lithe {

namespace {

constexpr double kOutOfLine = 0.342;  // sin 20 degrees

/// An end or a pulley as drawn.
struct Wheel {
  std::string text;  // "pulley 2", "the first end"
  Marker marker;
  double R = 0;  // signed radius, m
  Vector3 p{0, 0, 0};
  Matrix3 axes = Matrix3::Identity();
};

[[noreturn]] void refuse(const std::string& problem, const std::string& fix) { throw SceneError(problem, "", fix); }

MarkerKinematics as_drawn(const SystemGraph& graph, const std::string& text, const Marker& marker) {
  const Body* body = marker.body;
  bool known = false;
  for (const auto& entry : graph.bodies()) known |= entry.body == body;
  if (!known || marker.index < 0 || marker.index >= body->marker_count())
    refuse(text + " has no marker of this graph", "give a marker of one of its bodies: body.marker(...)");
  VectorX q(body->coordinates().q_count()), v(body->coordinates().v_count());
  body->initial_state(q, v);
  const auto cache = body->make_cache();
  const BodyState state{q.data(), v.data(), cache.get()};
  body->evaluate(state, Level::position);
  MarkerKinematics k;
  body->marker_kinematics(state, marker.index, Level::position, k);
  return k;
}

double signed_radius(const std::string& text, double radius, int sense) {
  if (sense != 1 && sense != -1)
    refuse(text + " has the sense " + std::to_string(sense),
           "give 1: the rope runs counter-clockwise about the z axis of the marker; or -1");
  return sense * radius;
}

/// The angle turns the wheel on its carrier, about z of the pulley's marker.
void check_angle(const SystemGraph& graph, const JointCoordinate& angle, const Wheel& wheel) {
  const bool carrier_first = angle.A.body == wheel.marker.body;
  if (carrier_first == (angle.B.body == wheel.marker.body))
    refuse("wheel of " + wheel.text + " does not turn on the body of its marker",
           "give the marker on the body that carries the axle, and the angle between that body and the wheel");
  const Vector3 axis = angle.sign * (carrier_first ? 1 : -1) *
                       as_drawn(graph, "wheel of " + wheel.text, angle.A).R.col(std::clamp(angle.axis, 0, 2));
  if (axis.dot(wheel.axes.col(2)) < std::sqrt(1 - kOutOfLine * kOutOfLine))
    refuse(
        "wheel of " + wheel.text + " does not turn about the z axis of its marker",
        "put the marker on the body that carries the axle, z along the axis of the joint; give -pin.angle() where the "
        "wheel is the first body of the joint");
}

std::vector<Wheel> wheels_of(const SystemGraph& graph, const std::vector<RopeEnd>& ends,
                             const std::vector<RopePulley>& pulleys) {
  std::vector<Wheel> wheels;
  const auto add_end = [&](std::size_t i) {
    const std::string text = i == 0 ? "the first end" : "the last end";
    require::not_negative(ends[i].radius, "radius of " + text);
    wheels.push_back({text, ends[i].marker, signed_radius(text, ends[i].radius, ends[i].sense)});
  };
  if (!ends.empty()) add_end(0);
  for (std::size_t i = 0; i < pulleys.size(); ++i) {
    const RopePulley& pulley = pulleys[i];
    const std::string text = "pulley " + std::to_string(i + 1);
    require::positive(pulley.radius, "radius of " + text);
    if (!(pulley.friction >= 0))
      refuse("friction of " + text + " is " + std::to_string(pulley.friction),
             "give a coefficient of 0 or more, or kNoSlip");
    if (pulley.turns < 0) refuse("turns of " + text + " are negative", "give whole turns beyond the wrap, 0 or more");
    if (pulley.wheel && pulley.wheel->kind != JointCoordinate::Kind::angle)
      refuse("wheel of " + text + " is not an angle", "give the angle of its joint: pin.angle()");
    if (pulley.wheel && pulley.friction == 0)
      refuse(text + " has a wheel and no friction to turn it", "give .friction, kNoSlip for a wheel that never slips");
    if (!pulley.wheel && pulley.friction == kNoSlip)
      refuse(text + " never slips and has no wheel", "give .wheel = pin.angle(), or end the rope there");
    wheels.push_back({text, pulley.marker, signed_radius(text, pulley.radius, pulley.sense)});
  }
  if (!ends.empty()) add_end(1);
  for (Wheel& wheel : wheels) {
    const MarkerKinematics k = as_drawn(graph, wheel.text, wheel.marker);
    wheel.p = k.p, wheel.axes = k.R;
  }
  for (std::size_t i = 0; i < pulleys.size(); ++i)
    if (pulleys[i].wheel) check_angle(graph, *pulleys[i].wheel, wheels[i + (ends.empty() ? 0 : 1)]);
  return wheels;
}

void check_plane(const Wheel& wheel, const Wheel& other) {
  const Vector3 d = other.p - wheel.p, z = wheel.axes.col(2);
  if (wheel.R != 0 && std::abs(z.dot(d)) > kOutOfLine * d.norm())
    refuse("the rope to " + other.text + " leaves the plane of " + wheel.text + " by more than 20 degrees",
           "turn the marker so that its z axis is the axle, at right angles to the rope");
  if (wheel.R != 0 && other.R != 0 && z.dot(other.axes.col(2)) < std::sqrt(1 - kOutOfLine * kOutOfLine))
    refuse("the z axes of " + wheel.text + " and " + other.text + " differ by more than 20 degrees",
           "orient their markers so that both z axes are axles that point the same way; sense = -1 runs the other way");
}

/// Straight part between two wheels: its length and, in the axes of either, its direction.
struct Straight {
  double length, angle_A = 0, angle_B = 0;
};

Straight straight_between(const Wheel& A, const Wheel& B) {
  const Vector3 d = B.p - A.p;
  const double distance = d.norm(), reach = std::abs(A.R) + std::abs(B.R), rho = A.R - B.R;
  if (distance <= reach * (1 + 1e-12))
    refuse(A.text + " and " + B.text + " overlap: they are " + std::to_string(distance) +
               " m apart, and their radii add up to " + std::to_string(reach) + " m",
           "draw them apart, so that the rope has a straight part between them");
  check_plane(A, B), check_plane(B, A);
  const auto direction = [&](const Wheel& wheel) {
    return std::atan2(d.dot(wheel.axes.col(1)), d.dot(wheel.axes.col(0))) + std::asin(rho / distance);
  };
  return {std::sqrt(distance * distance - rho * rho), direction(A), direction(B)};
}

double wrap_between(const Wheel& wheel, double angle_in, double angle_out) {
  const double turn = 2 * std::numbers::pi;
  double wrap = std::fmod(std::copysign(1, wheel.R) * (angle_out - angle_in), turn);
  if (wrap < 0) wrap += turn;
  return wrap > turn - 1e-9 ? 0 : wrap;  // a rope that just touches
}

void check_parameters(const std::vector<RopeEnd>& ends, const RopeParameters& p) {
  if (!ends.empty() && ends.size() != 2)
    refuse("has " + std::to_string(ends.size()) + " end", "give its two ends, or none for a closed belt");
  if (ends.empty() && p.pulleys.size() < 2) refuse("a closed belt needs two pulleys", "give two pulleys or more");
  require::positive(p.axial_stiffness, "axial_stiffness");
  require::not_negative(p.axial_damping, "axial_damping");
  require::not_negative(p.mass_per_length, "mass_per_length");
  require::not_negative(p.pretension, "pretension");
  require::positive(p.presliding, "presliding");
  require::finite(p.speed, "speed");
  if (p.length) require::positive(*p.length, "length");
  if (p.length && p.pretension != 0)
    refuse("has both a length and a pretension", "give one of them: the other follows from it");
}

void check_ideal(const std::vector<RopeEnd>& ends, const RopeParameters& p) {
  const std::string fix = "give .mass_per_length: the travel over a pulley is then a coordinate with inertia";
  for (std::size_t i = 0; i < p.pulleys.size(); ++i)
    if (p.pulleys[i].friction != 0)
      refuse("pulley " + std::to_string(i + 1) + " has friction, and the rope no mass", fix);
  if (ends.empty()) refuse("is closed and has no mass", fix);
  if (p.speed != 0) refuse("has a speed and no mass", fix);
  if (static_cast<int>(p.pulleys.size()) + 2 > kMaxMarkers)
    refuse("has " + std::to_string(p.pulleys.size()) + " pulleys and no mass", "give at most six pulleys, or " + fix);
}

class Reeving {
 public:
  Reeving(SystemGraph& graph, const Located& name, const std::vector<RopeEnd>& ends, const RopeParameters& parameters)
      : graph_(graph), name_(name), p_(parameters), closed_(ends.empty()) {
    check_parameters(ends, p_);
    if (p_.mass_per_length == 0) check_ideal(ends, p_);
    wheels_ = wheels_of(graph, ends, p_.pulleys);
    rope_.name = name.text;
    draw_spans();
  }

  Rope add() {
    const RopeSection section{p_.axial_stiffness, p_.axial_damping};
    if (p_.mass_per_length == 0) {
      std::vector<Marker> markers;
      for (const Wheel& wheel : wheels_) markers.push_back(wheel.marker);
      const IdealRope& all = graph_.add<IdealRope>(name_, std::move(markers), {section, drawings_});
      rope_.spans.assign(drawings_.size(), &all);
      return std::move(rope_);
    }
    for (int i = 0; i < pulleys(); ++i) add_travel(i);
    for (int i = 0; i < spans(); ++i) add_span(section, i);
    for (int i = 0; i < pulleys(); ++i) add_grip(section, i);
    return std::move(rope_);
  }

 private:
  int spans() const { return static_cast<int>(drawings_.size()); }
  int pulleys() const { return static_cast<int>(p_.pulleys.size()); }
  int count() const { return static_cast<int>(wheels_.size()); }
  const Wheel& before(int span) const { return wheels_[span]; }
  const Wheel& behind(int span) const { return wheels_[(span + 1) % count()]; }
  int span_before(int pulley) const { return closed_ ? (pulley + count() - 1) % count() : pulley; }
  int span_behind(int pulley) const { return closed_ ? pulley : pulley + 1; }
  /// The pulley that a span comes from or goes to; -1: an end.
  int pulley_before(int span) const { return closed_ ? span : span - 1; }
  int pulley_behind(int span) const { return closed_ ? (span + 1) % count() : span < pulleys() ? span : -1; }
  Marker travel_marker(int pulley) const { return rope_.travel(pulley).B; }
  Located named(const std::string& part, int number) const {
    return {name_.text + " " + part + " " + std::to_string(number + 1), name_.where};
  }

  void draw_spans() {
    std::vector<Straight> straight;
    for (int i = 0; i < (closed_ ? count() : count() - 1); ++i) {
      straight.push_back(straight_between(before(i), behind(i)));
      drawings_.push_back({before(i).R, behind(i).R, straight.back().length});
      rope_.drawn_lengths.push_back(straight.back().length);
    }
    for (int i = 0; i < pulleys(); ++i) {
      const int in = span_before(i), out = span_behind(i);
      const double wrap = wrap_between(before(out), straight[in].angle_B, straight[out].angle_A) +
                          2 * std::numbers::pi * p_.pulleys[i].turns;
      rope_.wraps.push_back(wrap);
      const double half = 0.5 * p_.pulleys[i].radius * wrap;
      drawings_[in].arc_B = drawings_[out].arc_A = half;
      for (int span : {in, out}) drawings_[span].drawn_length += half;
    }
    double drawn = 0;
    for (const RopeSpanDrawing& drawing : drawings_) drawn += drawing.drawn_length;
    rope_.length = p_.length.value_or(drawn / (1 + p_.pretension / p_.axial_stiffness));
    for (RopeSpanDrawing& drawing : drawings_) drawing.rest_length = drawing.drawn_length * rope_.length / drawn;
  }

  /// What of a span's mass moves with each pulley beside it: half, but all where only an end is on its other side that
  /// moves along.
  double share(int span) const {
    const int other = pulley_before(span) < 0 ? 0 : pulley_behind(span) < 0 ? count() - 1 : -1;
    return other >= 0 && wheels_[other].marker.body != &graph_.ground() ? 1 : 0.5;
  }

  void add_travel(int i) {
    const int in = span_before(i), out = span_behind(i);
    const double length = share(in) * drawings_[in].rest_length + share(out) * drawings_[out].rest_length;
    const double friction = p_.pulleys[i].friction;
    rope_.travels.push_back(&graph_.add<RopeTravel>(
        named("travel", i),
        {.mass = p_.mass_per_length * length, .speed = p_.speed, .slips = friction != 0 && friction != kNoSlip}));
  }

  void add_span(const RopeSection& section, int i) {
    const int from = pulley_before(i), to = pulley_behind(i);
    std::vector<Marker> markers{before(i).marker, behind(i).marker};
    for (int pulley : {from, to})
      if (pulley >= 0) markers.push_back(travel_marker(pulley));
    rope_.spans.push_back(
        &graph_.add<RopeSpan>(named("span", i), std::move(markers),
                              {section, drawings_[i], p_.mass_per_length * graph_.gravity(), from >= 0, to >= 0}));
  }

  void add_grip(const RopeSection& section, int i) {
    const RopePulley& pulley = p_.pulleys[i];
    if (pulley.friction == 0) return;
    if (pulley.friction == kNoSlip) {
      graph_.add<CoordinateCoupling>(named("grip", i), {rope_.travel(i), *pulley.wheel},
                                     {.factors = {1, -pulley.sense * pulley.radius}});
      return;
    }
    const int in = span_before(i), out = span_behind(i), first = pulley_before(in), last = pulley_behind(out);
    std::vector<Marker> markers{before(in).marker, pulley.marker, behind(out).marker, travel_marker(i)};
    for (int beside : {first, last})
      if (beside >= 0) markers.push_back(travel_marker(beside));
    if (pulley.wheel) markers.insert(markers.end(), {pulley.wheel->A, pulley.wheel->B});
    graph_.add<RopeFriction>(named("friction", i), std::move(markers),
                             {.section = section,
                              .in = drawings_[in],
                              .out = drawings_[out],
                              .weight = p_.mass_per_length * graph_.gravity(),
                              .friction = pulley.friction,
                              .presliding = p_.presliding,
                              .wrap = rope_.wraps[i],
                              .travels_before = first >= 0,
                              .travels_behind = last >= 0,
                              .wheel = pulley.wheel});
  }

  SystemGraph& graph_;
  const Located& name_;
  const RopeParameters& p_;
  const bool closed_;
  std::vector<Wheel> wheels_;
  std::vector<RopeSpanDrawing> drawings_;
  Rope rope_;
};

/// The markers of a force element in the graph that has been assembled: of simplified scenes they may be others.
const std::vector<Marker>& markers_of(const SystemGraph& graph, const ForceElement& force) {
  for (const auto& entry : graph.forces())
    if (entry.force == &force) return entry.markers;
  throw SceneError("'" + force.name() + "' is not part of the assembled scene", force.where(),
                   "read sensors of the scene that the rope was added to");
}

}  // namespace

JointCoordinate Rope::travel(int pulley) const {
  if (pulley < 0 || pulley >= static_cast<int>(travels.size()))
    throw SceneError("'" + name + "' has no travel over pulley " + std::to_string(pulley), "",
                     travels.empty() ? "give the rope .mass_per_length: its travels are then coordinates"
                                     : "give 0 to " + std::to_string(travels.size() - 1));
  const Body* body = travels[static_cast<std::size_t>(pulley)];
  return {JointCoordinate::Kind::displacement, {body, 0}, {body, 1}, /*axis=*/0};
}

Rope reeve(SystemGraph& graph, Located name, std::vector<RopeEnd> ends, RopeParameters parameters) {
  const auto draw = [&] {
    try {
      return Reeving(graph, name, ends, parameters);
    } catch (const SceneError& error) {
      throw SceneError("'" + name.text + "': " + error.problem(), to_string(name.where), error.fix());
    }
  };
  return draw().add();
}

Sensor tension(const Rope& rope, int span, Located name) {
  if (span < 0 || span >= static_cast<int>(rope.spans.size()))
    throw SceneError("'" + rope.name + "' has no span " + std::to_string(span), to_string(name.where),
                     "give 0 to " + std::to_string(rope.spans.size() - 1));
  if (name.text.empty()) name.text = rope.name + "_tension_" + std::to_string(span);
  const std::string column = name.text;
  const ForceElement* element = rope.spans[static_cast<std::size_t>(span)];
  return Sensor(std::move(name), {column},
                [element](Snapshot& now, std::span<double> values) {
                  const auto& markers = markers_of(now.system().graph(), *element);
                  const int count = static_cast<int>(markers.size());
                  MarkerKinematics table[kMaxMarkers];
                  for (int m = 0; m < count; ++m) table[m] = now.marker(markers[static_cast<std::size_t>(m)]);
                  ForceRows rows(count);
                  rows.recall(now.quarter_turns_of(*element));
                  element->evaluate(now.time(), connector::Views(table, count), rows);
                  values[0] = rows.tension(0);
                },
                {"N"});
}

}  // namespace lithe
