#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "bodies/rigid_body.h"
#include "engine/assembly/batch_of.h"
#include "engine/model/constraint.h"
#include "engine/model/force_element.h"

/// A railway wheelset on straight track, scaled to a roller rig (Simeon, Führer & Rentrop 1991; creep forces after
/// Jaschinski 1990; "wheelset" of the IVP Test Set), made of elements of the engine's public interfaces.
///
/// World axes move along the track at the speed V: x to the left side, y up, z forward. The body's axes turn with the
/// wheelset less its steady spin Ω = V/r0 about its axle e1, about which it is a body of revolution: its ω is small.
/// Cones roll on circular rails; e1, e2, e3 follow the axle but do not spin: e3 horizontal, e2 upward.
namespace lithe::test::wheelset {

inline constexpr double kMass = 16.08, kSpinInertia = 0.0605, kInertia = 0.366;   // kg, kg m²
inline constexpr double kSpeed = 30, kRadius = 0.1, kSpin = kSpeed / kRadius;     // V, r0, Ω
inline constexpr double kRailRadius = 0.06, kHalfGauge = 0.1506, kCone = 0.0262;  // rs, a0 (m), δ0 (rad)
inline constexpr double kSpring = 6400, kLever = 0.19;                            // cx = cz (N/m), xl (m)

/// Where one wheel touches its rail: a function of the lateral place and the axle a alone; and how that moves.
/// The wheel at ξ along the axle has the radius R = r0 + tan δ0 (a0 - |ξ|); r = ξ a - R u points from the body's
/// middle to the contact, u ⟂ a. The wheel's normal R' a + u has no z component; with it n = (slope, -1, 0).
struct Contact {
  double side;  // +1 left, -1 right
  double xi, R, slope, w;
  Vector3 u, arm, normal;         // arm r, normal n
  Vector3 arm_rate, normal_rate;  // of the contact, which wanders on the wheel

