#include "models/adams/adams_elements_internal.h"

#include <numbers>

#include "engine/assembly/batch_of.h"
#include "models/adams/function_value_internal.h"

namespace lithe::adams {
namespace {

using Kind = AdamsMeasure::Kind;

/// One unit of the measure in SI.
double unit_of(Kind kind, const AdamsUnits& u) {
  using enum AdamsMeasure::Kind;
  if (kind >= DM && kind <= DZ) return u.length;
  if (kind >= VM && kind <= VZ) return u.length / u.time;
  if (kind >= WM && kind <= WZ) return 1 / u.time;
  if (kind >= ACCM && kind <= ACCZ) return u.length / (u.time * u.time);
  if (kind >= WDTM && kind <= WDTZ) return 1 / (u.time * u.time);
  return 1;
}

template <class Motion>
PoseOf<double> pose_of(const Motion& m) {
  return {m.p, m.R};
}

/// Of velocities, SI: I against J, along the axes of K, seen from L.
template <class Motion>
double of_velocity(Kind kind, const Motion& I, const Motion& J, const Motion& K, const Motion& L) {
  using enum AdamsMeasure::Kind;
  const Vector3 d = I.p - J.p, w = I.w - J.w;
  const Vector3 v = I.v - J.v - L.w.cross(d);
  switch (kind) {
    case VM:
      return v.norm();
    case VR: {
      const double length = d.norm();
      return length > 0 ? v.dot(d) / length : 0;
    }
    case VX:
      return v.dot(K.R.col(0));
    case VY:
      return v.dot(K.R.col(1));
    case VZ:
      return v.dot(K.R.col(2));
    case WM:
      return w.norm();
    case WX:
      return w.dot(K.R.col(0));
    case WY:
      return w.dot(K.R.col(1));
    case WZ:
      return w.dot(K.R.col(2));
    default:
      return 0;
  }
}

/// Markers of an element, at one state.
struct Now {
  const PlacedFunction& placed;
  std::span<const MarkerView> markers;
  const AngleMemory& memory;
  const AdamsUnits& units;
  double seconds;

  double time() const { return seconds / units.time; }
  double measure(int place) const {
    const AdamsMeasure& m = placed.function.measures[static_cast<std::size_t>(place)];
    const PlacedFunction::Places& at = placed.places[static_cast<std::size_t>(place)];
    const auto marker = [&](int which) -> const MarkerView& { return markers[static_cast<std::size_t>(which)]; };
    double value = 0;
    if (m.of_pose())
      value = measure_of_pose<double>(m.kind, pose_of(marker(at.i)), pose_of(marker(at.j)), pose_of(marker(at.k)));
    else
      value = of_velocity(m.kind, marker(at.i), marker(at.j), marker(at.k), marker(at.l));
    if (at.angle >= 0) value = memory.wound(at.angle, value);
    return value / unit_of(m.kind, units);
  }
};

/// Poses with derivatives.
template <class S, class Poses>
struct Differentiated {
  const PlacedFunction& placed;
  const Poses& poses;
  const AngleMemory& memory;
  const AdamsUnits& units;
  S seconds;

