#include "joints/bearings/journal_bearing.h"

#include <gtest/gtest.h>

#include <cmath>

#include "bodies/rigid_body.h"
#include "engine/observe/recorder.h"
#include "engine/run/simulation.h"
#include "joints/coordinate_drive.h"
#include "joints/planar_joint.h"
#include "tests/support/joint_checks.h"
#include "tests/support/linear_algebra.h"
#include "tests/support/message_of.h"
#include "tests/support/methods.h"
#include "tests/support/motion.h"
#include "tests/support/pairs.h"

/// The short journal bearing against Reynolds' equation integrated numerically, and against the published closed forms
/// of its statics and its eight coefficients (Friswell, Penny, Garvey & Lees, Dynamics of Rotating Machines, 5.5).
namespace lithe::test::journal_bearing_test {
namespace {

using Vector2 = Eigen::Vector2d;

const JournalBearing::Parameters kOil{.radius = 0.025, .length = 0.02, .clearance = 5e-5, .viscosity = 0.02};

struct Alone {
  SystemGraph graph;
  JournalBearing& bearing;
  explicit Alone(const JournalBearing::Parameters& p = kOil)
      : bearing(graph.add<JournalBearing>("bearing", {graph.ground().marker(), graph.ground().marker()}, p)) {}
};

/// F of the static film at ε and speed ω: radial (inwards) and tangential (in the sense of ω).
Vector2 static_force(double eps, double omega) {
  const double size = kOil.viscosity * omega * kOil.radius * std::pow(kOil.length, 3) / std::pow(kOil.clearance, 2);
  return {size * eps * eps / std::pow(1 - eps * eps, 2), size * M_PI * eps / (4 * std::pow(1 - eps * eps, 1.5))};
}

TEST(JournalBearing, LosesPowerAndItsTangentIsTheDerivativeOfItsForce) {
  for (const Pair& pair : pairs()) {
    SCOPED_TRACE(pair.name);
    SystemGraph graph{{.gravity = Vector3::Zero()}};
    const std::vector<Marker> markers = pair.draw(graph, {0.5, -0.4, 0.3});
    auto& bearing =
        graph.add<JournalBearing>("bearing", markers, {.radius = 31, .length = 60, .clearance = 3, .viscosity = 1e-4});
    check_force(graph, bearing, {.conservative = false, .tolerance = 1e-7});
    const System system = assemble(graph);
    RandomNumbers random(3);
    State state = system.initial_state();
    for (int k = 0; k < 20; ++k) {
      state.v = random.vector(static_cast<int>(state.v.size()), 2);
      Snapshot now{system, state};
      EXPECT_LT(power(bearing).value(now), 0);
    }
  }
}

TEST(JournalBearing, IntegratesReynoldsEquationOverTheFilmWithPressure) {
  const Alone alone;
  RandomNumbers random(5);
  for (int k = 0; k < 20; ++k) {
    const double c = kOil.clearance, omega = random.number(500);
    const Vector2 place = c * Vector2(random.number(0.65), random.number(0.65)),
                  velocity = c * Vector2(random.number(200), random.number(200));
    // p = (3μ/h³) (L²/4 - z²) (-(ω ∂h/∂β + 2 ∂h/∂t)) where it is positive; along z in closed form.
    Vector2 sum(0, 0);
    constexpr int n = 20000;
    for (int i = 0; i < n; ++i) {
      const double beta = 2 * M_PI * (i + 0.5) / n;
      const Vector2 normal(std::cos(beta), std::sin(beta)), along(-normal[1], normal[0]);
      const double h = c - place.dot(normal), slope = -place.dot(along), rate = -velocity.dot(normal);
      const double p = -std::pow(kOil.length, 3) * kOil.viscosity / (2 * h * h * h) * (omega * slope + 2 * rate);
      if (p > 0) sum -= p * kOil.radius * 2 * M_PI / n * normal;
    }
    EXPECT_LT((alone.bearing.film_force(place, velocity, omega) - sum).norm(), 1e-6 * sum.norm());
  }
}

TEST(JournalBearing, AttitudeAndLoadFollowOcvirk) {
  const Alone alone;
  for (double eps : {0.05, 0.3, 0.6, 0.9, 0.99}) {
    const Vector2 F = alone.bearing.film_force(Vector2(eps * kOil.clearance, 0), Vector2::Zero(), 300);
    const Vector2 expected = static_force(eps, 300);
    EXPECT_NEAR(F[0] / -expected[0], 1, 1e-10);
    EXPECT_NEAR(F[1] / expected[1], 1, 1e-10);
    EXPECT_NEAR(std::atan2(F[1], -F[0]), std::atan(M_PI * std::sqrt(1 - eps * eps) / (4 * eps)), 1e-10);
  }
}

/// a and b of K = (W/c) a, C = (W/(c ω)) b by (u, v), the load along -v.
struct Coefficients {
  Eigen::Matrix2d a, b;
  explicit Coefficients(double e) {
    const double e2 = e * e, p2 = M_PI * M_PI, r = std::sqrt(1 - e2);
    const double h = 1 / std::pow(p2 * (1 - e2) + 16 * e2, 1.5);
    a << 4 * (p2 * (2 - e2) + 16 * e2), M_PI * (p2 * std::pow(1 - e2, 2) - 16 * e2 * e2) / (e * r),
        -M_PI * (p2 * (1 - e2) * (1 + 2 * e2) + 32 * e2 * (1 + e2)) / (e * r),
        4 * (p2 * (1 + 2 * e2) + 32 * e2 * (1 + e2) / (1 - e2));
    const double cross = -8 * (p2 * (1 + 2 * e2) - 16 * e2);
    b << 2 * M_PI * r * (p2 * (1 + 2 * e2) - 16 * e2) / e, cross, cross,
        2 * M_PI * (p2 * std::pow(1 - e2, 2) + 48 * e2) / (e * r);
    a *= h, b *= h;
  }
};

/// Place of the journal under a load W along -y.
Vector2 resting_place(double eps) {
  const double attitude = std::atan(M_PI * std::sqrt(1 - eps * eps) / (4 * eps));
  return eps * kOil.clearance * Vector2(std::sin(attitude), -std::cos(attitude));
}

TEST(JournalBearing, HasThePublishedStiffnessAndDamping) {
  const Alone alone;
  const double omega = 400, c = kOil.clearance;
  for (double eps : {0.1, 0.4, 0.8}) {
    const double W = static_force(eps, omega).norm();
    const Vector2 place = resting_place(eps);
    EXPECT_LT((alone.bearing.film_force(place, Vector2::Zero(), omega) - Vector2(0, W)).norm(), 1e-9 * W);
    Eigen::Matrix2d K, C;
    for (int j = 0; j < 2; ++j) {
      const Vector2 unit = Vector2::Unit(j);
      K.col(j) = -derivative(
          [&](double h) -> Vector2 { return alone.bearing.film_force(place + h * unit, Vector2::Zero(), omega); },
          1e-4 * c);
      // The boundary of the film moves with the velocity: second differences of the force have a jump there.
      C.col(j) = -derivative([&](double h) -> Vector2 { return alone.bearing.film_force(place, h * unit, omega); },
                             1e-5 * c * omega);
    }
    const Coefficients published(eps);
    EXPECT_LT((K - W / c * published.a).norm(), 1e-6 * K.norm()) << eps;
    EXPECT_LT((C - W / (c * omega) * published.b).norm(), 1e-4 * C.norm()) << eps;
  }
}

// ---- whirl ----

constexpr double kMass = 50, kWeight = 490;  // of the rotor

double resting_eccentricity(double omega) {
  double low = 1e-6, high = 0.999;
  for (int i = 0; i < 100; ++i) {
    const double middle = 0.5 * (low + high);
    (static_force(middle, omega).norm() < kWeight ? low : high) = middle;
  }
  return low;
}

/// Eigenvalue of largest real part of the rotor on the published coefficients.
std::complex<double> least_stable(double omega) {
  const Coefficients of(resting_eccentricity(omega));
  MatrixX A = MatrixX::Zero(4, 4);
  A.topRightCorner<2, 2>().setIdentity();
  A.bottomLeftCorner<2, 2>() = -kWeight / (kOil.clearance * kMass) * of.a;
  A.bottomRightCorner<2, 2>() = -kWeight / (kOil.clearance * omega * kMass) * of.b;
  std::complex<double> worst(-1e9, 0);
  for (const auto& s : eigenvalues(A))
    if (s.real() > worst.real()) worst = {s.real(), std::abs(s.imag())};
  return worst;
}

struct Whirl {
  double growth, frequency;  // 1/s, rad/s
};

/// Free motion of a rotor that is driven at ω, a hundred-thousandth of the clearance off its rest.
Whirl whirl(double omega) {
  SystemGraph graph{{.gravity = {0, -kWeight / kMass, 0}}};
  const double eps = resting_eccentricity(omega), kick = 1e-5 * kOil.clearance;
  const Vector2 rest = resting_place(eps);
  auto& rotor = graph.add<RigidBody>(
      "rotor", {.mass = kMass, .position = {rest[0] + kick, rest[1], 0}, .angular_velocity = {0, 0, omega}});
  graph.add<JournalBearing>("bearing", {rotor.marker(), graph.ground().marker()}, kOil);
  auto& plane = graph.add<PlanarJoint>("plane", {graph.ground().marker(), rotor.marker()});
  graph.add<CoordinateDrive>("drive", {plane.angle()}, {.motion = ramp(0, omega)});
  const System system = assemble(graph);
  State state = system.initial_state();
  Recorder recorder{{position(rotor.marker(), "p")}};
  const Method method = radau(1e-9);
  Simulation simulation{system, *method};
  const double period = 4 * M_PI / omega;
  simulation.observe(recorder, every(period / 100));
  simulation.run(state, 40 * period);
  const auto t = recorder.table().column("t"), x = recorder.table().column("p_x");
  // Its maxima after the other modes have died, by parabolas through three samples.
  std::vector<double> times, sizes;
  for (std::size_t i = 1; i + 1 < t.size(); ++i) {
    const double a = x[i - 1] - rest[0], b = x[i] - rest[0], d = x[i + 1] - rest[0], bend = a - 2 * b + d;
    if (t[i] < 15 * period || b <= a || b < d || b < 0) continue;
    const double shift = 0.5 * (a - d) / bend;
    times.push_back(t[i] + shift * (t[i + 1] - t[i])), sizes.push_back(b - 0.25 * (a - d) * shift);
  }
  const double span = times.back() - times.front();
  return {std::log(sizes.back() / sizes.front()) / span, 2 * M_PI * static_cast<double>(times.size() - 1) / span};
}

TEST(JournalBearing, WhirlsAtHalfSpeedBeyondTheThresholdOfItsCoefficients) {
  double low = 100, high = 5000;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (least_stable(middle).real() < 0 ? low : high) = middle;
  }
  for (double share : {0.9, 0.97, 1.03, 1.06}) {
    const double omega = share * low;
    const std::complex<double> expected = least_stable(omega);
    const Whirl found = whirl(omega);
    EXPECT_NEAR(found.growth, expected.real(), 0.02 * std::abs(expected.real()) + 0.05);
    EXPECT_NEAR(found.frequency, expected.imag(), 2e-3 * expected.imag());
    EXPECT_NEAR(found.frequency / omega, 0.5, 0.05);
    EXPECT_EQ(found.growth > 0, share > 1);
  }
}

// ---- the closing film ----

TEST(JournalBearing, HoldsAStandingLoadByItsSqueezedFilmAndStaysFinite) {
  const Alone alone;
  for (double eps : {0.9999, 1.0, 1.2, 1.5})
    for (double speed : {0.0, 300.0}) {
      const Vector2 F = alone.bearing.film_force(Vector2(0, eps * kOil.clearance), Vector2(1e-3, 1e-3), speed);
      EXPECT_TRUE(F.allFinite());
      EXPECT_LT(F[1], 0);
    }
  // Squeezed without turning it closes ever more slowly.
  // → 1.
  SystemGraph graph{{.gravity = {0, -kWeight / kMass, 0}}};
  auto& rotor = graph.add<RigidBody>("rotor", {.mass = kMass});
  auto& bearing = graph.add<JournalBearing>("bearing", {rotor.marker(), graph.ground().marker()}, kOil);
  graph.add<PlanarJoint>("plane", {graph.ground().marker(), rotor.marker()});
  const System system = assemble(graph);
  State state = system.initial_state();
  const Method method = radau(1e-8);
  Simulation{system, *method}.run(state, 2);
  Snapshot now{system, state};
  const double eps = eccentricity(bearing).value(now);
  EXPECT_GT(eps, 0.9);
  EXPECT_LT(eps, 1);
}

TEST(JournalBearing, RefusesWhatIsNoFilm) {
  const auto refusal = [](const JournalBearing::Parameters& p) {
    return message_of<SceneError>([&] { Alone alone(p); });
  };
  JournalBearing::Parameters p = kOil;
  p.clearance = 0.01;
  expect_says(refusal(p), {"clearance 0.01", "thin film", "thousandth"});
  p = kOil, p.length = 0.2;
  expect_says(refusal(p), {"length 0.2", "0.05", "short bearing"});
  p = kOil, p.viscosity = 0;
  expect_says(refusal(p), {"viscosity"});
  p = kOil, p.radius = std::nan("");
  expect_says(refusal(p), {"radius"});
  const auto outside = [](double x, bool later) {
    SystemGraph graph;
    auto& rotor = graph.add<RigidBody>("rotor", {.position = {later ? 0 : x, 0, 0}});
    graph.add<JournalBearing>("bearing", {rotor.marker(), graph.ground().marker()}, kOil);
    const System system = assemble(graph);
    State state = system.initial_state();
    state.q[0] = x;
    Snapshot now{system, state};
  };
  expect_says(message_of<SceneError>([&] { outside(6e-5, false); }),
              {"bearing", "6e-05 m off", "within the clearance"});
  expect_says(message_of<SimulationError>([&] { outside(1e-4, true); }), {"bearing", "2 clearances", "film is gone"});
}

}  // namespace
}  // namespace lithe::test::journal_bearing_test