  Contact(double k, const Vector3& p, const Vector3& a, const Vector3& v, const Vector3& omega) : side(k) {
    const double t = std::tan(kCone), cone = -k * t;  // R'
    const Vector3 up = Vector3::UnitZ(), a_rate = omega.cross(a);
    // u = lift b1 - tilt b2 with b1 and b2 across the axle, b1 horizontal in z
    const double along = a.z(), rho2 = 1 - along * along, rho = std::sqrt(rho2), rho_rate = -along * a_rate.z() / rho;
    const double tilt = cone * along / rho, tilt_rate = cone * a_rate.z() / (rho * rho2);
    const double lift = std::sqrt(1 - tilt * tilt), lift_rate = -tilt * tilt_rate / lift;
    const Vector3 b1 = up.cross(a) / rho, b1_rate = (up.cross(a_rate) - rho_rate * b1) / rho;
    const Vector3 b2 = (up - along * a) / rho, b2_rate = (-a_rate.z() * a - along * a_rate - rho_rate * b2) / rho;
    u = lift * b1 - tilt * b2;
    const Vector3 u_rate = lift_rate * b1 + lift * b1_rate - tilt_rate * b2 - tilt * b2_rate;
    const Vector3 N = cone * a + u, N_rate = cone * a_rate + u_rate;
    slope = -N.x() / N.y();
    const double slope_rate = -(N_rate.x() + slope * N_rate.y()) / N.y();
    // The rail's point with that slope, and the ξ that lies above it.
    const double root = std::sqrt(1 + slope * slope);
    w = -k * kRailRadius * slope / root;
    const double w_rate = -k * kRailRadius * slope_rate / (root * root * root);
    const double X = k * (kHalfGauge + kRailRadius * std::sin(kCone) + w), apex = kRadius + t * kHalfGauge;
    const double lever = a.x() + k * t * u.x();
    xi = (X - p.x() + apex * u.x()) / lever;
    const double xi_rate = (k * w_rate - v.x() + apex * u_rate.x() - xi * (a_rate.x() + k * t * u_rate.x())) / lever;
    R = apex + cone * xi;
    arm = xi * a - R * u;
    arm_rate = xi_rate * a + xi * a_rate - cone * xi_rate * u - R * u_rate;
    normal = {slope, -1, 0};
    normal_rate = {slope_rate, 0, 0};
  }
};

/// Both wheels stay on their rails: n · (v + ω × r) = 0 on each side, on velocities alone (the Test Set's index 2).
/// The normal meets the axle, so the steady spin left out of ω does nothing. The Test Set's yaw equation has the moment
/// of n about y where this one has that about e2, 1/cos(roll) of it: 1e-6 of a small moment, far below its digits.
/// Markers: the track, the wheelset with x along its axle.
class Rails final : public Joint</*markers=*/2, /*rows=*/2> {
 public:
  struct Parameters {};
  explicit Rails(Parameters) {}
  void evaluate(double, std::span<const MarkerView> markers, ConstraintRows& rows) const override {
    const MarkerView& B = markers[1];
    for (double side : {1.0, -1.0}) {
      const Contact c(side, B.p, B.x(), B.v, B.w);
      rows.add_velocity({{Vector3::Zero(), Vector3::Zero()}, {c.normal, c.arm.cross(c.normal)}},
                        c.normal_rate.dot(B.v + B.w.cross(c.arm)) + c.normal.dot(B.w.cross(c.arm_rate)));
    }
  }
};

/// The moment of momentum of the steady spin, h = I1 Ω a, wants the moment ω × h.
class Spin final : public Force</*markers=*/1, /*rows=*/0> {
 public:
  struct Parameters {};
  explicit Spin(Parameters) {}
  void evaluate(double, std::span<const MarkerView> markers, ForceRows& rows) const override {
    const MarkerView& B = markers[0];
    rows.add_load(B, torque(kSpinInertia * kSpin * B.x().cross(B.w)));
  }
};

/// Two springs at each end of the axle: lateral and longitudinal, the latter with the lever xl also against yaw.
class Suspension final : public Force</*markers=*/1, /*rows=*/0> {
 public:
  struct Parameters {};
  explicit Suspension(Parameters) {}
  void evaluate(double, std::span<const MarkerView> markers, ForceRows& rows) const override {
    const MarkerView& B = markers[0];
    const double yaw = std::atan2(-B.x().z(), B.x().x());
    rows.add_load(B,
                  {-2 * kSpring * Vector3(B.p.x(), 0, B.p.z()), Vector3(0, -2 * kLever * kLever * kSpring * yaw, 0)});
  }
};

/// Creep forces of both contacts in their planes, from the rails' normal forces: tension rows along the direction of
/// rolling and across it, left and right.
class Creep final : public Force</*markers=*/1, /*rows=*/4> {
 public:
  struct Parameters {
    const Constraint* rails = nullptr;
  };
  explicit Creep(Parameters parameters) : rails_(parameters.rails) {}
  const Constraint* reaction_of() const override { return rails_; }

  void evaluate(double, std::span<const MarkerView> markers, ForceRows& rows) const override {
    const MarkerView& B = markers[0];
    const Vector3 a = B.x();
    const Contact left(1, B.p, a, B.v, B.w), right(-1, B.p, a, B.v, B.w);
    // The normal forces from the lateral and vertical part of the reaction, tan δ = ± slope.
    const double cl = 1 / std::hypot(1, left.slope), sl = left.slope * cl;
    const double cr = 1 / std::hypot(1, right.slope), sr = -right.slope * cr, D = -sl * cr - sr * cl;
    add_side(left, B, sl, cl, Vector3(cr, -sr, 0) / D, rows);
    add_side(right, B, sr, cr, Vector3(-cl, -sl, 0) / D, rows);
  }

