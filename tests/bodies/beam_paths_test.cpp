#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>

#include "bodies/beam/beam.h"
#include "engine/analysis/equilibrium.h"
#include "engine/analysis/equilibrium_path.h"
#include "joints/fixed_joint.h"
#include "joints/forces/user_force.h"
#include "joints/revolute_joint.h"
#include "tests/support/json_file.h"
#include "tests/support/methods.h"

/// Frames that snap through, followed by their arc length, against tests/data/beams, which README.md there explains.
namespace lithe::test::beam_paths_test {
namespace {

nlohmann::json data(const std::string& name) { return read_json(std::string(LITHE_TEST_DATA) + "/beams/" + name); }

/// Out of its plane it is stiffer, so that it stays there.
BeamSection in_plane(double EA, double GA, double EI) {
  return BeamSection::diagonal({EA, GA, GA, 10 * EI, 10 * EI, EI}, 1, {2, 1, 1});
}

/// Of a path of equilibria: load, and where the loaded section went, along x and down.
using Path = std::vector<Vector3>;

/// Under a dead load on `loaded`, down the world's y, from none to `most` (N).
Path path_of(SystemGraph& graph, const Marker& loaded, double most) {
  graph.add<UserForce>("load", {loaded}, {[most](double share, const MarkerView&) {
                         return force({0, -most * share, 0});
                       }});
  const System system = assemble(graph);
  const State start = find_equilibrium(system, system.initial_state()).state;
  const EquilibriumPath found = follow_equilibria(system, start, {.max_turn = 0.1, .max_step = 1});
  Snapshot now(system, start);
  const Vector3 drawn = now.marker(loaded).p;
  Path path;
  for (const State& state : found.states) {
    now.evaluate(state);
    const Vector3 way = now.marker(loaded).p - drawn;
    path.emplace_back(most * state.time, way[0], -way[1]);
  }
  return path;
}

/// Where the path first passes `at` in one of its columns, by the polynomial through the six states around.
Vector3 at(const Path& path, int column, double value) {
  const auto next = std::find_if(path.begin(), path.end(), [&](const Vector3& p) { return p[column] > value; });
  const auto first = std::clamp<std::ptrdiff_t>(next - path.begin() - 3, 0, static_cast<int>(path.size()) - 6);
  const std::vector<Vector3> near(path.begin() + first, path.begin() + first + 6);
  Vector3 sum = Vector3::Zero();
  for (const Vector3& one : near) {
    double weight = 1;
    for (const Vector3& other : near)
      if (&other != &one) weight *= (value - other[column]) / (one[column] - other[column]);
    sum += weight * one;
  }
  return sum;
}

/// The limit load near the place where `column` has a value: the parabola through three points of the path.
double limit_load(const Path& path, int column, double near) {
  const double h = 0.01 * near;
  double load[3];
  for (int i = 0; i < 3; ++i) load[i] = at(path, column, near + (i - 1) * h)[0];
  const double slope = (load[2] - load[0]) / 2, curvature = load[2] - 2 * load[1] + load[0];
  return load[1] - slope * slope / (2 * curvature);
}

/// Without the error of second order, relative to the size of each column along the path.
void expect_path(const std::string& what, const Path (&meshes)[2], int column, const Vector3& exact,
                 const Vector3& size, double bound) {
  const Vector3 found = (4 * at(meshes[1], column, exact[column]) - at(meshes[0], column, exact[column])) / 3;
  expect_below(what, ((found - exact).array() / size.array()).abs().maxCoeff(), bound);
}

TEST(BeamPaths, DeepArchGoesPastItsLimitLoad) {
  const auto file = data("S06_arch_clamped_hinged.json");
  const double R = 100, half = 107.5 * M_PI / 180, EI = 1e6;
  // From the left end over the crown: the tangent turns clockwise, about -z.
  const FramePose left{{-R * std::sin(half), R * std::cos(half), 0}, rotation_about({0, 0, 1}, half)};
  const BeamAxis axis = BeamAxis::curved(left, {0, 0, -1 / R}, 2 * half * R);
  const FramePose right = axis.pose(axis.length);
  const auto reference = file["cases"]["EA=2.29e6 GA=1.145e6"];
  Path meshes[2];
  for (int k = 0; k < 2; ++k) {
    SystemGraph graph{{.gravity = Vector3::Zero()}};
    auto& arch = graph.add<Beam>("arch", {.axis = axis,
                                          .sections = {{0, in_plane(reference["EA"], reference["GA"], EI)}},
                                          .elements = 32 << k,
                                          .stations = {half * R}});
    graph.add<FixedJoint>("clamp", {graph.ground().marker(left.position, left.axes), arch.marker(0)});
    graph.add<RevoluteJoint>("hinge", {graph.ground().marker(right.position, right.axes), arch.marker(axis.length)});
    meshes[k] = path_of(graph, arch.marker(half * R), 1000);
  }
  for (const auto& row : reference["path"]["rows"]) {
    const Vector3 exact(row[1].get<double>() * EI / (R * R), row[2].get<double>() * R, row[0].get<double>() * R);
    expect_path("deep arch, path", meshes, 2, exact, {897, 61, 114}, 1.5e-4);
  }
  const double critical = reference["P_cr"], place = reference["crown_down_over_R"].get<double>() * R;
  const double coarse = limit_load(meshes[0], 2, place), fine = limit_load(meshes[1], 2, place);
  expect_below("deep arch, limit load, 64 elements", std::abs(fine / critical - 1), 0.01);
  expect_below("deep arch, limit load", std::abs((4 * fine - coarse) / 3 / critical - 1), 1.5e-4);
  EXPECT_GT(std::abs(coarse / critical - 1), 3 * std::abs(fine / critical - 1));
}

/// A column and a beam of 120, the load on the beam 24 from the corner. The reference knows no shear. Returns where the
/// load acts.
Marker draw_lee_frame(SystemGraph& graph, int elements) {
  const BeamSection section = in_plane(4.32e7, 4.32e11, 1.44e7);
  auto& column = graph.add<Beam>("column", {.axis = BeamAxis::straight({0, 0, 0}, {0, 120, 0}, {-1, 0, 0}),
                                            .sections = {{0, section}},
                                            .elements = elements});
  auto& beam = graph.add<Beam>("beam", {.axis = BeamAxis::straight({0, 120, 0}, {120, 120, 0}, {0, 1, 0}),
                                        .sections = {{0, section}},
                                        .elements = elements,
                                        .stations = {24}});
  graph.add<FixedJoint>("corner", {column.marker(120), beam.marker(0, {}, beam.axes(0).transpose() * column.axes(0))});
  graph.add<RevoluteJoint>("foot", {graph.ground().marker({0, 0, 0}, column.axes(0)), column.marker(0)});
  graph.add<RevoluteJoint>("wall", {graph.ground().marker({120, 120, 0}), beam.marker(120)});
  return beam.marker(24);
}

/// From one load to the next, beyond the upper limit too: where it is past there is an equilibrium elsewhere, and the
/// stiff frame has to get there.
TEST(BeamPaths, LeeFrameJumpsUnderALoadThatGrows) {
  const auto file = data("S09_lee_frame.json");
  const auto row =
      std::find_if(file["path"].begin(), file["path"].end(), [](const auto& r) { return r[0] > 24000 && r[2] > 93; });
  ASSERT_NE(row, file["path"].end());
  const double most = (*row)[0];
  SystemGraph graph{{.gravity = Vector3::Zero()}};
  const Marker loaded = draw_lee_frame(graph, 20);
  graph.add<UserForce>("load", {loaded}, {[most](double share, const MarkerView&) {
                         return force({0, -most * share, 0});
                       }});
  const System system = assemble(graph);
  State state = system.initial_state();
  double before = 0, jump = 0;
  for (int i = 0; i <= 25; ++i) {
    state.time = i / 25.0;
    state = find_equilibrium(system, state).state;
    const double down = 120 - Snapshot(system, state).marker(loaded).p.y();
    jump = std::max(jump, down - before), before = down;
  }
  const Vector3 at_end = Snapshot(system, state).marker(loaded).p;
  expect_below("Lee's frame after its jump, right", std::abs(at_end.x() - 24 - (*row)[1].get<double>()) / 120, 5e-4);
  expect_below("Lee's frame after its jump, down", std::abs(before - (*row)[2].get<double>()) / 120, 5e-4);
  EXPECT_GT(jump, 40);
}

TEST(BeamPaths, LeeFrameSnapsThroughAndBack) {
  const auto file = data("S09_lee_frame.json");
  Path meshes[2];
  for (int k = 0; k < 2; ++k) {
    SystemGraph graph{{.gravity = Vector3::Zero()}};
    const Marker loaded = draw_lee_frame(graph, 15 << k);
    meshes[k] = path_of(graph, loaded, 2e4);
  }
  for (const auto& row : file["path"]) {
    const Vector3 exact(row[0], row[1], row[2]);
    if (exact[0] > 1.9e4) break;
    // The way along x rises where that down does not.
    const int rising = exact[2] > 40 && exact[2] < 61 ? 1 : 2;
    expect_path("Lee's frame, path", meshes, rising, exact, {18557, 94, 93}, 1e-3);
  }
  for (const auto& point : file["limit_points"]) {
    const double exact = point["P"], place = point["u_right"];
    const double coarse = limit_load(meshes[0], 1, place), fine = limit_load(meshes[1], 1, place);
    expect_below("Lee's frame, limit load, 30 elements a member", std::abs(fine / exact - 1), 0.01);
    expect_below("Lee's frame, limit load", std::abs((4 * fine - coarse) / 3 / exact - 1), 1e-4);
    EXPECT_GT(std::abs(coarse / exact - 1), 3 * std::abs(fine / exact - 1));
  }
}

}  // namespace
}  // namespace lithe::test::beam_paths_test
