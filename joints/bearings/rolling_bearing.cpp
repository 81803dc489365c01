#include "joints/bearings/rolling_bearing.h"

#include <cmath>
#include <numbers>

#include "engine/assembly/batch_of.h"
#include "engine/base/checks.h"
#include "engine/base/dense.h"
#include "engine/base/number_text.h"
#include "engine/model/initial_pose.h"
#include "engine/model/joint_coordinate.h"
#include "engine/observe/snapshot.h"
#include "joints/bearings/drawn_ring_internal.h"

namespace lithe {

namespace {

/// Rows of the motion (w, p, q) in the plane of an element, by u and θ, and their derivative by its azimuth.
struct ElementPlane {
  Eigen::Matrix<double, 3, 5> motion, turned;
  explicit ElementPlane(double azimuth) {
    const double c = std::cos(azimuth), s = std::sin(azimuth);
    motion << 0, 0, 1, 0, 0, c, s, 0, 0, 0, 0, 0, 0, -s, c;
    turned << 0, 0, 0, 0, 0, -s, c, 0, 0, 0, 0, 0, 0, -c, -s;
  }
};

/// K = L D Lᵀ of a semidefinite matrix, D below its columns' ends; directions without stiffness are left out.
struct SemidefiniteFactor {
  Matrix5 L = Matrix5::Identity();
  Vector5 D = Vector5::Zero();
  explicit SemidefiniteFactor(Matrix5 K) {
    const Vector5 least = 1e-12 * K.diagonal();
    for (int j = 0; j < 5; ++j) {
      if (K(j, j) <= least[j]) continue;
      D[j] = K(j, j);
      L.col(j) = K.col(j) / D[j];
      K -= D[j] * L.col(j) * L.col(j).transpose();
      L.col(j).head(j).setZero();
    }
  }
};

/// "_1" to "_count".
std::vector<std::string> numbered(int count) {
  std::vector<std::string> endings;
  for (int j = 1; j <= count; ++j) endings.push_back("_" + std::to_string(j));
  return endings;
}

}  // namespace

/// The motion of the rings, and the wrenches of unit loads along u, θ and ψ.
struct RollingBearing::Rings {
  Vector6 at, rate;
  Wrench on_inner[6], on_outer[6];
  double speed;  // φ̇
};

RollingBearing::RollingBearing(const Arrangement& arrangement, const char* elements) : layout_(arrangement) {
  const auto& [Z, D, pitch, angle, width, losses] = layout_;
  require::positive(D, "diameter of the " + std::string(elements));
  require::positive(pitch, "pitch_diameter");
  require::finite(angle, "contact_angle");
  if (Z < 3)
    throw SceneError("has " + std::to_string(Z) + " " + elements, "", "give three or more: two do not centre a ring");
  const double room = pitch * std::sin(std::numbers::pi / Z);
  if (D > room)
    throw SceneError(std::to_string(Z) + " " + elements + " of " + number_text(D) + " m do not fit on a circle of " +
                         number_text(pitch) + " m: the largest have " + number_text(room) + " m",
                     "", "give fewer or smaller ones, or a larger pitch_diameter");
  if (std::abs(angle) >= std::numbers::pi / 2)
    throw SceneError("contact_angle " + number_text(angle) + " rad is a quarter turn or more", "",
                     "give it in radians against the radial plane: 0.2618 for 15 degrees");
  for (const auto& [value, name] :
       {std::pair(losses.damping_time, "damping_time"), std::pair(losses.load_factor, "load_factor"),
        std::pair(losses.speed_factor, "speed_factor"), std::pair(losses.viscosity, "viscosity")})
    require::not_negative(value, name);
  require::positive(losses.creep_speed, "creep_speed");
  cage_ratio_ = 0.5 * (1 - D * std::cos(angle) / pitch);
}

void RollingBearing::initialize(std::span<const MarkerView> m) {
  initial::same_direction(m[0].z(), m[1].z(), "z");
  const double apart = (m[0].p - m[1].p).norm();
  if (apart > 0.5 * layout_.diameter)
    throw SceneError("the rings are drawn " + number_text(apart) + " m apart, more than half an element's diameter", "",
                     "put both markers in the bearing's centre");
  drawn_angle_ = initial::angle(measure(JointCoordinate::Kind::angle, 2, m[1], m[0]).value);
}

RollingBearing::Rings RollingBearing::rings(const MarkerView& inner, const MarkerView& outer,
                                            const AngleMemory& memory) const {
  Rings r;
  const Vector3 d = inner.p - outer.p, axis = inner.z();
  const auto turn = [&](int i, const Vector3& t) { r.on_inner[i] = torque(t), r.on_outer[i] = torque(-t); };
  for (int i = 0; i < 3; ++i) {
    const Vector3 a = outer.R.col(i);
    r.at[i] = a.dot(d);
    r.on_inner[i] = force(a), r.on_outer[i] = {-a, -d.cross(a)};
  }
  r.at[3] = -outer.y().dot(axis), turn(3, Vector3(outer.y()).cross(axis));
  r.at[4] = outer.x().dot(axis), turn(4, axis.cross(Vector3(outer.x())));
  const MeasuredCoordinate phi = measure(JointCoordinate::Kind::angle, 2, outer, inner);
  r.at[5] = cage_ratio_ * (memory.wound(0, phi.value) - drawn_angle_);
  r.on_inner[5] = cage_ratio_ * phi.on_B, r.on_outer[5] = cage_ratio_ * phi.on_A;
  r.speed = phi.rate;
  for (int i = 0; i < 6; ++i)
    r.rate[i] = r.on_inner[i].force.dot(inner.v) + r.on_inner[i].torque.dot(inner.w) +
                r.on_outer[i].force.dot(outer.v) + r.on_outer[i].torque.dot(outer.w);
  return r;
}

RollingBearing::Loads RollingBearing::loads(const Vector6& at, std::vector<RollingElementLoad>* each) const {
  Loads sum;
  const Vector5 e = at.head<5>();
  for (int j = 0; j < layout_.count; ++j) {
    const ElementPlane plane(at[5] + 2 * std::numbers::pi * j / layout_.count);
    const Vector3 motion = plane.motion * e;
    const PlaneLoad one = in_plane(motion);
    if (each) each->push_back(one.element);
    if (one.element.force == 0) continue;
    sum.energy += one.energy;
    sum.force.head<5>() += plane.motion.transpose() * one.force;
    const Vector3 turning = plane.turned * e;
    sum.force[5] += one.force.dot(turning);
    sum.stiffness.topLeftCorner<5, 5>() += plane.motion.transpose() * one.stiffness * plane.motion;
    sum.stiffness.topRightCorner<5, 1>() +=
        plane.motion.transpose() * (one.stiffness * turning) + plane.turned.transpose() * one.force;
    sum.stiffness(5, 5) += turning.dot(one.stiffness * turning) - one.force.tail<2>().dot(motion.tail<2>());
  }
  sum.stiffness.bottomLeftCorner<1, 5>() = sum.stiffness.topRightCorner<5, 1>().transpose();
  return sum;
}

double RollingBearing::friction(double speed, double load, double& slope) const {
  const auto& l = layout_.losses;
  const double nu_n = 1e6 * l.viscosity * std::abs(speed) * 30 / std::numbers::pi;
  const double viscous = 0.1 * l.speed_factor * std::pow(layout_.pitch_diameter, 3);
  const double power = std::cbrt(nu_n * nu_n),
               moment = viscous * std::max(160.0, power) + l.load_factor * load * layout_.pitch_diameter;
  const double part = std::tanh(speed / l.creep_speed);
  slope = moment * (1 - part * part) / l.creep_speed;
  if (power > 160) slope += part * viscous * 2 / 3 * power / speed;
  return moment * part;
}

void RollingBearing::evaluate(double, std::span<const MarkerView> markers, ForceRows& rows) const {
  const Rings r = rings(markers[0], markers[1], rows);
  const Loads now = loads(r.at);
  // ∂²V by u, θ (K), by both and ψ (a), and by ψ (κ), in rows of diagonal stiffness:
  //   [K a; aᵀ κ] = [K + s² a aᵀ, 0; 0, κ + 1/s²] - (s a, -1/s) (s a, -1/s)ᵀ,  s² a aᵀ a millionth of the largest K
  Matrix5 K = now.stiffness.topLeftCorner<5, 5>();
  const Vector5 a = now.stiffness.topRightCorner<5, 1>();
  const auto share = [&](int first, int count) {  // a aᵀ over the stiffest direction
    const double stiffest = K.diagonal().segment(first, count).maxCoeff();
    return stiffest > 0 ? a.segment(first, count).squaredNorm() / stiffest : 0;
  };
  const double of_both = share(0, 3) + share(3, 2), s = of_both > 1e-100 ? std::sqrt(1e-6 / of_both) : 0;
  K += s * a * (s * a).transpose();

  const double tau = layout_.losses.damping_time;
  Vector6 tension = now.force;
  tension.head<5>() += tau * K * r.rate.head<5>();
  double drag_slope;
  tension[5] += friction(r.speed, now.force.head<3>().norm(), drag_slope) / cage_ratio_;
  rows.add_energy(now.energy);
  for (int i = 0; i < 5; ++i) rows.add({r.on_inner[i], r.on_outer[i]}, tension[i], 0, 0, 0);
  rows.add({r.on_inner[5], r.on_outer[5]}, tension[5], now.stiffness(5, 5) + (s > 0 ? 1 / (s * s) : 0),
           drag_slope / (cage_ratio_ * cage_ratio_), 0);
  // Rows without tension: what the loads above grow by.
  const auto add_growth = [&](const Vector6& along, double stiffness, double damping) {
    Wrench inner = torque(Vector3::Zero()), outer = inner;
    for (int i = 0; i < 6; ++i) inner = inner + along[i] * r.on_inner[i], outer = outer + along[i] * r.on_outer[i];
    rows.add({inner, outer}, 0, stiffness, damping, 0);
  };
  const SemidefiniteFactor factor(K);
  Vector6 along = Vector6::Zero();
  for (int j = 0; j < 5; ++j) {
    along.head<5>() = factor.L.col(j);
    add_growth(along, factor.D[j], tau * factor.D[j]);
  }
  along << s * a, s > 0 ? -1 / s : 0;
  add_growth(along, s > 0 ? -1 : 0, 0);
}

double RollingBearing::internal_load(std::span<const MarkerView> markers, const AngleMemory& memory) const {
  std::vector<RollingElementLoad> each;
  loads(rings(markers[0], markers[1], memory).at, &each);
  double sum = 0;
  for (const RollingElementLoad& element : each) sum += element.force;
  return sum;
}

std::vector<DrawnShape> RollingBearing::drawn_shapes(int marker) const {
  const double middle = 0.5 * layout_.pitch_diameter, D = layout_.diameter, side = marker == 0 ? -1 : 1;
  const double groove = middle + side * 0.35 * D, back = middle + side * 0.8 * D;
  return {drawn_ring(std::max(std::min(groove, back), 0.1 * D), std::max(groove, back), layout_.width)};
}

// ---- sensors ----

Sensor RollingBearing::ring_sensor(const RollingBearing& bearing, Located name, std::vector<std::string> endings,
                                   std::vector<std::string> units, Reading read) {
  for (std::string& ending : endings) ending = name.text + ending;
  return Sensor(
      std::move(name), std::move(endings),
      [&bearing, read](Snapshot& now, std::span<double> values) {
        const MarkerKinematics inner = now.marker(bearing.markers()[0]), outer = now.marker(bearing.markers()[1]);
        ForceRows memory(2);
        memory.recall(now.quarter_turns_of(bearing));
        const Vector6 at = bearing.rings({inner, 0}, {outer, 1}, memory).at;
        std::vector<RollingElementLoad> each;
        bearing.loads(at, &each);
        read(at, each, values);
      },
      std::move(units));
}

Sensor ring_deflection(const RollingBearing& bearing, Located name) {
  if (name.text.empty()) name.text = bearing.name();
  return RollingBearing::ring_sensor(
      bearing, std::move(name), {"_x", "_y", "_z", "_tilt_x", "_tilt_y"}, {"m", "m", "m", "rad", "rad"},
      [](const Vector6& at, const auto&, std::span<double> values) { std::copy_n(at.data(), 5, values.begin()); });
}

Sensor rolling_element_loads(const RollingBearing& bearing, Located name) {
  if (name.text.empty()) name.text = bearing.name() + "_load";
  return RollingBearing::ring_sensor(bearing, std::move(name), numbered(bearing.element_count()), {"N"},
                                     [](const Vector6&, const auto& each, std::span<double> values) {
                                       for (std::size_t j = 0; j < each.size(); ++j) values[j] = each[j].force;
                                     });
}

Sensor contact_angles(const RollingBearing& bearing, Located name) {
  if (name.text.empty()) name.text = bearing.name() + "_contact_angle";
  return RollingBearing::ring_sensor(bearing, std::move(name), numbered(bearing.element_count()), {"rad"},
                                     [](const Vector6&, const auto& each, std::span<double> values) {
                                       for (std::size_t j = 0; j < each.size(); ++j) values[j] = each[j].contact_angle;
                                     });
}

}  // namespace lithe
