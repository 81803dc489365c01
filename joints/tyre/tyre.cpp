#include "joints/tyre/tyre.h"

#include <cmath>
#include <numbers>

#include "engine/assembly/batch_of.h"
#include "engine/base/checks.h"
#include "engine/model/initial_pose.h"
#include "engine/model/marker_motions.h"

namespace lithe {

namespace {

constexpr double kFlat = 0.05;     // of cos γ: below it a wheel does not touch
constexpr double kShortest = 0.1;  // of R_0: relaxation length

/// 1 at rest, 0 from the speed `low` on.
double slowness(double speed, double low) {
  return std::abs(speed) < low ? 0.5 + 0.5 * std::cos(std::numbers::pi * speed / low) : 0;
}

/// Of a deflection whose slip is beyond what any grip holds: grows from 0.8 to 1, where it stops the growth.
double slides(double slip) {
  const double over = std::max(0.0, (std::abs(slip) - 0.8) / 0.2);
  return std::copysign(over * over, slip);
}

}  // namespace

/// Of the spring at a deflection: force, slope, potential; damping and its slope.
struct Tyre::Radial {
  double force = 0, stiffness = 0, energy = 0, damping = 0, damping_slope = 0;
};

Tyre::Tyre(Parameters parameters) : p_(std::move(parameters)), formula_(p_.coefficients) {
  const TyreCoefficients& c = p_.coefficients;
  require::not_negative(p_.pressure, "pressure");
  require::not_negative(p_.low_speed_damping, "low_speed_damping");
  require::not_negative(c.vertical_damping, "vertical_damping");
  for (const double value : {c.breff, c.dreff, c.freff, c.q_v1, c.q_v2, c.pfz1, c.q_fz2})
    require::finite(value, "a coefficient of the vertical");
  require::positive(c.q_re0, "q_re0");
  const double size = c.vertical_stiffness * c.unloaded_radius / c.fnomin;
  linear_ = c.q_fz1 != 0 ? c.q_fz1 : std::sqrt(std::max(0.0, size * size - 4 * c.q_fz2));
  require::positive(linear_, "q_fz1, or vertical_stiffness,");
  if (c.nompres > 0)
    by_pressure_ = ((p_.pressure > 0 ? p_.pressure : c.inflpres > 0 ? c.inflpres : c.nompres) - c.nompres) / c.nompres;
  const double stiffer = 1 + c.pfz1 * by_pressure_, slope = linear_ * linear_ + 4 * c.q_fz2;
  require::positive(stiffer, "1 + pfz1 dp"), require::positive(slope, "q_fz1² + 4 q_fz2");
  sag_ = c.unloaded_radius / (stiffer * std::sqrt(slope));
  if (!(c.longitudinal_stiffness > 0 || c.ptx1 > 0) || !(c.lateral_stiffness > 0 || (c.pty1 > 0 && c.pty2 > 0)))
    throw SceneError("the tyre has no relaxation length", "",
                     "give longitudinal_stiffness and lateral_stiffness of the carcass, or ptx1, pty1 and pty2");
  if (p_.road) p_.road->require_passable(c.unloaded_radius);
}

Tyre::Radial Tyre::radial(double deflection) const {
  if (deflection <= 0) return {};
  const TyreCoefficients& c = p_.coefficients;
  const double r = deflection / c.unloaded_radius, F = c.fnomin * (1 + c.pfz1 * by_pressure_);
  const double full = 0.05 * sag_;
  Radial at{F * r * (linear_ + c.q_fz2 * r), F * (linear_ + 2 * c.q_fz2 * r) / c.unloaded_radius,
            F * c.unloaded_radius * r * r * (linear_ / 2 + c.q_fz2 * r / 3), c.vertical_damping, 0};
  if (deflection < full) at.damping *= deflection / full, at.damping_slope = c.vertical_damping / full;
  return at;
}

Tyre::Contact Tyre::contact(std::span<const MarkerView> markers, Radial& row, double& deflection_rate) const {
  const TyreCoefficients& t = p_.coefficients;
  const auto &A = markers[0], &B = markers[1];
  const Vector3 axle = B.z(), centre = B.p - A.p;
  Contact c;
  c.normal = A.z();
  Vector3 from_plane = centre;
  if (p_.road) {
    const Vector3 in_road = A.R.transpose() * axle;
    const Vector3 heading = in_road.cross(Vector3::UnitZ());
    const double length = heading.norm();
    const TyreRoad::Plane plane = p_.road->plane_below(A.R.transpose() * centre, in_road,
                                                       length > 0 ? Vector3(heading / length) : Vector3::UnitX());
    c.normal = A.R * plane.normal;
    from_plane -= A.R * plane.point;
  }
  const double sine = std::clamp(c.normal.dot(axle), -1.0, 1.0), cosine = std::sqrt(1 - sine * sine);
  c.camber = std::asin(sine);
  c.spin = axle.dot(B.w - A.w);
  const double pace = t.unloaded_radius * c.spin / t.longvl, still = t.unloaded_radius * t.q_re0;
  const double free = still + t.unloaded_radius * t.q_v1 * pace * pace;
  if (cosine < kFlat) {
    c.point = B.p, c.forward = A.x(), c.deflection = -free, c.radius = free, deflection_rate = 0;
    return c;
  }
  c.forward = axle.cross(c.normal) / cosine;
  const double loaded = c.normal.dot(from_plane) / cosine;
  const Vector3 down = (loaded / cosine) * (sine * axle - c.normal);  // R_l, within the wheel's plane
  c.point = B.p + down;
  c.deflection = free - loaded;

  const Vector3 turning = B.w - A.w, moving = B.v - A.v - A.w.cross(centre), there = moving + turning.cross(down);
  deflection_rate = -c.normal.dot(there) / cosine;
  // The row is the spring of a wheel that does not spin; what spin adds is a load.
  const Radial spinning = radial(c.deflection);
  const double tension = spinning.force * (1 + t.q_v2 * std::abs(pace)) + spinning.damping * deflection_rate;
  row = radial(still - loaded);
  if (tension > 0)
    c.load = tension / cosine;
  else
    row = {.energy = row.energy};

  const double by_load = c.load / t.fnomin;
  c.radius = free - sag_ * (t.dreff * std::atan(t.breff * by_load) + t.freff * by_load);
  c.speed = c.forward.dot(moving);
  c.slip_x = c.speed - c.spin * c.radius;
  c.slip_y = c.normal.cross(c.forward).dot(there);
  roll(markers, c);
  return c;
}

void Tyre::roll(std::span<const MarkerView> markers, Contact& c) const {
  const TyreCoefficients& t = p_.coefficients;
  const double u = markers[2].v.x(), v = markers[2].v.y(), side = p_.mirrored ? -1 : 1;
  const auto K = formula_.stiffness(c.load, side * c.camber, p_.pressure);
  const double nominal = t.fnomin * t.lfzo, df = (c.load - nominal) / nominal, least = 1e-6 * c.load;
  const double K_x = std::max(least, std::abs(K.longitudinal)), K_y = std::max(least, std::abs(K.cornering));
  // Of the carcass, N/m: a tenth of the nominal one at least, where the fit of another load would turn its sign.
  const auto carcass = [&](double stiffness, double linear, double square, double pressure) {
    return stiffness * std::max(0.1, (1 + linear * df + square * df * df) * (1 + pressure * by_pressure_));
  };
  const double shortest = kShortest * t.unloaded_radius;
  c.relaxation_x = t.longitudinal_stiffness > 0
                       ? K_x / carcass(t.longitudinal_stiffness, t.pcfx1, t.pcfx2, t.pcfx3)
                       : c.load * (t.ptx1 + t.ptx2 * df) * std::exp(-t.ptx3 * df) * t.unloaded_radius / t.fnomin;
  c.relaxation_y = t.lateral_stiffness > 0
                       ? K_y / carcass(t.lateral_stiffness, t.pcfy1, t.pcfy2, t.pcfy3)
                       : t.pty1 * std::sin(2 * std::atan(c.load / (t.pty2 * nominal))) *
                             (1 - t.pky3 * std::abs(std::sin(c.camber))) * t.unloaded_radius * t.lfzo;
  c.relaxation_x = std::max(shortest, t.lsgkp * c.relaxation_x);
  c.relaxation_y = std::max(shortest, t.lsgal * c.relaxation_y);

  c.kappa = u / c.relaxation_x;
  const double tangent = -v / c.relaxation_y, slow = slowness(c.speed, t.vxlow);
  c.alpha = std::atan(tangent);
  c.u_dot = -c.slip_x - std::abs(c.speed) * c.kappa - slow * std::abs(c.slip_x) * slides(c.kappa);
  c.v_dot = -c.slip_y + std::abs(c.speed) * tangent + slow * std::abs(c.slip_y) * slides(tangent);
  if (c.load == 0) return;

  // Slip that a damper of the carcass adds near rest: ζ 2 √(C m) at the nominal load, C = K / σ.
  const double damping = slow * p_.low_speed_damping * 2 * std::sqrt(nominal / 9.81) * c.load / nominal;
  const double more_x = damping * c.slip_x / std::sqrt(K_x * c.relaxation_x);
  const double more_y = damping * c.slip_y / std::sqrt(K_y * c.relaxation_y);
  c.reaction = formula_.at({.kappa = c.kappa - more_x,
                            .alpha = side * std::atan(tangent + more_y),
                            .camber = side * c.camber,
                            .load = c.load,
                            .speed = c.speed,
                            .pressure = p_.pressure});
  c.reaction.Fy *= side, c.reaction.Mx *= side, c.reaction.Mz *= side;
}

Tyre::Contact Tyre::contact(std::span<const MarkerView> markers) const {
  Radial row;
  double rate = 0;
  return contact(markers, row, rate);
}

void Tyre::evaluate(double, std::span<const MarkerView> markers, ForceRows& rows) const {
  const auto &A = markers[0], &B = markers[1];
  Radial row;
  double rate = 0;
  const Contact c = contact(markers, row, rate);
  const double cosine = std::cos(c.camber), tension = row.force + row.damping * rate;
  const Vector3 arm_A = c.point - A.p, arm_B = c.point - B.p;
  const Vector3 W = cosine < kFlat ? Vector3::Zero() : Vector3(c.normal / cosine);
  rows.add({{W, arm_A.cross(W)}, {-W, -arm_B.cross(W)}, {Vector3::Zero(), Vector3::Zero()}}, tension,
           row.stiffness + row.damping_slope * rate, row.damping, row.energy);

  const Vector3 left = c.normal.cross(c.forward);
  const Vector3 force = c.reaction.Fx * c.forward + c.reaction.Fy * left + (c.load - tension * W.norm()) * c.normal;
  const Vector3 moment = c.reaction.Mx * c.forward + c.reaction.My * left + c.reaction.Mz * c.normal;
  rows.add_load(B, {force, arm_B.cross(force) + moment});
  rows.add_load(A, {-force, -arm_A.cross(force) - moment});
  rows.add_load(markers[2], {Vector3(c.u_dot, c.v_dot, 0), Vector3::Zero()});
}

void Tyre::initialize(std::span<const MarkerView> m) { initial::not_parallel(m[0].z(), m[1].z(), "z", "z"); }

Sensor tyre_contact(const Tyre& tyre, Located name) {
  const std::string prefix = (name.text.empty() ? tyre.name() : name.text) + "_";
  if (name.text.empty()) name.text = tyre.name() + "_contact";
  std::vector<std::string> columns;
  for (const char* ending : {"kappa", "alpha", "camber", "deflection", "Fx", "Fy", "Fz", "Mx", "My", "Mz", "power"})
    columns.push_back(prefix + ending);
  return Sensor(
      std::move(name), columns,
      [&tyre](Snapshot& now, std::span<double> out) {
        const MarkerMotions markers(tyre.markers(), [&](const Marker& m) { return now.marker(m); });
        const std::span<const MarkerView> at = markers;
        const Tyre::Contact c = tyre.contact(markers);
        const auto& r = c.reaction;
        const Vector3 left = c.normal.cross(c.forward), turning = at[1].w - at[0].w;
        const Vector3 moving = at[1].v - at[0].v - at[0].w.cross(c.point - at[0].p) + at[1].w.cross(c.point - at[1].p);
        const double power = (r.Fx * c.forward + r.Fy * left + c.load * c.normal).dot(moving) +
                             (r.Mx * c.forward + r.My * left + r.Mz * c.normal).dot(turning);
        const double values[] = {c.kappa, c.alpha, c.camber, c.deflection, r.Fx, r.Fy, c.load, r.Mx, r.My, r.Mz, power};
        std::copy(std::begin(values), std::end(values), out.begin());
      },
      {"", "rad", "rad", "m", "N", "N", "N", "N m", "N m", "N m", "W"});
}

template std::unique_ptr<ForceBatch> make_force_batch<Tyre>();

}  // namespace lithe
