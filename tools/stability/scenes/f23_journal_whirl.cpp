// F23: a rotor in a journal bearing, five per cent beyond the threshold of its whirl at half speed: a film without
// cross-coupling and methods that damp call it stable.
#include "bodies/rigid_body.h"
#include "engine/analysis/linearization.h"
#include "joints/bearings/journal_bearing.h"
#include "joints/coordinate_drive.h"
#include "joints/planar_joint.h"
#include "tools/stability/bench.h"
#include "tools/stability/methods/ordinary.h"
#include "tools/stability/scenes/candidates.h"

namespace lithe::lab {
namespace {

using Vector2 = Eigen::Vector2d;

constexpr double kMass = 50, kWeight = 490, kSpeed = 1218;  // kg, N along -y, rad/s; the threshold is 1160.6 rad/s
constexpr JournalBearing::Parameters kFilm{.radius = 0.025, .length = 0.02, .clearance = 5e-5, .viscosity = 0.02};
constexpr double kTurn = 4 * M_PI / kSpeed;  // s, about that of the whirl

class Rotor : public Bench {
 public:
  Rotor()
      : Bench({0, -kWeight / kMass, 0}, [&](SystemGraph& graph) {
          auto& rotor = graph.add<RigidBody>("rotor", {.mass = kMass, .angular_velocity = {0, 0, kSpeed}});
          bearing = &graph.add<JournalBearing>("bearing", {rotor.marker(), graph.ground().marker()}, kFilm);
          auto& plane = graph.add<PlanarJoint>("plane", {graph.ground().marker(), rotor.marker()});
          graph.add<CoordinateDrive>("drive", {plane.angle()}, {.motion = ramp(0, kSpeed)});
        }) {
    // Where the film carries the weight: its eccentricity by bisection, then turned so that the force points up.
    double low = 0, high = 0.99;
    const auto force = [&](double eps) { return bearing->film_force({eps * kFilm.clearance, 0}, {0, 0}, kSpeed); };
    for (int i = 0; i < 100; ++i) {
      const double middle = 0.5 * (low + high);
      (force(middle).norm() < kWeight ? low : high) = middle;
    }
    const Vector2 F = force(low);
    rest = low * kFilm.clearance * Vector2(F[1], F[0]) / F.norm();
    state.q.head<2>() = rest;
  }

  const JournalBearing* bearing;
  Vector2 rest;
};

/// Of small motions, 1/s.
double expected_rate() {
  const Rotor rotor;
  return linearize(rotor.system, rotor.state, {.axes = PerturbationAxes::world, .step = 1e-8}).largest_growth();
}

Finding of_rate(double rate, std::vector<Figure> more, const std::string& why) {
  const double expected = expected_rate();
  std::vector<Figure> figures{{"rate of growth, 1/s", rate}, {"by eigenvalues", expected}};
  figures.insert(figures.end(), more.begin(), more.end());
  return {judged(rate / expected - 1, 0.03), figures, why};
}

/// m ẍ + c ẋ + k x = 0 of either direction by itself: the larger rate.
Finding without_coupling() {
  const Rotor rotor;
  double rate = -INFINITY;
  for (int i = 0; i < 2; ++i) {
    const double h = 1e-6 * kFilm.clearance;
    const Vector2 by = h * Vector2::Unit(i);
    const auto force = [&](const Vector2& place, const Vector2& velocity) {
      return rotor.bearing->film_force(rotor.rest + place, velocity, kSpeed)[i];
    };
    const Vector2 zero = Vector2::Zero();
    const double k = (force(-by, zero) - force(by, zero)) / (2 * h);
    const double c = (force(zero, -kSpeed * by) - force(zero, kSpeed * by)) / (2 * h * kSpeed);
    const double half = c / (2 * kMass), inside = half * half - k / kMass;
    rate = std::max(rate, -half + std::sqrt(std::max(0.0, inside)));
  }
  return of_rate(rate, {}, "the film's cross-coupling feeds the whirl");
}

/// The widest of the orbit in a turn, some turns after the start and twenty later.
Finding judge(Integrator& method) {
  Rotor rotor;
  rotor.state.q[0] += 1e-4 * kFilm.clearance;
  double early = 0, late = 0;
  const auto course = rotor.run(method, 31 * kTurn, [&] {
    const double t = rotor.state.time / kTurn, off = (rotor.state.q.head<2>() - rotor.rest).norm();
    if (t > 10 && t <= 11) early = std::max(early, off);
    if (t > 30) late = std::max(late, off);
  });
  if (!course.reached) return {Outcome::unstable, {{"stopped at, s", course.end}}, course.why};
  return of_rate(std::log(late / early) / (20 * kTurn), {{"steps", static_cast<double>(course.steps)}}, "");
}

const Registered scene{with_candidates({"F23",
                                        "a journal beyond its threshold",
                                        {{"film without cross-coupling", without_coupling, Role::also},
                                         {"linearly implicit Euler, 40 steps a turn of the whirl",
                                          [] {
                                            LinearlyImplicit method({.step = kTurn / 40});
                                            return judge(method);
                                          },
                                          Role::also}}},
                                       {automatic(1e-9), radau(1e-9), alpha(kTurn / 400, 0.95)}, {1e-9, kTurn / 400},
                                       judge)};

}  // namespace
}  // namespace lithe::lab
