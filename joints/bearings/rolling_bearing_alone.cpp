#include "engine/base/checks.h"
#include "engine/base/dense.h"
#include "engine/base/number_text.h"
#include "joints/bearings/rolling_bearing.h"

/// What a bearing does without a scene: statics and frequencies.
namespace lithe {

namespace {

Vector6 with_cage(const Vector5& deflection, double cage) {
  Vector6 at;
  at << deflection, cage;
  return at;
}

}  // namespace

Vector5 RollingBearing::load(const Vector5& deflection, double cage) const {
  return loads(with_cage(deflection, cage)).force.head<5>();
}

Matrix5 RollingBearing::stiffness(const Vector5& deflection, double cage) const {
  return loads(with_cage(deflection, cage)).stiffness.topLeftCorner<5, 5>();
}

std::vector<RollingElementLoad> RollingBearing::element_loads(const Vector5& deflection, double cage) const {
  std::vector<RollingElementLoad> each;
  loads(with_cage(deflection, cage), &each);
  return each;
}

/// V is convex: Newton on V - F·e, each step as short as it must be for that to sink (Levenberg: a bearing with
/// clearance has no stiffness at first). Tilts are weighed by the pitch radius.
Vector5 RollingBearing::deflection(const Vector5& load, double cage) const {
  require::finite(load, "load");
  const double radius = 0.5 * layout_.pitch_diameter;
  Vector5 metric;
  metric << 1, 1, 1, radius * radius, radius * radius;
  const auto size = [&](const Vector5& f) { return f.cwiseQuotient(metric.cwiseSqrt()).norm(); };
  const double wanted = 1e-12 * size(load);
  Vector5 e = Vector5::Zero();
  Loads now = loads(with_cage(e, cage));
  double shift = size(load) / (1e-3 * layout_.diameter);  // N/m
  for (int i = 0; i < 500; ++i) {
    const Vector5 lack = load - now.force.head<5>();
    if (size(lack) <= wanted) return e;
    MatrixX K = now.stiffness.topLeftCorner<5, 5>();
    K.diagonal() += shift * metric;
    const Vector5 by = Eigen::LLT<MatrixX>(K).solve(VectorX(lack)), next = e + by;
    const Loads there = loads(with_cage(next, cage));
    const double gain = load.dot(by) - (there.energy - now.energy);
    if (gain >= 0 || size(load - there.force.head<5>()) < size(lack)) {
      e = next, now = there, shift *= 0.1;
    } else {
      shift *= 4;
    }
    if (e.head<3>().norm() > layout_.diameter) break;
  }
  if (size(load - now.force.head<5>()) <= 1e3 * wanted) return e;
  throw SceneError(
      "'" + name() + "' finds no deflection under a load of (" + number_text(load[0]) + ", " + number_text(load[1]) +
          ", " + number_text(load[2]) + ") N and (" + number_text(load[3]) + ", " + number_text(load[4]) + ") N m",
      where(),
      "a bearing of cylindrical rollers carries no axial load, balls of a contact angle carry it in one sense");
}

BearingFrequencies RollingBearing::frequencies(double speed) const {
  const double gamma = 1 - 2 * cage_ratio_;
  BearingFrequencies f;
  f.cage = cage_ratio_ * speed;
  f.outer_pass = layout_.count * f.cage;
  f.inner_pass = layout_.count * (speed - f.cage);
  // γ is D cos α / d_m.
  f.spin = 0.5 * speed * layout_.pitch_diameter / layout_.diameter * (1 - gamma * gamma);
  return f;
}

}  // namespace lithe
