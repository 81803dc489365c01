#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>

#include "bodies/beam/beam.h"
#include "engine/run/simulation.h"
#include "joints/coordinate_drive.h"
#include "joints/fixed_joint.h"
#include "joints/forces/user_force.h"
#include "joints/revolute_joint.h"
#include "joints/spherical_joint.h"
#include "tests/support/methods.h"

/// Motions of very flexible beams against tests/data/beams, which README.md there explains.
namespace lithe::test::beam_flights_test {
namespace {

/// The first columns of a table of tests/data/beams up to a time: times, and below each the places of markers, m.
MatrixX read(const std::string& table, int markers, double until) {
  std::ifstream file(LITHE_TEST_DATA "/beams/" + table);
  std::string line;
  std::getline(file, line);
  std::vector<VectorX> rows;
  while (std::getline(file, line)) {
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream numbers(line);
    VectorX row(1 + 3 * markers);
    for (double& x : row) numbers >> x;
    if (row[0] > until + 1e-9) break;
    rows.push_back(row);
  }
  MatrixX all(1 + 3 * markers, static_cast<int>(rows.size()));
  for (int i = 0; i < all.cols(); ++i) all.col(i) = rows[static_cast<std::size_t>(i)];
  return all;
}

/// The same of a scene at those times; and that it keeps its energy, relative to the largest, after `free` (s).
MatrixX fly(SystemGraph& graph, const std::vector<Marker>& markers, Integrator& method, const MatrixX& like,
            double free, double drift) {
  const System system = assemble(graph);
  State state = system.initial_state();
  Simulation simulation(system, method);
  MatrixX all = like;
  double least = 1e300, most = 0;
  for (int i = 0; i < all.cols(); ++i) {
    simulation.run(state, all(0, i));
    Snapshot now(system, state);
    for (int m = 0; m < static_cast<int>(markers.size()); ++m)
      all.block<3, 1>(1 + 3 * m, i) = now.marker(markers[static_cast<std::size_t>(m)]).p;
    if (all(0, i) < free) continue;
    const double energy = total_energy().value(now);
    least = std::min(least, energy), most = std::max(most, energy);
  }
  expect_below("energy", most - least, drift);
  return all;
}

/// Of the finer of two meshes, and of both without the error of second order, m.
void expect_flight(const std::string& what, const MatrixX (&meshes)[2], const MatrixX& exact, double fine,
                   double extrapolated) {
  expect_below(what + ", finer mesh", (meshes[1] - exact).cwiseAbs().maxCoeff(), fine);
  expect_below(what + ", extrapolated", ((4 * meshes[1] - meshes[0]) / 3 - exact).cwiseAbs().maxCoeff(), extrapolated);
}

/// A free rod under a sudden force and moment in its plane: they send waves that no mesh resolves soon.
TEST(BeamFlights, FreeRodUnderASuddenLoad) {
  const MatrixX exact = read("D03_flying_rod_2d.csv", 3, 7.5);
  MatrixX meshes[2];
  for (int k = 0; k < 2; ++k) {
    SystemGraph graph{{.gravity = Vector3::Zero()}};
    auto& rod = graph.add<Beam>(
        "rod", {.axis = BeamAxis::straight({0, 0, 8}, {6, 0, 0}, {0, 1, 0}),
                .sections = {{0, BeamSection::diagonal({1e4, 1e4, 1e4, 500, 100, 100}, 1, {20, 10, 10})}},
                .elements = 12 << k});
    graph.add<UserForce>("throw", {rod.marker(10)}, {[](double t, const MarkerView&) {
                           return t < 2.5 ? Wrench{{8, 0, 0}, {0, 80, 0}} : Wrench{{0, 0, 0}, {0, 0, 0}};
                         }});
    const Method method = runge_kutta8(1e-8);
    meshes[k] = fly(graph, {rod.marker(0), rod.marker(5), rod.marker(10)}, *method, exact, 2.5, 2e-6);
  }
  expect_below("rod in a plane, 24 elements", (meshes[1] - exact).cwiseAbs().maxCoeff(), 0.2);
  EXPECT_GT((meshes[0] - exact).cwiseAbs().maxCoeff(), 2.5 * (meshes[1] - exact).cwiseAbs().maxCoeff());
}

TEST(BeamFlights, RubberRodFallsFromItsPin) {
  const MatrixX exact = read("D05_falling_rod.csv", 3, 1.8);
  MatrixX meshes[2];
  for (int k = 0; k < 2; ++k) {
    SystemGraph graph;
    const double EI = 0.039269908169872414, J = 8.63937979737193e-6;
    auto& rod =
        graph.add<Beam>("rod", {.axis = BeamAxis::straight({0, 0, 0}, {1, 0, 0}, {0, 1, 0}),
                                .sections = {{0, BeamSection::diagonal({1570.796326794897, 471.238898038469,
                                                                        471.238898038469, 0.026179938779914945, EI, EI},
                                                                       0.3455751918948773, {2 * J, J, J})}},
                                .elements = 16 << k});
    graph.add<SphericalJoint>("pin", {graph.ground().marker(), rod.marker(0)});
    const Method method = runge_kutta8(1e-7);
    meshes[k] = fly(graph, {rod.marker(0), rod.marker(0.5), rod.marker(1)}, *method, exact, 0, 1e-9);
  }
  expect_flight("falling rod", meshes, exact, 3e-3, 5e-4);
}

TEST(BeamFlights, RightAngleFrameSwings) {
  const MatrixX exact = read("D06_right_angle_cantilever.csv", 2, 30);
  MatrixX meshes[2];
  const BeamSection section = BeamSection::diagonal({1e6, 1e6, 1e6, 1e3, 1e3, 1e3}, 1, {20, 10, 10});
  for (int k = 0; k < 2; ++k) {
    SystemGraph graph{{.gravity = Vector3::Zero()}};
    const int elements = 8 << k;
    auto& first = graph.add<Beam>("first", {.axis = BeamAxis::straight({0, 0, 0}, {10, 0, 0}, {0, 1, 0}),
                                            .sections = {{0, section}},
                                            .elements = elements});
    auto& second = graph.add<Beam>("second", {.axis = BeamAxis::straight({10, 0, 0}, {10, 10, 0}, {-1, 0, 0}),
                                              .sections = {{0, section}},
                                              .elements = elements});
    graph.add<FixedJoint>("clamp", {graph.ground().marker({0, 0, 0}, first.axes(0)), first.marker(0)});
    graph.add<FixedJoint>("elbow",
                          {first.marker(10), second.marker(0, {}, second.axes(0).transpose() * first.axes(0))});
    graph.add<UserForce>("push", {first.marker(10)}, {[](double t, const MarkerView&) {
                           return force({0, 0, 50 * std::max(0.0, 1 - std::abs(t - 1))});
                         }});
    const Method method = radau(1e-7);
    meshes[k] = fly(graph, {first.marker(10), second.marker(10)}, *method, exact, 2, 1e-4);
  }
  expect_flight("frame", meshes, exact, 0.15, 0.05);
}

/// A hub turns a beam up to 6 rad/s in 15 s (J. C. Simo, L. Vu-Quoc, J. Appl. Mech. 53 (1986) 849): its tip lags most
/// at 6.762 s, by 0.57383476 m (one spectral element of degree 10; Galerkin's method of degree 12).
TEST(BeamFlights, SpinUpBendsItBack) {
  const double speed = 6, T = 15, EI = 1.4e4, w = 2 * M_PI / T, exact = -0.57383476;
  double found[3];
  for (int k = 0; k < 3; ++k) {
    SystemGraph graph{{.gravity = Vector3::Zero()}};
    auto& beam = graph.add<Beam>(
        "beam", {.axis = BeamAxis::straight({0, 0, 0}, {10, 0, 0}, {0, 1, 0}),
                 .sections = {{0, BeamSection::diagonal({2.8e7, 1e7, 1e7, EI, EI, EI}, 1.2, {1.2e-3, 6e-4, 6e-4})}},
                 .elements = 5 << k});
    auto& hub = graph.add<RevoluteJoint>("hub", {graph.ground().marker(), beam.marker(0)});
    graph.add<CoordinateDrive>("drive", {hub.angle()}, {.motion = [=](double t) -> Motion {
                                 return {speed / T * (t * t / 2 + (std::cos(w * t) - 1) / (w * w)),
                                         speed / T * (t - std::sin(w * t) / w), speed / T * (1 - std::cos(w * t))};
                               }});
    const Marker tip = beam.marker(10), root = beam.marker(0);
    const System system = assemble(graph);
    State state = system.initial_state();
    const Method method = radau(1e-7);
    Simulation simulation(system, *method);
    double u[3];
    for (int i = 0; i < 3; ++i) {
      simulation.run(state, 6.71 + 0.05 * i);
      Snapshot now(system, state);
      u[i] = now.marker(root).R.col(1).dot(now.marker(tip).p);
    }
    const double slope = (u[2] - u[0]) / 2, curvature = u[2] - 2 * u[1] + u[0];
    found[k] = u[1] - slope * slope / (2 * curvature);
  }
  const double first = (4 * found[1] - found[0]) / 3, second = (4 * found[2] - found[1]) / 3;
  expect_below("spin-up, 20 elements", std::abs(found[2] / exact - 1), 0.003);
  expect_below("spin-up, extrapolated", std::abs((16 * second - first) / 15 / exact - 1), 1e-6);
}

}  // namespace
}  // namespace lithe::test::beam_flights_test
