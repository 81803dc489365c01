#include "bodies/flexible/fatigue_recorder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>

#include "bodies/flexible/elements/meshes.h"
#include "engine/archive/archive.h"
#include "engine/output/csv.h"
#include "engine/run/simulation.h"
#include "joints/fixed_joint.h"
#include "tests/engine/output/output_scratch_folder.h"
#include "tests/support/linear_algebra.h"
#include "tests/support/message_of.h"
#include "tests/support/methods.h"

namespace lithe::test::fatigue_recorder_test {
namespace {

/// A bar of 0.2 m that hangs along gravity (+x), clamped at x = 0: σ = ρ g (L - x), exact to quadratic elements.
struct StretchedBar {
  static constexpr double kLength = 0.2, kRoot = 5000 * 9.81 * kLength;
  FiniteElementModel model =
      brick_mesh({.size = {kLength, 0.02, 0.03}, .divisions = {4, 1, 1}, .material = {2e8, 0, 5000}});
  SystemGraph graph{{.gravity = Vector3::Zero()}};
  FlexibleBody* bar;
  VectorX hanging;

  StretchedBar() {
    const auto basis = make_basis(model, TangentFrame{model.node_set("x_min")}, kAllNodal);
    VectorX weight(basis->mode_count());
    const VectorX mass = basis->nodal_mass * VectorX::Ones(model.node_count());
    for (int k = 0; k < weight.size(); ++k) {
      const int dof = basis->free_dofs[static_cast<size_t>(k)];
      weight[k] = dof % 3 == 0 ? 9.81 * mass[dof / 3] : 0;
    }
    hanging = solve_positive(basis->stiffness, weight);
    bar = &graph.add<FlexibleBody>("bar", {.basis = basis});
  }
  /// σ = σ_hanging (mean + amplitude cos 2πt), 20 states a period.
  void swing(const System& system, FatigueRecorder& fatigue, double mean, double amplitude, int periods) const {
    State state = system.initial_state();
    for (int i = 0; i <= 20 * periods; ++i) {
      state.time = i / 20.0;
      state.q.tail(hanging.size()) = (mean + amplitude * std::cos(M_PI * i / 10)) * hanging;
      fatigue.observe(*std::make_unique<Snapshot>(system, state));
    }
  }
};

const SnCurve kCurve{.range = 1e4, .cycles = 1e5, .exponent = 4};

TEST(FatigueRecorder, HasTheDamageOfAUniaxialSineByBothStresses) {
  StretchedBar scene;
  const System system = assemble(scene.graph);
  FatigueRecorder fatigue(*scene.bar);
  scene.swing(system, fatigue, 0.3, 2, 3);  // forgotten, as the next run starts anew
  scene.swing(system, fatigue, 0, 1, 6);
  for (const auto stress : {FatigueStress::signed_von_mises, FatigueStress::critical_plane}) {
    const Table table = fatigue.table({.curve = kCurve, .stress = stress});
    ASSERT_EQ(table.row_count(), scene.model.node_count());
    for (int row = 0; row < table.row_count(); ++row) {
      const int node = scene.model.node_index(static_cast<int>(table.at(row, 0)));
      const double range = 2 * scene.kRoot * (1 - scene.model.nodes(0, node) / scene.kLength);
      const double damage = 6 / (1e5 * std::pow(1e4 / std::max(range, 1e-9), 4));
      EXPECT_NEAR(table.at(row, 2), range, 1e-7 * scene.kRoot);
      EXPECT_NEAR(table.at(row, 3), damage, 1e-6 * damage + 1e-15);
      if (range > 1) {
        EXPECT_NEAR(table.at(row, 1), 6, 1e-12);
        EXPECT_NEAR(table.at(row, 4), 6 / table.at(row, 3), 1e-9 * table.at(row, 4));
      }
    }
  }
  const std::vector<int> root = scene.model.node_set("x_min");
  EXPECT_EQ(fatigue.table({.curve = kCurve, .nodes = root}).row_count(), static_cast<int>(root.size()));
}

TEST(FatigueRecorder, CountsTheMeanByGoodman) {
  StretchedBar scene;
  const System system = assemble(scene.graph);
  FatigueRecorder fatigue(*scene.bar);
  scene.swing(system, fatigue, 1, 0.5, 3);
  SnCurve curve = kCurve;
  const std::vector<int> root{scene.model.node_set("x_min").front()};
  const double none = fatigue.table({.curve = curve, .nodes = root}).at(0, 3);
  curve.tensile_strength = 4 * scene.kRoot;
  EXPECT_NEAR(fatigue.table({.curve = curve, .nodes = root}).at(0, 3) / none, std::pow(1 / 0.75, 4), 1e-6);
  curve.tensile_strength = 1.4 * scene.kRoot;
  expect_says(message_of<SceneError>([&] { fatigue.table({.curve = curve, .nodes = root}); }),
              {"tensile strength", "node " + std::to_string(root[0]), "fatigue of 'bar'"});
}

/// Turned by 30 degrees about each axis the plane of most damage is found within its 0.9 % of the range.
TEST(FatigueRecorder, FindsTheCriticalPlaneOfAnyDirection) {
  StretchedBar scene;
  const auto basis = scene.bar->basis();
  const System system = assemble(scene.graph);
  for (const Vector3& turn : {Vector3(0.5, 0.2, 0.7), Vector3(-0.3, 1.1, 0.4), Vector3(1, -0.6, 0.2)}) {
    const StressRecovery own(basis);
    MatrixX modes(6 * own.node_count(), own.coordinate_count());
    for (int k = 0; k < own.coordinate_count(); ++k)
      modes.col(k) = turned_stress(own.stress(VectorX::Unit(own.coordinate_count(), k)), rotation_exp(turn)).reshaped();
    FatigueRecorder fatigue(*scene.bar, std::make_shared<StressRecovery>(modes));
    scene.swing(system, fatigue, 0, 1, 2);
    const Table table = fatigue.table(
        {.curve = kCurve, .stress = FatigueStress::critical_plane, .nodes = {scene.model.node_set("x_min").front()}});
    EXPECT_LT(table.at(0, 2), 2 * scene.kRoot * (1 + 1e-9));
    EXPECT_GT(table.at(0, 2), 2 * scene.kRoot * 0.991);
  }
}

/// One mode rings for ten periods: each node comes by ten cycles of twice its first stress.
TEST(FatigueRecorder, OfAModeThatRingsHasTheCyclesOfItsPeriods) {
  const FiniteElementModel model =
      brick_mesh({.size = {0.5, 0.02, 0.02}, .divisions = {6, 1, 1}, .material = {2e11, 0.3, 7800}});
  SystemGraph graph{{.gravity = Vector3::Zero()}};
  const auto basis = make_basis(model, TangentFrame{model.node_set("x_min")}, 1);
  auto& bar = graph.add<FlexibleBody>("bar", {.basis = basis, .modal_coordinates = VectorX::Constant(1, 1e-3)});
  graph.add<FixedJoint>("clamp", {graph.ground().marker({0, 0.01, 0.01}), bar.average(model.node_set("x_min"))});
  const System system = assemble(graph);
  State state = system.initial_state();
  FatigueRecorder fatigue(bar);
  const Method method = runge_kutta8(1e-10);
  Simulation simulation(system, *method);
  const double period = 1 / basis->frequencies[0];
  simulation.observe(fatigue, every(period / 40));
  simulation.run(state, 10 * period);
  const Table table = fatigue.table({.curve = {.range = 1e8}, .nodes = model.node_set("x_min")});
  const Matrix6X first = StressRecovery(*basis).stress(VectorX::Constant(1, 1e-3));
  for (int row = 0; row < table.row_count(); ++row) {
    const double range = 2 * von_mises(first.col(model.node_index(static_cast<int>(table.at(row, 0)))))[0];
    EXPECT_NEAR(table.at(row, 1), 10, 1e-12);
    EXPECT_NEAR(table.at(row, 2) / range, 1, 1e-6);
    EXPECT_NEAR(table.at(row, 3) / (10 / (2e6 * std::pow(1e8 / range, 5))), 1, 1e-5);
  }
}

TEST(FatigueRecorder, ContinuesWithItsHistoryAndWritesFiles) {
  StretchedBar scene;
  const System system = assemble(scene.graph);
  FatigueRecorder fatigue(*scene.bar), resumed(*scene.bar);
  scene.swing(system, fatigue, 0, 1, 2);
  Archive archive;
  fatigue.history(archive);
  archive.rewind();
  resumed.history(archive);
  const Table table = fatigue.table({.curve = kCurve});
  EXPECT_EQ(resumed.table({.curve = kCurve}).values, table.values);
  const ScratchFolder folder;
  write_csv(table, folder.path("fatigue.csv"));
  EXPECT_EQ(read_csv(folder.path("fatigue.csv")).values, table.values);
  fatigue.write_vtu(folder.path("fatigue.vtu"), table);
  std::ifstream file(folder.path("fatigue.vtu"));
  std::stringstream text;
  text << file.rdbuf();
  expect_says(text.str(), {"\"damage\"", "\"largest_range\""});
}

TEST(FatigueRecorder, IsOfTheModesThatTheBodyHadWhenItWasMade) {
  const FiniteElementModel model =
      brick_mesh({.size = {0.5, 0.02, 0.02}, .divisions = {3, 1, 1}, .material = {2e11, 0.3, 7800}});
  SystemGraph graph;
  auto& bar = graph.add<FlexibleBody>("bar", {.basis = make_basis(model, TangentFrame{model.node_set("x_min")}, 4)});
  bar.set_fidelity({.modes = {0}});
  FatigueRecorder fatigue(bar);
  bar.set_fidelity({.modes = {0, 1, 2}});
  const System system = assemble(graph);
  Snapshot now(system, system.initial_state());
  expect_says(message_of<SceneError>([&] { fatigue.observe(now); }),
              {"1 fields of 'bar'", "now has 3", "set_fidelity"});
}

TEST(FatigueRecorder, SaysWhatIsMissing) {
  StretchedBar scene;
  const System system = assemble(scene.graph);
  FatigueRecorder fatigue(*scene.bar);
  expect_says(message_of<SceneError>([&] { fatigue.table({.curve = kCurve}); }), {"0 observed states", "every("});
  scene.swing(system, fatigue, 0, 1, 1);
  expect_says(message_of<SceneError>([&] { fatigue.table({}); }), {"range of the S-N curve", "fatigue of 'bar'"});
  expect_says(message_of<SceneError>([&] { fatigue.table({.curve = kCurve, .nodes = {12345}}); }), {"12345"});
}

}  // namespace
}  // namespace lithe::test::fatigue_recorder_test
