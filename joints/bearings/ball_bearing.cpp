#include "joints/bearings/ball_bearing.h"

#include <numbers>

#include "engine/assembly/batch_of.h"
#include "engine/base/checks.h"
#include "engine/base/number_text.h"

namespace lithe {

BallBearing::BallBearing(Parameters p)
    : RollingBearing({p.balls, p.ball_diameter, p.pitch_diameter, p.contact_angle, p.ball_diameter, p.losses},
                     "balls") {
  const double D = p.ball_diameter;
  for (const auto& [radius, name] : {std::pair(p.inner_groove_radius, "inner_groove_radius"),
                                     std::pair(p.outer_groove_radius, "outer_groove_radius")}) {
    require::positive(radius, name);
    if (radius <= 0.5 * D)
      throw SceneError(std::string(name) + " " + number_text(radius) + " m is not above the balls' radius " +
                           number_text(0.5 * D) + " m: they do not fit the groove",
                       "", "give a groove radius of some 0.515 to 0.53 ball diameters");
  }
  require::positive(p.material.youngs_modulus, "youngs_modulus");
  require::finite(p.material.poissons_ratio, "poissons_ratio");
  if (std::abs(p.material.poissons_ratio) > 0.5)
    throw SceneError("poissons_ratio " + number_text(p.material.poissons_ratio) + " is not of an elastic solid", "",
                     "give one between 0 and 0.5; 0.3 for steel");
  require::finite(p.clearance, "clearance");
  require::not_negative(p.preload, "preload");
  require::finite(p.speed, "speed");
  require::positive(p.ball_density, "ball_density");
  distance_ = p.inner_groove_radius + p.outer_groove_radius - D;
  const double cosine = std::cos(p.contact_angle), sine = std::sin(p.contact_angle);
  axial_ = distance_ * sine, radial_ = distance_ * cosine - 0.5 * p.clearance;
  if (radial_ <= 0)
    throw SceneError("clearance " + number_text(p.clearance) + " m is more than the grooves leave, " +
                         number_text(2 * distance_ * cosine) + " m",
                     "", "give the diametral clearance in metres, some 1e-5");
  groove_radius_ = 0.5 * p.pitch_diameter + (p.inner_groove_radius - 0.5 * D) * cosine;
  groove_place_ = (p.inner_groove_radius - 0.5 * D) * sine;

  // Curvatures across the groove and along the rolling direction (Harris & Kotzalas, ch. 2).
  const double gamma = D * cosine / p.pitch_diameter;
  const HertzPoint inner(2 / D - 1 / p.inner_groove_radius, 2 / D + 2 * gamma / (D * (1 - gamma)), p.material);
  const HertzPoint outer(2 / D - 1 / p.outer_groove_radius, 2 / D - 2 * gamma / (D * (1 + gamma)), p.material);
  stiffness_ = std::pow(std::pow(inner.stiffness, -2.0 / 3) + std::pow(outer.stiffness, -2.0 / 3), -1.5);
  if (p.speed != 0) {
    const double mass = p.ball_density * std::numbers::pi * D * D * D / 6, orbit = 0.5 * (1 - gamma) * p.speed;
    spinning_.emplace(SpinningBall::Contact{p.inner_groove_radius - 0.5 * D, inner.stiffness},
                      SpinningBall::Contact{p.outer_groove_radius - 0.5 * D, outer.stiffness},
                      mass * 0.5 * p.pitch_diameter * orbit * orbit);
  }

  if (p.preload == 0) return;
  // The axial approach at which all balls together carry the preload; they grow with it.
  const double sense = p.contact_angle < 0 ? -1 : 1;
  double low = 0, high = distance_;
  const auto carried = [&](double approach) { return sense * p.balls * at_rest({sense * approach, 0, 0}).force[0]; };
  if (carried(high) < p.preload)
    throw SceneError("preload " + number_text(p.preload) + " N is beyond what the grooves hold, " +
                         number_text(carried(high)) + " N",
                     "", "lower the preload, or give larger or more balls");
  for (int i = 0; i < 100; ++i) {
    const double middle = 0.5 * (low + high);
    (carried(middle) < p.preload ? low : high) = middle;
  }
  axial_ += sense * low;
}

Eigen::Matrix<double, 2, 3> BallBearing::by_motion() const {
  Eigen::Matrix<double, 2, 3> by;
  by << 1, 0, -groove_radius_, 0, 1, groove_place_;
  return by;
}

RollingBearing::PlaneLoad BallBearing::in_plane(const Vector3& motion) const {
  if (!spinning_) return at_rest(motion);
  const Eigen::Matrix<double, 2, 3> by = by_motion();
  const SpinningBall::Balance ball = spinning_->at(Eigen::Vector2d(axial_, radial_) + by * motion);
  PlaneLoad load;
  load.element = {ball.force.norm(), ball.inner_angle, ball.outer_load, ball.outer_angle};
  load.energy = ball.energy;
  load.force = by.transpose() * ball.force;
  load.stiffness = by.transpose() * ball.stiffness * by;
  return load;
}

RollingBearing::PlaneLoad BallBearing::at_rest(const Vector3& motion) const {
  const Eigen::Matrix<double, 2, 3> by = by_motion();
  const Eigen::Vector2d d = Eigen::Vector2d(axial_, radial_) + by * motion;
  const double length = d.norm(), depth = length - distance_;
  PlaneLoad load;
  load.element.contact_angle = load.element.outer_angle = std::atan2(d[0], d[1]);
  if (depth <= 0) return load;
  const double root = std::sqrt(depth), Q = stiffness_ * depth * root;
  const Eigen::Vector2d n = d / length;
  const Eigen::Matrix2d along = n * n.transpose(), across = Eigen::Matrix2d::Identity() - along;
  load.element.force = load.element.outer_force = Q;
  load.energy = 0.4 * Q * depth;
  load.force = by.transpose() * (Q * n);
  load.stiffness = by.transpose() * (1.5 * stiffness_ * root * along + Q / length * across) * by;
  return load;
}

template std::unique_ptr<ForceBatch> make_force_batch<BallBearing>();

}  // namespace lithe
