#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <sstream>

#include "bodies/beam/beam_table.h"
#include "engine/analysis/equilibrium.h"
#include "engine/analysis/linearization.h"
#include "engine/run/simulation.h"
#include "joints/fixed_joint.h"
#include "tests/support/methods.h"
#include "tests/support/motion.h"

/// Blades under their weight: cases of BeamDyn in tests/data/beams/beamdyn, which README.md there explains.
namespace lithe::test::beam_gravity_test {
namespace {

std::string data(const std::string& name) { return LITHE_TEST_DATA "/beams/beamdyn/" + name; }

/// Rows of numbers below a line of names.
std::vector<std::vector<double>> table(const std::string& name) {
  std::ifstream file(data(name));
  std::string line;
  std::getline(file, line);
  std::vector<std::vector<double>> rows;
  while (std::getline(file, line)) {
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream numbers(line);
    rows.emplace_back();
    for (double x; numbers >> x;) rows.back().push_back(x);
  }
  return rows;
}

/// Where the tip goes, and how far it turns about y.
using Tip = Vector4;

/// B01 at rest, drawn with each node off its place by up to `disturbance` (m).
Tip tip_of_b01(int elements, double disturbance = 0) {
  SystemGraph graph{{.gravity = {9.806, 0, 0}}};
  Beam::Parameters p = beam_table(data("B01.inp"));
  p.elements = elements;
  auto& beam = graph.add<Beam>("beam", p);
  const FramePose root = p.axis.pose(0);
  graph.add<FixedJoint>("clamp", {graph.ground().marker(root.position, root.axes), beam.marker(0)});
  const Marker tip = beam.marker(beam.length());
  const System system = assemble(graph);
  State start = system.initial_state();
  RandomNumbers random(5);
  for (int i = 1; i < beam.node_count(); ++i) start.q.segment<3>(7 * i) += random.vector(3, disturbance);
  const Equilibrium found = find_equilibrium(system, start);
  EXPECT_LE(found.iterations, 30);
  EXPECT_GT(linearize(system, found.state, {.mode_count = 2}).lowest_stiffness(), 0.1);
  Snapshot now(system, found.state);
  const MarkerKinematics at = now.marker(tip);
  const Vector3 way = at.p - p.axis.pose(beam.length()).position, along = at.R.col(0);
  return {way[0], way[1], way[2], std::atan2(along[0], along[2])};
}

/// It hangs down from a level clamp by 94 % of its length: whatever disturbs the start, it comes to rest in its plane.
TEST(BeamGravity, CantileverOfB01HangsInItsPlane) {
  const Tip exact(9.417614981449768, 0, -8.389151489124865, 4 * std::atan(1.6485119277765747 / 4));
  const Tip coarse = tip_of_b01(32), fine = tip_of_b01(64);
  expect_below("B01, 32 elements, m", (coarse - exact).norm(), 0.02);
  expect_below("B01, extrapolated", ((4 * fine - coarse) / 3 - exact).norm(), 2e-5);
  for (const int elements : {10, 20, 40}) {
    const Tip plane = tip_of_b01(elements), disturbed = tip_of_b01(elements, 1e-3);
    expect_below("B01, sideways, m", std::max(std::abs(plane[1]), std::abs(disturbed[1])), 1e-9);
    expect_below("B01, disturbed, m", (disturbed - plane).norm(), 1e-9);
  }
}

/// The blade of 61.5 m of B05: twist and properties linear between its stations.
Beam::Parameters blade_of_5_mw() {
  const auto rows = table("nrel5mw_blade_stations.csv");
  Beam::Parameters p;
  for (const auto& r : rows) {
    BeamSection section = BeamSection::diagonal({r[5], r[3], r[4], r[8], r[6], r[7]}, r[9], {r[12], r[10], r[11]});
    section.damping << 0.001, 0.001, 0.001, 0.0022, 0.0014, 0.0022;
    p.sections.push_back({r[1], section});
  }
  p.axis.length = rows.back()[1];
  p.axis.pose = [rows](double arc) {
    const auto next = std::find_if(rows.begin() + 1, rows.end() - 1, [&](const auto& r) { return r[1] > arc; });
    const auto& a = *(next - 1);
    const auto& b = *next;
    const double twist = a[2] + (b[2] - a[2]) * (arc - a[1]) / (b[1] - a[1]);
    // Columns: z, x and y of the blade, turned about z by minus the twist.
    Matrix3 axes;
    axes << 0, 1, 0, 0, 0, 1, 1, 0, 0;
    return FramePose{{0, 0, arc}, rotation_about({0, 0, 1}, -twist * M_PI / 180) * axes};
  };
  return p;
}

/// Way of the tip along x and y (m), and the moment about x on the support (N m), at some times.
std::vector<Vector3> swing(int elements, const std::vector<std::vector<double>>& times) {
  SystemGraph graph{{.gravity = {0, -9.8, 0}}};
  Beam::Parameters p = blade_of_5_mw();
  p.elements = elements;
  auto& blade = graph.add<Beam>("blade", p);
  const FramePose root = p.axis.pose(0);
  auto& clamp = graph.add<FixedJoint>("clamp", {graph.ground().marker(root.position, root.axes), blade.marker(0)});
  const Marker tip = blade.marker(blade.length());
  const Sensor load = reaction(clamp, 0);
  const System system = assemble(graph);
  State state = system.initial_state();
  const Method method = radau(1e-5);
  Simulation simulation(system, *method);
  std::vector<Vector3> found;
  for (const auto& row : times) {
    simulation.run(state, row[0]);
    Snapshot now(system, state);
    double values[6];
    load.evaluate(now, values);
    const Vector3 way = now.marker(tip).p - Vector3(0, 0, blade.length());
    found.emplace_back(way[0], way[1], values[3]);
  }
  return found;
}

/// Undeformed at first, it swings under its weight for 0.7 s.
TEST(BeamGravity, BladeOfB05SwingsUnderItsWeight) {
  const auto own = table("B05_5mw_own.csv"), peer = table("B05_5mw_gravity_az00.csv");
  const std::vector<Vector3> coarse = swing(48, own), fine = swing(96, own);
  const Vector3 size(0.2599, 0.8914, 6.025e6);  // largest of each
  Vector3 off_own = Vector3::Zero(), off_peer = Vector3::Zero();
  for (std::size_t i = 0; i < own.size(); ++i) {
    const auto error = [&](const std::vector<double>& row) {
      const Vector3 exact(row[7], row[8], row[4]);
      return Vector3(((4 * fine[i] - coarse[i]) / 3 - exact).cwiseAbs().cwiseQuotient(size));
    };
    off_own = off_own.cwiseMax(error(own[i])), off_peer = off_peer.cwiseMax(error(peer[i]));
  }
  const std::string what[] = {"tip x", "tip y", "root moment"};
  for (const int k : {0, 1, 2}) {
    expect_below("B05, " + what[k], off_own[k], 3e-3);
    expect_below("B05, peer, " + what[k], off_peer[k], 0.03);  // six nodes: the peer itself is off by 2.5 %
  }
}

}  // namespace
}  // namespace lithe::test::beam_gravity_test