  S time() const { return seconds * (1 / units.time); }
  S measure(int place) const {
    const AdamsMeasure& m = placed.function.measures[static_cast<std::size_t>(place)];
    const PlacedFunction::Places& at = placed.places[static_cast<std::size_t>(place)];
    const auto pose = [&](int which) -> const PoseOf<S>& { return poses[static_cast<std::size_t>(which)]; };
    S value = measure_of_pose<S>(m.kind, pose(at.i), pose(at.j), pose(at.k));
    if (at.angle >= 0) value += S(memory.wound(at.angle, dual::value_of(value)) - dual::value_of(value));
    return value * (1 / unit_of(m.kind, units));
  }
};

template <int M>
void evaluate_row(const FunctionConstraint::Parameters& p, double seconds, std::span<const MarkerView> markers,
                  ConstraintRows& rows) {
  constexpr int N = 6 * M + 1;
  using D = Dual<N>;
  const auto& moved = by_residual::moved<M, N>(markers);
  D now(seconds);
  now.d[N - 1] = 1;
  const Differentiated<D, std::array<PoseOf<D>, M>> here{p.function, moved, rows, p.units, now};
  const D g = Value<D, decltype(here)>(p.function.function, here)();
  const auto poses = by_residual::in_time<M>(markers);
  const Differentiated<InTime, std::array<PoseOf<InTime>, M>> along{p.function, poses, rows, p.units,
                                                                    InTime(seconds, 1, 0)};
  const InTime motion = Value<InTime, decltype(along)>(p.function.function, along)();
  Wrench* W = rows.open();
  const double* d = g.d.data();
  for (int m = 0; m < M; ++m, d += 6) W[m] = {Vector3(d[0], d[1], d[2]), Vector3(d[3], d[4], d[5])};
  rows.finish_written(g.value, motion.acceleration, g.d[N - 1]);
}

struct TimeAlone {
  InTime now;
  InTime time() const { return now; }
  InTime measure(int) const { return {}; }
};

struct Seen {
  const AdamsFunction& function;
  const AdamsUnits& units;
  const Observed& from;
  double seconds;
  double time() const { return seconds / units.time; }
  double measure(int place) const {
    return observed_measure(function.measures[static_cast<std::size_t>(place)], units, from);
  }
};

}  // namespace

void FunctionForce::evaluate(double time, std::span<const MarkerView> markers, ForceRows& rows) const {
  double value[6] = {};
  for (std::size_t c = 0; c < 6; ++c)
    if (p_.functions[c]) {
      const Now now{*p_.functions[c], markers, rows, p_.units, time};
      value[c] = Value<double, Now>(p_.functions[c]->function, now)();
    }
  const MarkerView &I = markers[0], &J = markers[1], &axes = markers[static_cast<std::size_t>(p_.axes)];
  using enum AdamsModel::Load::Kind;
  Wrench w{Vector3::Zero(), Vector3::Zero()};
  switch (p_.kind) {
    case along_line: {
      const Vector3 d = I.p - J.p;
      const double length = d.norm();
      if (length > 0) w.force = p_.units.force * value[0] / length * d;
      break;
    }
    case about_z:
    case on_i_about_z:
      w.torque = p_.units.torque() * value[0] * axes.z();
      break;
    case on_i_along_z:
      w.force = p_.units.force * value[0] * axes.z();
      break;
    case components:
      w.force = axes.R * (p_.units.force * Vector3(value[0], value[1], value[2]));
      w.torque = axes.R * (p_.units.torque() * Vector3(value[3], value[4], value[5]));
      break;
  }
  rows.add_load(I, w);
  if (p_.kind == on_i_along_z || p_.kind == on_i_about_z) return;
  // The opposite at the place of I, on the body of J.
  rows.add_load(J, {-w.force, -w.torque - (I.p - J.p).cross(w.force)});
}

void FieldForce::evaluate(double, std::span<const MarkerView> markers, ForceRows& rows) const {
  using enum AdamsMeasure::Kind;
  const MarkerView &J = markers[0], &I = markers[1];
  const PoseOf<double> i = pose_of(I), j = pose_of(J);
  const Vector3 d = I.p - J.p;
  Vector6 x, rate;
  x << J.R.transpose() * d, rows.wound(0, measure_of_pose<double>(AX, i, j, j)),
      rows.wound(1, measure_of_pose<double>(AY, i, j, j)), rows.wound(2, measure_of_pose<double>(AZ, i, j, j));
  rate << J.R.transpose() * (I.v - J.v - J.w.cross(d)), J.R.transpose() * (I.w - J.w);
  const Vector6 load = p_.preload - p_.stiffness * (x - p_.free) - p_.damping * rate;
  const Vector3 force = J.R * load.head<3>(), torque = J.R * load.tail<3>();
  rows.add_load(I, {force, torque});
  rows.add_load(J, {-force, -torque - d.cross(force)});
}

void FunctionConstraint::evaluate(double time, std::span<const MarkerView> markers, ConstraintRows& rows) const {
  p_.markers == 2 ? evaluate_row<2>(p_, time, markers, rows) : evaluate_row<4>(p_, time, markers, rows);
}

void RateDrive::evaluate(double time, std::span<const MarkerView> markers, ConstraintRows& rows) const {
  const MeasuredCoordinate x = coordinate_.measure(0, markers, rows);
  const InTime f = in_time(p_.function, {time / p_.time, 1 / p_.time, 0});
  rows.add_velocity({x.on_A, x.on_B}, x.bias - p_.scale * f.rate, -p_.scale * f.value);
}

InTime in_time(const AdamsFunction& function, const InTime& time) {
  const TimeAlone now{time};
  return Value<InTime, TimeAlone>(function, now)();
}

double observed_measure(const AdamsMeasure& m, const AdamsUnits& units, const Observed& from) {
  using enum AdamsMeasure::Kind;
  if (m.of_load()) return from.load(m);
  const MarkerKinematics I = from.marker(m.i), J = from.marker(m.j), K = from.marker(m.k);
  const double unit = unit_of(m.kind, units);
  if (m.of_pose()) {
    if (m.kind >= E0 && m.kind <= E3) {
      const Eigen::Quaterniond e(Matrix3(J.R.transpose() * I.R));
      const double all[] = {e.w(), e.x(), e.y(), e.z()};
      return all[static_cast<int>(m.kind) - static_cast<int>(E0)];
    }
    const double value = measure_of_pose<double>(m.kind, pose_of(I), pose_of(J), pose_of(K));
    if (!m.is_angle()) return value / unit;
    const double turn = 2 * std::numbers::pi;
    return value + turn * std::round((from.angle(m) - value) / turn);
  }
  if (m.of_velocity()) return of_velocity(m.kind, I, J, K, from.marker(m.l)) / unit;
  const Vector6 a = from.acceleration(m.i) - from.acceleration(m.j);
  const Vector3 along = m.kind <= ACCZ ? a.head<3>() : a.tail<3>();
  if (m.kind == ACCM || m.kind == WDTM) return along.norm() / unit;
  const int c = static_cast<int>(m.kind) - static_cast<int>(m.kind <= ACCZ ? ACCX : WDTX);
  return along.dot(K.R.col(c)) / unit;
}

double observed_value(const AdamsFunction& function, const AdamsUnits& units, double time, const Observed& from) {
  const Seen seen{function, units, from, time};
  return Value<double, Seen>(function, seen)();
}

}  // namespace lithe::adams

namespace lithe {
template std::unique_ptr<ForceBatch> make_force_batch<adams::FunctionForce>();
template std::unique_ptr<ForceBatch> make_force_batch<adams::FieldForce>();
template std::unique_ptr<ConstraintBatch> make_constraint_batch<adams::FunctionConstraint>();
template std::unique_ptr<ConstraintBatch> make_constraint_batch<adams::RateDrive>();
}  // namespace lithe
