#include "joints/rope/rope_elements_internal.h"

#include <algorithm>
#include <numbers>

#include "engine/assembly/batch_of.h"
#include "engine/base/checks.h"
#include "engine/model/initial_pose.h"

namespace lithe {

namespace {

using Kind = JointCoordinate::Kind;

double counted(const AngleMemory& memory, int place, double angle) {
  return memory.quarter_turns() ? memory.wound(place, angle) : initial::angle(angle);
}

/// W += by W.
void add(Wrench& to, const Wrench& w, double by) { to.force += by * w.force, to.torque += by * w.torque; }

void set_zero(Wrench* W, int count) { std::fill(W, W + count, Wrench{Vector3::Zero(), Vector3::Zero()}); }

double power(const Wrench& w, const MarkerView& m) { return w.force.dot(m.v) + w.torque.dot(m.w); }

/// A span between carriers, and what has travelled into it and out of it (null: nothing does).
RopeStretch stretch_of(const RopeSection& section, const RopeSpanDrawing& drawing, const MeasuredSpan& span,
                       double offset, const MarkerView* travel_A, const MarkerView* travel_B) {
  double material = drawing.rest_length, rate = 0;
  if (travel_A) material += travel_A->p.x(), rate += travel_A->v.x();
  if (travel_B) material -= travel_B->p.x(), rate -= travel_B->v.x();
  return {section, span.length + offset, span.rate, material, rate};
}

}  // namespace

void add_span_angles(int A, int B, const RopeSpanDrawing& drawing, std::vector<MeasuredAngle>& to) {
  if (drawing.R_A != 0) to.push_back({A, B, /*axis=*/2, /*to_point=*/true});
  if (drawing.R_B != 0) to.push_back({B, A, /*axis=*/2, /*to_point=*/true});
}

MeasuredSpan measure_span(const MarkerView& A, const MarkerView& B, const RopeSpanDrawing& drawing,
                          const AngleMemory& memory, int& place) {
  const double rho = drawing.R_A - drawing.R_B;
  const MeasuredCoordinate c = measure(Kind::distance, 2, A, B);
  MeasuredSpan span{};
  span.straight = std::sqrt(c.value * c.value - rho * rho);
  span.length = span.straight;
  const double slope = span.straight / c.value, offset = std::asin(rho / c.value);
  span.on_A = slope * c.on_A, span.on_B = slope * c.on_B;
  if (drawing.R_A != 0) {
    const MeasuredCoordinate x = measure(Kind::bearing, 2, A, B);
    span.angle_A = counted(memory, place++, x.value) + offset;
    span.length += drawing.R_A * span.angle_A;
    add(span.on_A, x.on_A, drawing.R_A), add(span.on_B, x.on_B, drawing.R_A);
  }
  if (drawing.R_B != 0) {
    const MeasuredCoordinate x = measure(Kind::bearing, 2, B, A);
    span.angle_B = counted(memory, place++, x.value) + offset;
    span.length -= drawing.R_B * span.angle_B;
    add(span.on_B, x.on_A, -drawing.R_B), add(span.on_A, x.on_B, -drawing.R_B);
  }
  span.rate = power(span.on_A, A) + power(span.on_B, B);
  return span;
}

// ---- DrawnSpan ----

constexpr int kArcPoints = 13;

void DrawnSpan::set(const RopeSpanDrawing& drawing, const MeasuredSpan& drawn) {
  drawing_ = drawing;
  if (drawing.R_A != 0) start_ = drawn.angle_A - drawing.arc_A / drawing.R_A;
  if (drawing.R_B != 0) end_ = drawn.angle_B + drawing.arc_B / drawing.R_B;
}

int DrawnSpan::point_count() const {
  return (drawing_.R_A != 0 ? kArcPoints : 1) + (drawing_.R_B != 0 ? kArcPoints : 1);
}

void DrawnSpan::add_points(const MarkerView& A, const MarkerView& B, const MeasuredSpan& now, Matrix3X& points,
                           int& at) const {
  // Where the rope runs in the direction φ it is a quarter turn behind on the rim; of long windings the last turn.
  const auto add_arc = [&](const MarkerView& wheel, double R, double from, double to) {
    const double sweep = std::clamp(to - from, -2 * std::numbers::pi, 2 * std::numbers::pi);
    for (int i = 0; i < kArcPoints; ++i) {
      const double phi = from + sweep * i / (kArcPoints - 1);
      points.col(at++) = wheel.p + wheel.R * (R * Vector3(std::sin(phi), -std::cos(phi), 0));
    }
  };
  if (drawing_.R_A != 0) {
    const double phi = now.angle_A, turn = 2 * std::numbers::pi;
    add_arc(A, drawing_.R_A, std::clamp(start_, phi - turn, phi + turn), phi);
  } else {
    points.col(at++) = A.p;
  }
  if (drawing_.R_B != 0)
    add_arc(B, -drawing_.R_B, now.angle_B, end_);
  else
    points.col(at++) = B.p;
}

std::vector<DrawnShape> drawn_wheel(double radius) {
  if (radius == 0) return {};
  return {visual::cylinder(std::abs(radius), 0.3 * std::abs(radius))};
}

RopeStretch::RopeStretch(const RopeSection& section, double length, double rate, double material,
                         double material_rate) {
  if (length <= material) return;
  const double EA = section.axial_stiffness, c = section.axial_damping;
  strain = length / material - 1;
  const double elastic = EA * strain, viscous = c * (rate - (1 + strain) * material_rate) / material;
  const bool limited = std::abs(viscous) > elastic;
  tension = elastic + (limited ? std::copysign(elastic, viscous) : viscous);
  stiffness = EA / material * (!limited ? 1 : viscous > 0 ? 2 : 0);
  damping = limited ? 0 : c / material;
  energy = 0.5 * elastic * strain * material;
}

// ---- RopeTravel ----

RopeTravel::RopeTravel(Parameters parameters) : parameters_(parameters) {
  require::positive(parameters.mass, "mass");
  require::finite(parameters.speed, "speed");
  set_marker_count(2);
}

void RopeTravel::initial_state(VectorRef q, VectorRef v) const {
  q.setZero(), v.setZero();
  v[0] = parameters_.speed;
}

void RopeTravel::add_residual(const BodyState&, const double* v_dot, const Vector3&, double* r) const {
  r[0] += parameters_.mass * v_dot[0];
  if (parameters_.slips) r[1] += v_dot[1];
}

void RopeTravel::add_tangent(const BodyState&, const double*, const Vector3&, const TangentWeights& weights,
                             BodyTangent& tangent) const {
  tangent.linear[0] += weights.acceleration * parameters_.mass;
  if (parameters_.slips) tangent.linear[1] += weights.acceleration;
}

void RopeTravel::marker_kinematics(const BodyState& state, int marker, Level, MarkerKinematics& k) const {
  static constexpr double kColumns[12] = {1, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0};
  k.p = k.v = Vector3::Zero();
  if (marker == 1) {
    k.p.x() = state.q[0], k.v.x() = state.v[0];
    if (parameters_.slips) k.p.y() = state.q[1], k.v.y() = state.v[1];
  }
  k.r = k.p;
  k.R = Matrix3::Identity();
  k.w = k.bias_v = k.bias_w = Vector3::Zero();
  k.A = &state.cache->A;
  k.elastic = marker == 1 ? kColumns : nullptr;
}

BodyEnergy RopeTravel::energy(const BodyState& state, const Vector3&) const {
  return {.kinetic = 0.5 * parameters_.mass * state.v[0] * state.v[0]};
}

// ---- IdealRope ----

std::vector<MeasuredAngle> IdealRope::angles() const {
  std::vector<MeasuredAngle> all;
  for (int i = 0; i + 1 < marker_count(); ++i) add_span_angles(i, i + 1, parameters_.spans[i], all);
  return all;
}

void IdealRope::initialize(std::span<const MarkerView> markers) {
  offset_ = rest_length_ = 0;
  drawn_.resize(parameters_.spans.size());
  int place = 0;
  for (int i = 0; i + 1 < marker_count(); ++i) {
    const RopeSpanDrawing& drawing = parameters_.spans[i];
    const MeasuredSpan span = measure_span(markers[i], markers[i + 1], drawing, {}, place);
    offset_ += drawing.drawn_length - span.length;
    rest_length_ += drawing.rest_length;
    drawn_[i].set(drawing, span);
  }
}

std::vector<DrawnShape> IdealRope::drawn_shapes(int marker) const {
  const auto& spans = parameters_.spans;
  const auto at = static_cast<std::size_t>(marker);
  return drawn_wheel(at < spans.size() ? spans[at].R_A : spans.back().R_B);
}

void IdealRope::drawn_line(std::span<const MarkerView> markers, const AngleMemory& memory, Matrix3X& points) const {
  int count = 0, place = 0, at = 0;
  for (const DrawnSpan& span : drawn_) count += span.point_count();
  points.resize(3, count);
  for (std::size_t i = 0; i < drawn_.size(); ++i) {
    const MarkerView &A = markers[i], &B = markers[i + 1];
    drawn_[i].add_points(A, B, measure_span(A, B, parameters_.spans[i], memory, place), points, at);
  }
}

void IdealRope::evaluate(double, std::span<const MarkerView> markers, ForceRows& rows) const {
  Wrench* W = rows.open();
  set_zero(W, marker_count());
  double length = offset_, rate = 0;
  int place = 0;
  for (int i = 0; i + 1 < marker_count(); ++i) {
    const MeasuredSpan span = measure_span(markers[i], markers[i + 1], parameters_.spans[i], rows, place);
    length += span.length, rate += span.rate;
    add(W[i], span.on_A, 1), add(W[i + 1], span.on_B, 1);
  }
  const RopeStretch stretch(parameters_.section, length, rate, rest_length_, 0);
  rows.finish(stretch.tension, stretch.stiffness, stretch.damping);
  rows.add_energy(stretch.energy);
}

// ---- RopeSpan ----

std::vector<MeasuredAngle> RopeSpan::angles() const {
  std::vector<MeasuredAngle> all;
  add_span_angles(0, 1, parameters_.drawing, all);
  return all;
}

void RopeSpan::initialize(std::span<const MarkerView> markers) {
  int place = 0;
  const RopeSpanDrawing& drawing = parameters_.drawing;
  const MeasuredSpan span = measure_span(markers[0], markers[1], drawing, {}, place);
  offset_ = drawing.drawn_length - span.length;
  drawn_.set(drawing, span);
}

std::vector<DrawnShape> RopeSpan::drawn_shapes(int marker) const {
  const auto& drawing = parameters_.drawing;
  if (marker == 0) return drawn_wheel(drawing.R_A);
  return marker == 1 && !parameters_.travels_B ? drawn_wheel(drawing.R_B) : std::vector<DrawnShape>{};
}

void RopeSpan::drawn_line(std::span<const MarkerView> markers, const AngleMemory& memory, Matrix3X& points) const {
  points.resize(3, drawn_.point_count());
  int place = 0, at = 0;
  const MeasuredSpan now = measure_span(markers[0], markers[1], parameters_.drawing, memory, place);
  drawn_.add_points(markers[0], markers[1], now, points, at);
}

void RopeSpan::evaluate(double, std::span<const MarkerView> markers, ForceRows& rows) const {
  const auto& [section, drawing, weight, travels_A, travels_B] = parameters_;
  int place = 0;
  const MeasuredSpan span = measure_span(markers[0], markers[1], drawing, rows, place);
  const MarkerView *A = travels_A ? &markers[2] : nullptr, *B = travels_B ? &markers[2 + travels_A] : nullptr;
  const RopeStretch stretch = stretch_of(section, drawing, span, offset_, A, B);

  // x' = Λ' - (1 + ε) L' = L ε': the stiffness EA/L along it is the whole second derivative of V by Λ and L.
  const Vector3 along = (1 + stretch.strain) * Vector3::UnitX();
  Wrench* W = rows.open();
  W[0] = span.on_A, W[1] = span.on_B;
  if (A) W[A->index] = force(-along);
  if (B) W[B->index] = force(along);
  rows.finish(stretch.tension, stretch.stiffness, stretch.damping);
  rows.add_energy(stretch.energy);
  // -∂V/∂L = EA (ε + ε²/2), and the row has given EA (ε + ε²).
  const double excess = 0.5 * section.axial_stiffness * stretch.strain * stretch.strain;
  // Material that leaves the span takes its weight along.
  const Vector3 &p_A = markers[0].p, &p_B = markers[1].p;
  const double carried = 0.5 * weight.dot(p_A + p_B) - excess;
  double hanging = drawing.rest_length - drawing.arc_A - drawing.arc_B;
  if (A) rows.add_load(*A, force(carried * Vector3::UnitX())), hanging += A->p.x();
  if (B) rows.add_load(*B, force(-carried * Vector3::UnitX())), hanging -= B->p.x();
  if (weight.isZero(0)) return;
  const double at_A = 0.5 * hanging + drawing.arc_A, at_B = 0.5 * hanging + drawing.arc_B;
  rows.add_load(markers[0], force(at_A * weight));
  rows.add_load(markers[1], force(at_B * weight));
  rows.add_energy(-weight.dot(at_A * p_A + at_B * p_B));
}

// ---- RopeFriction ----

struct RopeFriction::Motion {
  MeasuredSpan in, out;
  std::optional<MeasuredCoordinate> wheel;
};

int RopeFriction::marker_count() const {
  return 4 + parameters_.travels_before + parameters_.travels_behind + (parameters_.wheel ? 2 : 0);
}

std::vector<MeasuredAngle> RopeFriction::angles() const {
  std::vector<MeasuredAngle> all;
  add_span_angles(0, 1, parameters_.in, all);
  add_span_angles(1, 2, parameters_.out, all);
  if (parameters_.wheel) all.push_back({marker_count() - 2, marker_count() - 1, parameters_.wheel->axis});
  return all;
}

RopeFriction::Motion RopeFriction::motion(std::span<const MarkerView> markers, const AngleMemory& memory) const {
  int place = 0;
  Motion now{measure_span(markers[0], markers[1], parameters_.in, memory, place),
             measure_span(markers[1], markers[2], parameters_.out, memory, place), std::nullopt};
  if (!parameters_.wheel) return now;
  const auto& [kind, A, B, axis, sign] = *parameters_.wheel;
  const std::size_t carrier = markers.size() - 2;
  MeasuredCoordinate x = measure(kind, axis, markers[carrier], markers[carrier + 1]);
  x.value = sign * counted(memory, place, x.value), x.rate *= sign;
  x.on_A = sign * x.on_A, x.on_B = sign * x.on_B;
  now.wheel = x;
  return now;
}

void RopeFriction::initialize(std::span<const MarkerView> markers) {
  const Motion drawn = motion(markers, {});
  offset_in_ = parameters_.in.drawn_length - drawn.in.length;
  offset_out_ = parameters_.out.drawn_length - drawn.out.length;
  angle_ = drawn.out.angle_A - drawn.in.angle_B;
  turned_ = drawn.wheel ? drawn.wheel->value : 0;
}

void RopeFriction::evaluate(double, std::span<const MarkerView> markers, ForceRows& rows) const {
  const auto& p = parameters_;
  const Motion now = motion(markers, rows);
  const MarkerView& here = markers[3];
  const MarkerView* before = p.travels_before ? &markers[4] : nullptr;
  const MarkerView* behind = p.travels_behind ? &markers[4 + p.travels_before] : nullptr;
  const RopeStretch in = stretch_of(p.section, p.in, now.in, offset_in_, before, &here);
  const RopeStretch out = stretch_of(p.section, p.out, now.out, offset_out_, &here, behind);

  // How far the bristles are bent, and how fast the rope moves over the surface where it runs on.
  const double R = p.out.R_A, s_rate = here.v.x(), slipped = here.v.y();
  const double entry_strain = s_rate >= 0 ? in.strain : out.strain;
  double bend = here.p.x() - slipped, speed = (1 + entry_strain) * s_rate;
  if (now.wheel) bend -= R * (now.wheel->value - turned_), speed -= R * now.wheel->rate;
  const double z = bend / p.presliding, size = std::abs(z);

  // The part of the motion that slips, A |z|/z_s: none while bristles are elastic or unload, all beyond full friction.
  constexpr double kElastic = 0.7, kSliding = 1.1;
  double slip = 0, slope = 0;  // and its derivative by |z|
  if (z * speed > 0 && size > kElastic) {
    const double angle = std::numbers::pi * (size - 0.5 * (1 + kElastic)) / (1 - kElastic);
    const double A = size >= 1 ? 1 : 0.5 + 0.5 * std::sin(angle);
    slip = A * size / kSliding;
    slope = (A + (size >= 1 ? 0 : 0.5 * std::numbers::pi / (1 - kElastic) * std::cos(angle) * size)) / kSliding;
  }

  const double wrap = std::max(0.0, p.wrap + std::copysign(1, R) * (now.out.angle_A - now.in.angle_B - angle_));
  const double weight = 0.5 * p.weight.dot(markers[0].p + markers[2].p - 2 * markers[1].p);
  const double press = std::max(0.0, in.tension + out.tension + weight), half = 0.5 * p.friction * wrap;
  const double used = std::tanh(std::clamp(z, -1.0, 1.0) * half);
  const double stiffness = size < 1 ? press * half * (1 - used * used) / p.presliding * (1 - slip) : 0;

  Wrench* W = rows.open();
  set_zero(W, marker_count());
  // (1 + mean ε): what a travel feels of T_out - T_in (RopeSpan).
  W[3] = force((1 + 0.5 * (in.strain + out.strain)) * Vector3::UnitX());
  if (now.wheel) {
    W[marker_count() - 2] = -R * now.wheel->on_A;
    W[marker_count() - 1] = -R * now.wheel->on_B;
  }
  rows.finish(press * used, stiffness, 0);
  // ṗ, as a row whose damping is -∂ṗ/∂p: fast where the rope slides.
  W = rows.open();
  set_zero(W, marker_count());
  W[3] = force(Vector3::UnitY());
  rows.finish(entry_strain * s_rate - slip * speed, 0, slope * std::abs(speed) / p.presliding);
}

template std::unique_ptr<BodyBatch> make_body_batch<RopeTravel>();
template std::unique_ptr<ForceBatch> make_force_batch<IdealRope>();
template std::unique_ptr<ForceBatch> make_force_batch<RopeSpan>();
template std::unique_ptr<ForceBatch> make_force_batch<RopeFriction>();

}  // namespace lithe
