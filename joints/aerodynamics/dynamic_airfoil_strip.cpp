#include "joints/aerodynamics/dynamic_airfoil_strip.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/assembly/batch_of.h"
#include "engine/base/checks.h"
#include "engine/model/marker_motions.h"
#include "engine/observe/snapshot.h"

namespace lithe {
namespace {

constexpr double kPi = std::numbers::pi;

/// √f, with a slope at 0.
double root_of(double f) { return f / std::sqrt(std::abs(f) + 1e-4); }

/// The law within its bounds; an effective angle may pass them.
AirfoilCoefficients steady(const AirfoilLaw& law, double angle) { return law(std::clamp(angle, -kPi, kPi)); }

}  // namespace

/// The strip at one state.
struct DynamicAirfoilStrip::Instant {
  Eigen::Vector2d u;        // along the chord, along its normal
  double speed, turning;    // W; W times the lift of turning, π c ω/2
  double angle, effective;  // α, α_E
  AirfoilCoefficients acting;
  double wake_1, wake_2, pressure, separation;  // rates of the states
};

DynamicAirfoilStrip::DynamicAirfoilStrip(Parameters p)
    : airfoil_(p.strip.airfoil),
      lags_(p.lags),
      chord_(p.strip.chord),
      section_(std::move(p.strip)),
      separated_(airfoil_),
      least_drag_(airfoil_(separated_.zero_lift()).drag) {
  require::not_negative(lags_.wake_share_1, "lags.wake_share_1");
  require::not_negative(lags_.wake_share_2, "lags.wake_share_2");
  require::positive(lags_.wake_rate_1, "lags.wake_rate_1");
  require::positive(lags_.wake_rate_2, "lags.wake_rate_2");
  require::positive(lags_.pressure, "lags.pressure");
  require::positive(lags_.separation, "lags.separation");
  if (!(lags_.wake_share_1 + lags_.wake_share_2 <= 1))
    throw SceneError("the wake's shares add up to more than 1", "", "give A₁ + A₂ of at most 1: ½ of a thin section");
}

VectorX DynamicAirfoilStrip::start() { return Vector6{{0, 0, 0, 1, 0, 0}}; }

VectorX DynamicAirfoilStrip::settled(const Parameters& p, double angle, double speed) {
  const DynamicAirfoilStrip strip(p);
  const double across = speed * std::sin(angle);
  const SeparatedLift::At at = strip.separated_.at(angle, steady(strip.airfoil_, angle).lift);
  return Vector6{{p.lags.wake_share_1 * across, p.lags.wake_share_2 * across, at.attached, at.point, 0, 0}};
}

DynamicAirfoilStrip::Instant DynamicAirfoilStrip::at(double time, std::span<const MarkerView> markers) const {
  Instant now{};
  now.u = section_.flow(time, markers[0]);
  now.speed = now.u.norm();
  if (now.speed == 0) return now;
  const auto& [A_1, A_2, b_1, b_2, T_p, T_f] = lags_;
  const Vector3& z = markers[1].v;  // y₁, y₂, p
  const double p = z[2], f = markers[2].v[0], rate = 2 * now.speed / chord_;
  now.turning = 0.5 * kPi * chord_ * markers[0].w.dot(markers[0].R.col(0));
  // 1. The wake.
  const double across = now.u[1] * (1 - A_1 - A_2) + z[0] + z[1];
  now.angle = std::atan2(now.u[1], -now.u[0]), now.effective = std::atan2(across, -now.u[0]);
  now.wake_1 = rate * b_1 * (A_1 * now.u[1] - z[0]);
  now.wake_2 = rate * b_2 * (A_2 * now.u[1] - z[1]);
  // 2. Pressure and separation.
  const AirfoilCoefficients c = airfoil_(now.effective);
  const SeparatedLift::At lift = separated_.at(now.effective, c.lift);
  now.pressure = (rate * (lift.attached - p) + 2 / chord_ * now.turning) / T_p;
  const double lagging = p / separated_.slope() + separated_.zero_lift();
  now.separation = rate * (separated_.at(lagging, steady(airfoil_, lagging).lift).point - f) / T_f;
  // 3. What acts.
  now.acting.lift = lift.attached * f + lift.separated * (1 - f) + now.turning / now.speed;
  now.acting.drag = c.drag + std::remainder(now.angle - now.effective, 2 * kPi) * now.acting.lift +
                    (c.drag - least_drag_) * (0.5 * (root_of(lift.point) - root_of(f)) - 0.25 * (lift.point - f));
  now.acting.moment = c.moment;
  return now;
}

void DynamicAirfoilStrip::evaluate(double time, std::span<const MarkerView> markers, ForceRows& rows) const {
  const Instant now = at(time, markers);
  if (now.speed > 0) rows.add_load(markers[0], section_.load(markers[0], now.u, now.acting, 0.25 * kPi));
  rows.add_load(markers[1], force({now.wake_1, now.wake_2, now.pressure}));
  rows.add_load(markers[2], force({now.separation, 0, 0}));
}

Sensor DynamicAirfoilStrip::flow(Located name) const {
  if (name.text.empty()) name.text = this->name();
  const std::string text = name.text;
  return Sensor(std::move(name), {text + "_angle", text + "_effective", text + "_separation", text + "_lift"},
                [this](Snapshot& now, std::span<double> out) {
                  const MarkerMotions motions(markers(), [&](const Marker& m) { return now.marker(m); });
                  const Instant here = at(now.time(), motions);
                  out[0] = here.angle, out[1] = here.effective, out[2] = motions[2].v[0], out[3] = here.acting.lift;
                },
                {"rad", "rad", "", ""});
}

std::vector<DrawnShape> DynamicAirfoilStrip::drawn_shapes(int marker) const {
  if (marker != 0 || dynamic_cast<const DrawableBody*>(markers()[0].body)) return {};
  return {section_.shape()};
}

template std::unique_ptr<ForceBatch> make_force_batch<DynamicAirfoilStrip>();

}  // namespace lithe
