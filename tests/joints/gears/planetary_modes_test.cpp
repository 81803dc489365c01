#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>

#include "joints/forces/bushing.h"
#include "joints/gears/toothed_gear_pair.h"
#include "tests/joints/mechanisms.h"
#include "tests/support/dense.h"

/// Natural frequencies of gear trains against eigenvalue problems written here.
namespace lithe::test::planetary_modes_test {
namespace {

/// Hz, ascending.
std::vector<double> frequencies(const MatrixX& K, const MatrixX& M) {
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixX> solver(0.5 * (K + K.transpose()), 0.5 * (M + M.transpose()));
  std::vector<double> f;
  for (double square : solver.eigenvalues()) f.push_back(std::sqrt(std::max(0.0, square)) / (2 * kPi));
  return f;
}

/// K and M of the engine's own Newton matrix at a state, planar motions alone: x, y and the turn about z of each body.
std::vector<double> planar_frequencies(const System& system, const VectorX& q) {
  Evaluator evaluator(system);
  const VectorX still = VectorX::Zero(system.layout().v_count()), none = VectorX::Zero(system.layout().row_count());
  const auto matrix = [&](const TangentWeights& weights) {
    evaluator.evaluate(0, q, still, Level::acceleration);
    evaluator.factorize(weights, still, none, nullptr);
    return MatrixX(dense(evaluator).condensed_S());
  };
  const MatrixX M = matrix({0, 0, 1}), K = matrix({1, 0, 1}) - M;
  std::vector<int> planar;
  for (int i = 0; i < still.size(); i += 6)
    for (int axis : {0, 1, 5}) planar.push_back(i + axis);
  return frequencies(K(planar, planar), M(planar, planar));
}

struct Member {
  double mass, inertia, radius;  // kg; I/r², kg; of its base circle or, of the carrier, of the pins, m
  double bearing, torsion;       // N/m; of the bearing about z times r², N/m
};

/// Three planets between sun, ring and carrier, all on elastic bearings (Lin & Parker, J. Vib. Acoust. 121, 1999, table
/// 1, ring as there held by 1e9 N/m): pressure angle 24.6°, teeth 5e8 N/m, bearings 1e8 N/m.
constexpr double kMesh = 5e8, kBearing = 1e8, kAngle = 24.6 * kPi / 180;
constexpr int kPlanets = 3;
constexpr double kModule = 2.9e-3, kSunTeeth = 29, kPlanetTeeth = 38, kRingTeeth = kSunTeeth + 2 * kPlanetTeeth;

struct Train {
  double half = 0.5 * kModule, cosine = std::cos(kAngle);
  Member carrier{5.43, 6.29, half*(kSunTeeth + kPlanetTeeth), kBearing, 0},
      ring{2.35, 3.00, half*kRingTeeth*cosine, kBearing, 1e9}, sun{0.4, 0.39, half*kSunTeeth*cosine, kBearing, 0},
      planet{0.66, 0.61, half*kPlanetTeeth*cosine, kBearing, 0};
};

/// Coordinates x, y, u = r θ of carrier, ring, sun, and radial, tangential, u of each planet, in the carrier's axes;
/// each spring adds k a aᵀ with its stretch a·x.
std::vector<double> lumped_frequencies(const Train& t) {
  constexpr int n = 9 + 3 * kPlanets;
  MatrixX K = MatrixX::Zero(n, n), M = MatrixX::Zero(n, n);
  const auto spring = [&](double k, const std::vector<std::pair<int, double>>& stretch) {
    VectorX a = VectorX::Zero(n);
    for (const auto& [i, factor] : stretch) a[i] += factor;
    K += k * a * a.transpose();
  };
  const Member* members[] = {&t.carrier, &t.ring, &t.sun};
  for (int i = 0; i < 3; ++i) {
    const Member& m = *members[i];
    M(3 * i, 3 * i) = M(3 * i + 1, 3 * i + 1) = m.mass, M(3 * i + 2, 3 * i + 2) = m.inertia;
    spring(m.bearing, {{3 * i, 1}}), spring(m.bearing, {{3 * i + 1, 1}}), spring(m.torsion, {{3 * i + 2, 1}});
  }
  for (int k = 0; k < kPlanets; ++k) {
    const int p = 9 + 3 * k;
    const double psi = 2 * kPi * k / kPlanets, at_sun = psi - kAngle, at_ring = psi + kAngle;
    M(p, p) = M(p + 1, p + 1) = t.planet.mass, M(p + 2, p + 2) = t.planet.inertia;
    spring(t.planet.bearing, {{0, std::cos(psi)}, {1, std::sin(psi)}, {p, -1}});
    spring(t.planet.bearing, {{0, -std::sin(psi)}, {1, std::cos(psi)}, {2, 1}, {p + 1, -1}});
    spring(kMesh, {{6, -std::sin(at_sun)},
                   {7, std::cos(at_sun)},
                   {8, 1},
                   {p, -std::sin(kAngle)},
                   {p + 1, -std::cos(kAngle)},
                   {p + 2, 1}});
    spring(kMesh, {{3, -std::sin(at_ring)},
                   {4, std::cos(at_ring)},
                   {5, 1},
                   {p, std::sin(kAngle)},
                   {p + 1, -std::cos(kAngle)},
                   {p + 2, -1}});
  }
  return frequencies(K, M);
}

TEST(ToothedGearPair, GivesAPlanetaryTrainItsNaturalFrequencies) {
  const Train t;
  SystemGraph graph{{.gravity = {0, 0, 0}}};
  std::vector<RigidBody*> bodies;
  const auto draw = [&](const std::string& name, const Member& m, const Vector3& at) -> RigidBody& {
    const double J = m.inertia * m.radius * m.radius;
    bodies.push_back(&graph.add<RigidBody>(name, {.mass = m.mass, .inertia = {J, J, J}, .position = at}));
    return *bodies.back();
  };
  const auto hold = [&](const std::string& name, const Marker& on, const Marker& body, const Member& m) {
    graph.add<Bushing>(
        name, {on, body},
        {.stiffness = Bushing::diagonal({m.bearing, m.bearing, 1e8}, {1e6, 1e6, m.torsion * m.radius * m.radius})});
  };
  RigidBody &carrier = draw("carrier", t.carrier, {0, 0, 0}), &ring = draw("ring", t.ring, {0, 0, 0}),
            &sun = draw("sun", t.sun, {0, 0, 0});
  hold("carrier bearing", graph.ground().marker(), carrier.marker(), t.carrier);
  hold("ring bearing", graph.ground().marker(), ring.marker(), t.ring);
  hold("sun bearing", graph.ground().marker(), sun.marker(), t.sun);
  const ToothContact teeth{.model = ToothStiffness::table, .stiffness = {kMesh}};
  const GearDesign gears{.module = kModule, .pressure_angle = kAngle, .face_width = 25e-3};
  for (int k = 0; k < kPlanets; ++k) {
    const std::string number = std::to_string(k + 1);
    const Vector3 at = rotation_about({0, 0, 1}, 2 * kPi * k / kPlanets) * Vector3(t.carrier.radius, 0, 0);
    RigidBody& planet = draw("planet " + number, t.planet, at);
    hold("pin " + number, carrier.marker(at), planet.marker(), t.planet);
    GearDesign to_sun = gears, to_ring = gears;
    to_sun.teeth_A = kSunTeeth, to_sun.teeth_B = kPlanetTeeth;
    to_ring.teeth_A = kPlanetTeeth, to_ring.teeth_B = -kRingTeeth, to_ring.shortening_B = 0.2;
    graph.add<ToothedGearPair>("sun mesh " + number, {sun.marker(), planet.marker()}, {to_sun, teeth});
    graph.add<ToothedGearPair>("ring mesh " + number, {planet.marker(), ring.marker()}, {to_ring, teeth});
  }
  const System system = assemble(graph);
  // On the flanks that carry a torque from the sun to the carrier: sun and ring a hair ahead of the planets.
  VectorX ahead = VectorX::Zero(system.layout().v_count()), q = system.initial_state().q;
  ahead[6 + 5] = 1e-8 / t.ring.radius, ahead[12 + 5] = 1e-8 / t.sun.radius;
  system.layout().retract(system.initial_state().q, ahead, q);

  const std::vector<double> found = planar_frequencies(system, q), expected = lumped_frequencies(t);
  // As published: one of each rotational mode, two of each translational one.
  const std::vector<double> published = {0,      743.2,  743.2,  1102.4, 1102.4, 1475.7, 1896.0, 1896.0, 1930.3,
                                         2276.4, 2276.4, 2658.3, 6986.3, 6986.3, 7462.8, 9647.9, 9647.9, 11775.3};
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_NEAR(found[i], expected[i], 2e-5 * expected[i] + 0.5) << i;
    EXPECT_NEAR(expected[i], published[i], 0.1) << i;
  }
}

/// Two stages between a heavy motor and a heavy load, the middle shaft of two gears on a torsion spring.
TEST(ToothedGearPair, GivesATwoStageTrainItsNaturalFrequencies) {
  const double J[] = {2e-3, 4e-3, 3e-3, 20e-3}, k_shaft = 4e4, k_1 = 3e8, k_2 = 5e8;
  const GearDesign first{.module = 2e-3, .teeth_A = 20, .teeth_B = 45, .face_width = 15e-3},
      second{.module = 3e-3, .teeth_A = 19, .teeth_B = 52, .face_width = 25e-3};
  const GearGeometry g_1(first), g_2(second);
  SystemGraph graph{{.gravity = {0, 0, 0}}};
  const double middle = g_1.centre_distance;
  const Vector3 centres[] = {{0, 0, 0}, {middle, 0, 0}, {middle, 0, 0.1}, {middle, g_2.centre_distance, 0.1}};
  std::vector<RigidBody*> wheels;
  for (int i = 0; i < 4; ++i) {
    const std::string name = "wheel " + std::to_string(i + 1);
    wheels.push_back(&graph.add<RigidBody>(name, {.mass = 1, .inertia = {J[i], J[i], J[i]}, .position = centres[i]}));
    graph.add<Bushing>("bearing " + name, {graph.ground().marker(centres[i]), wheels.back()->marker()},
                       {.stiffness = Bushing::diagonal({1e14, 1e14, 1e14}, {1e14, 1e14, 0})});
  }
  graph.add<Bushing>("shaft", {wheels[1]->marker(), wheels[2]->marker()},
                     {.stiffness = Bushing::diagonal({0, 0, 0}, {0, 0, k_shaft})});
  graph.add<ToothedGearPair>("first", {wheels[0]->marker(), wheels[1]->marker()},
                             {first, {.model = ToothStiffness::table, .stiffness = {k_1}}});
  graph.add<ToothedGearPair>("second", {wheels[2]->marker(), wheels[3]->marker()},
                             {second, {.model = ToothStiffness::table, .stiffness = {k_2}}});
  const System system = assemble(graph);
  VectorX ahead = VectorX::Zero(system.layout().v_count()), q = system.initial_state().q;
  ahead[5] = 1e-6, ahead[6 + 5] = 1e-8, ahead[12 + 5] = -1e-6;
  system.layout().retract(system.initial_state().q, ahead, q);
  const std::vector<double> found = planar_frequencies(system, q);

  MatrixX K = MatrixX::Zero(4, 4), M = MatrixX::Zero(4, 4);
  const auto spring = [&](double k, const Eigen::Vector4d& a) { K += k * a * a.transpose(); };
  spring(k_1, {g_1.A.base_radius, g_1.B.base_radius, 0, 0});
  spring(k_2, {0, 0, g_2.A.base_radius, g_2.B.base_radius});
  spring(k_shaft, {0, 1, -1, 0});
  for (int i = 0; i < 4; ++i) M(i, i) = J[i];
  const std::vector<double> expected = frequencies(K, M);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(found[i], expected[i], 1e-4 * expected[i] + 0.5);
}

}  // namespace
}  // namespace lithe::test::planetary_modes_test