 private:
  /// Forces along and across the direction of rolling; from a normal force of no more than 1e-6 N none.
  struct Law {
    double load, along, across, spin;  // what multiplies ℓ, creepages
    std::array<double, 2> force(double N) const {
      constexpr double mu = 0.12, G = 7.92e10, C11 = 4.72772197, C22 = 4.27526987, C23 = 1.97203505;
      const double most = mu * N, ell = std::cbrt(load * std::abs(N));
      if (std::abs(N) <= 1e-6) return {0, 0};
      const double x = -most * std::tanh(G * ell * ell * C11 * along / most);
      const double y = -most * std::tanh(G * ell * ell * (C22 * across + ell * C23 * spin) / most);
      const double cut = std::min(1.0, std::abs(most) / std::hypot(x, y));
      return {cut * x, cut * y};
    }
  };

  /// N = by · reaction force; sd, cd: sine and cosine of the contact plane's angle.
  static void add_side(const Contact& c, const MarkerView& B, double sd, double cd, const Vector3& by,
                       ForceRows& rows) {
    // 1. The velocity of the wheel's material in the contact, in axes of the yaw angle of the contact plane, θ/cos δ.
    const Vector3 a = B.x();
    const double yaw = std::atan2(-a.z(), a.x()), cp = std::hypot(a.x(), a.z()), sp = a.y();
    const Vector3 e3(std::sin(yaw), 0, std::cos(yaw)), e2 = e3.cross(a);
    const double yaw_rate = B.w.dot(e2) / cp, roll_rate = B.w.dot(e3), spin = kSpin + B.w.dot(a) - yaw_rate * sp;
    const double sT = std::sin(yaw / cd), cT = std::cos(yaw / cd);
    const Vector3 t1(cT * cp, sp, -sT * cp), t3(sT, 0, cT), t2 = t3.cross(t1);
    const Vector3 arm = c.xi * t1 - c.R * (c.u.dot(e2) * t2 + c.u.dot(e3) * t3);
    const Vector3 v = B.v + Vector3(0, 0, kSpeed);
    const Vector3 slip = v + (yaw_rate * Vector3::UnitY() + roll_rate * t3 + spin * t1).cross(arm);
    const Vector3 across(cT * cd, c.side * sd, -sT * cd);

    // 2. Creepages, and the ellipse of Hertz: 1/2R of the wheel and 1/2rs of the rail.
    constexpr double poisson = 0.28, e = 1.3537956, g = 0.7115218, G = 7.92e10, pi = 3.1415926;
    const double speed = 0.5 * (slip - 2 * v).norm(), t = std::tan(kCone);
    const double A = 0.5 / (c.R * std::sqrt(1 + t * t));
    const double T = std::sqrt(kRailRadius * kRailRadius - c.w * c.w);
    const double curve = 0.5 * kRailRadius * kRailRadius / (T * T * T) / std::pow(1 + c.slope * c.slope, 1.5);
    const Law law{3 * (1 - poisson) * e / (2 * pi * (A + curve) * G * std::sqrt(g)), t3.dot(slip) / speed,
                  across.dot(slip) / speed, (-c.side * sd * spin + cd * yaw_rate) / speed};

    // 3. Rows; the tensions' derivatives by the normal force from differences, those by speed at a fixed ellipse.
    const double N = by.dot(rows.reaction().force), step = 1e-6 * (1 + std::abs(N));
    const auto force = law.force(N), more = law.force(N + step), less = law.force(N - step);
    const double ell = std::cbrt(law.load * std::abs(N)), damping = 4.5 * G * ell * ell / speed;
    for (int i = 0; i < 2; ++i) {
      const Vector3& direction = i == 0 ? t3 : across;
      rows.add({{direction, c.arm.cross(direction)}}, -force[i], 0, damping, 0);
      rows.depends_on_reaction({-(more[i] - less[i]) / (2 * step) * by, Vector3::Zero()});
    }
  }

  const Constraint* rails_;
};

}  // namespace lithe::test::wheelset
