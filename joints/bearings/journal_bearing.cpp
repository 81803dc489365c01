#include "joints/bearings/journal_bearing.h"

#include <cmath>
#include <numbers>

#include "engine/assembly/batch_of.h"
#include "engine/base/checks.h"
#include "engine/base/number_text.h"
#include "engine/model/initial_pose.h"
#include "engine/observe/snapshot.h"
#include "joints/bearings/drawn_ring_internal.h"

namespace lithe {

namespace {

using Vector2 = Eigen::Vector2d;

constexpr double kThinnest = 1e-4, kOutside = 1.5;  // film over clearance; ε

/// (x, y) of the journal in the axes of the bush, its velocity there, and the relative speed about z.
struct JournalMotion {
  Vector2 place, velocity;
  double speed;
  JournalMotion(const MarkerView& journal, const MarkerView& bush) {
    const Vector3 d = journal.p - bush.p, rate = journal.v - bush.v - bush.w.cross(d);
    place = {bush.x().dot(d), bush.y().dot(d)};
    velocity = {bush.x().dot(rate), bush.y().dot(rate)};
    speed = bush.z().dot(journal.w - bush.w);
  }
};

}  // namespace

JournalBearing::JournalBearing(Parameters parameters) : parameters_(parameters) {
  const auto& [R, L, c, viscosity] = parameters_;
  require::positive(R, "radius");
  require::positive(L, "length");
  require::positive(c, "clearance");
  require::positive(viscosity, "viscosity");
  if (c >= 0.1 * R)
    throw SceneError("clearance " + number_text(c) + " m is no thin film about a radius of " + number_text(R) + " m",
                     "", "give the radial clearance in metres, some thousandth of the radius");
  if (L > 2 * R)
    throw SceneError("length " + number_text(L) + " m exceeds the diameter " + number_text(2 * R) +
                         " m: the theory of the short bearing overrates it",
                     "", "give a length of up to the diameter, or divide the bearing");
}

void JournalBearing::initialize(std::span<const MarkerView> m) {
  initial::same_direction(m[0].z(), m[1].z(), "z");
  const double e = JournalMotion(m[0], m[1]).place.norm();
  if (e >= parameters_.clearance)
    throw SceneError("the journal is drawn " + number_text(e) + " m off the centre, with a clearance of " +
                         number_text(parameters_.clearance) + " m",
                     "", "draw it within the clearance");
}

Vector2 JournalBearing::film_force(const Vector2& place, const Vector2& velocity, double speed) const {
  const auto& [R, L, c, viscosity] = parameters_;
  const Vector2 w(2 * velocity[0] + speed * place[1], 2 * velocity[1] - speed * place[0]);
  const double size = w.norm();
  if (size == 0) return Vector2::Zero();
  const Vector2 along = w / size, across(-along[1], along[0]);
  Vector2 epsilon = place / c;
  if (const double e = epsilon.norm(); e > 1 - kThinnest) epsilon *= (1 - kThinnest) / e;

  // J(a, b) = ∫ ds / (1 - a cos s - b sin s) over a half turn is 2 T / S; ½ J_aa and ½ J_ab are the integrals wanted.
  const double a = epsilon.dot(along), b = epsilon.dot(across), S2 = 1 - a * a - b * b, S = std::sqrt(S2);
  const double T = std::numbers::pi / 2 + std::atan(a / S);
  const double J_aa = (6 * a + (2 * S + 6 * a * a / S) * T) / (S2 * S2);
  const double J_ab = (4 * b + 2 * a * a * b / (1 - b * b) + 6 * a * b / S * T) / (S2 * S2);
  const double scale = viscosity * R * L * L * L / (4 * c * c * c);
  return -scale * size * (J_aa * along + J_ab * across);
}

void JournalBearing::evaluate(double time, std::span<const MarkerView> markers, ForceRows& rows) const {
  const auto& [R, L, c, viscosity] = parameters_;
  const MarkerView &journal = markers[0], &bush = markers[1];
  const JournalMotion now(journal, bush);
  const double e = now.place.norm() / c;
  if (e > kOutside)
    throw SimulationError(
        "the journal is " + number_text(e) + " clearances off the centre of its bush: the film is gone",
        time_text(time),
        "take smaller steps; where the load is too high raise viscosity, length or speed, or add a Contact");
  const Vector2 film = film_force(now.place, now.velocity, now.speed);
  const double thin = std::min(e, 1 - kThinnest);
  const double shear = 2 * std::numbers::pi * viscosity * R * R * R * L * now.speed / (c * std::sqrt(1 - thin * thin));
  const double pressure = 0.5 * (now.place[0] * film[1] - now.place[1] * film[0]);
  const Vector3 F = bush.R.leftCols<2>() * film, T = -(shear + pressure) * bush.z();
  rows.add_load(journal, {F, T});
  rows.add_load(bush, {-F, -T - (journal.p - bush.p).cross(F)});
}

std::vector<DrawnShape> JournalBearing::drawn_shapes(int marker) const {
  const auto& p = parameters_;
  if (marker == 0) return {visual::cylinder(p.radius - p.clearance, 1.2 * p.length)};
  return {drawn_ring(p.radius, 1.3 * p.radius, p.length)};
}

Sensor eccentricity(const JournalBearing& bearing, Located name) {
  if (name.text.empty()) name.text = bearing.name();
  std::vector<std::string> columns{name.text + "_eccentricity", name.text + "_angle"};
  return Sensor(std::move(name), std::move(columns),
                [&bearing](Snapshot& now, std::span<double> values) {
                  const MarkerKinematics journal = now.marker(bearing.markers()[0]),
                                         bush = now.marker(bearing.markers()[1]);
                  const Vector2 place = JournalMotion({journal, 0}, {bush, 1}).place;
                  values[0] = place.norm() / bearing.clearance();
                  values[1] = std::atan2(place[1], place[0]);
                },
                {"", "rad"});
}

template std::unique_ptr<ForceBatch> make_force_batch<JournalBearing>();

}  // namespace lithe
