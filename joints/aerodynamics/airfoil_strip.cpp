#include "joints/aerodynamics/airfoil_strip.h"

#include <cmath>

#include "engine/assembly/batch_of.h"
#include "engine/base/checks.h"

namespace lithe {

AirfoilStrip::AirfoilStrip(Parameters parameters)
    : parameters_(std::move(parameters)),
      chord_(0, std::cos(parameters_.twist), std::sin(parameters_.twist)),
      normal_(0, -std::sin(parameters_.twist), std::cos(parameters_.twist)) {
  require::positive(parameters_.width, "width");
  require::positive(parameters_.chord, "chord");
  require::positive(parameters_.density, "density");
  require::finite(parameters_.twist, "twist");
  require::finite(parameters_.ahead, "ahead");
  if (!parameters_.airfoil)
    throw SceneError("it has no airfoil", "", "give .airfoil = airfoil_table(angles, lift, drag, moment)");
}

Eigen::Vector2d AirfoilStrip::flow(double time, const MarkerView& m) const {
  const Vector3 point = m.R * ((parameters_.ahead - 0.5 * parameters_.chord) * chord_);
  Vector3 u = -(m.v + m.w.cross(point));
  if (parameters_.wind) u += parameters_.wind(m.p + point, time);
  return {u.dot(m.R * chord_), u.dot(m.R * normal_)};
}

double AirfoilStrip::angle_of_attack(double time, const MarkerView& marker) const {
  const Eigen::Vector2d u = flow(time, marker);
  return u.isZero(0) ? 0 : std::atan2(u[1], -u[0]);
}

Wrench AirfoilStrip::load(const MarkerView& m, const Eigen::Vector2d& u, const AirfoilCoefficients& c,
                          double turning) const {
  const double chord = parameters_.chord, speed = u.norm();
  // u × e_span has the parts (u_n, -u_c).
  const double share = 0.5 * parameters_.density * chord * parameters_.width * speed;
  const Vector3 force = share * ((c.lift * u[1] + c.drag * u[0]) * chord_ + (c.drag * u[1] - c.lift * u[0]) * normal_);
  Vector3 torque = (parameters_.ahead * chord_).cross(force);
  torque[0] += share * chord * (speed * c.moment - turning * chord * m.w.dot(m.R.col(0)));
  return {m.R * force, m.R * torque};
}

void AirfoilStrip::evaluate(double time, std::span<const MarkerView> markers, ForceRows& rows) const {
  const Eigen::Vector2d u = flow(time, markers[0]);
  if (u.isZero(0)) return;
  rows.add_load(markers[0], load(markers[0], u, parameters_.airfoil(std::atan2(u[1], -u[0])), M_PI / 8));
}

DrawnShape AirfoilStrip::shape() const {
  const double chord = parameters_.chord;
  Matrix3 axes;
  axes << Vector3::UnitX(), chord_, normal_;
  return visual::box({parameters_.width, chord, 0.05 * chord}).at((parameters_.ahead - 0.25 * chord) * chord_, axes);
}

std::vector<DrawnShape> AirfoilStrip::drawn_shapes(int /*marker*/) const {
  if (dynamic_cast<const DrawableBody*>(markers()[0].body)) return {};
  return {shape()};
}

template std::unique_ptr<ForceBatch> make_force_batch<AirfoilStrip>();

Sensor angle_of_attack(const AirfoilStrip& strip, Located name) {
  if (name.text.empty()) name.text = strip.name() + "_angle_of_attack";
  const std::string column = name.text;
  return {std::move(name),
          {column},
          [&strip](Snapshot& now, std::span<double> values) {
            const MarkerKinematics k = now.marker(strip.markers()[0]);
            values[0] = strip.angle_of_attack(now.time(), {k, 0});
          },
          {"rad"}};
}

}  // namespace lithe
