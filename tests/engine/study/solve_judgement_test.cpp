// What solve() states of runs made by hand: every number is known.
#include "engine/study/solve_judgement_internal.h"

#include <gtest/gtest.h>

#include "bodies/flexible/elements/meshes.h"
#include "bodies/flexible/flexible_body.h"
#include "engine/observe/sensors.h"

namespace lithe::test::solve_judgement_test {
namespace {

using namespace solving;

/// A scene that nothing runs of: one body with candidate modes, and something watched that tables stand for.
struct Judged {
  Judged() {
    static const FiniteElementModel model =
        brick_mesh({.size = {0.4, 0.02, 0.01}, .divisions = {4, 1, 1}, .type = "C3D8I", .material = {1e8, 0.3, 1150}});
    graph.add<FlexibleBody>("rod", {.basis = make_basis(model, TangentFrame{model.node_set("x_min")}, 6)});
    bodies.emplace(graph);
    wants.push_back(want({"x", {"x"}, [](Snapshot&, std::span<double> out) { out[0] = 0; }}, within(1)));
    asked.emplace(ask(graph, *bodies, 1, wants, methods, {.samples = 100}, costs));
  }
  /// It rises to the value at the end.
  ModelRun run(double value, const std::vector<int>& modes) const {
    ModelRun run;
    run.models = {Fidelity{modes, Deflection::linear}};
    run.samples.columns = {"t", "x"};
    run.samples.add_row(std::vector<double>{0, 0});
    run.samples.add_row(std::vector<double>{1, value});
    return run;
  }

  SystemGraph graph;
  std::optional<BodyModels> bodies;
  std::vector<Want> wants;
  SolveMethods methods;
  std::vector<CertificateCost> costs;
  std::optional<Asked> asked;
};

TEST(ModelJudge, modes_that_long_steps_hide_count_as_far_as_the_difference_does_not_show_them) {
  const Judged scene;
  RigidMotion rigid;
  rigid.amplification = {1};
  Choice choice;
  choice.effects.second_order = choice.effects.fourth_order = {0};
  choice.effects.modes = {{0, 0, 1, 0.1, {5}}, {0, 1, 500, 0.1, {0.03}}, {0, 2, 900, 0.1, {0.002}}};  // 1, 500, 900 Hz
  // Steps of 10 ms hide 500 Hz, which the richer run alone has; neither has 900 Hz.
  const Pace pace{0.01, 0};
  for (const double shown : {0.0, 0.02, 0.05}) {
    SCOPED_TRACE(shown);
    ModelJudge judge(*scene.asked, rigid, choice);
    judge.compare_with(scene.run(10 + shown, {0, 1}), pace);
    const double error = judge.model_errors({{scene.run(10, {0})}, {pace}}).at(0);
    EXPECT_NEAR(error, kMeasured * shown + kCaution * (std::max(0.0, 0.03 - shown) + 0.002), 1e-12);
  }
}

TEST(ModelJudge, by_tolerance_the_nearest_run_that_is_as_tight_tells_what_a_model_leaves_out) {
  const Judged scene;
  RigidMotion rigid;
  rigid.amplification = {1};
  Choice choice;
  choice.effects.second_order = choice.effects.fourth_order = {0};
  ModelJudge judge(*scene.asked, rigid, choice);
  judge.compare_with(scene.run(10, {0, 1}), {0, 0.01});
  const std::vector<ModelRun> runs = {scene.run(10.001, {0}), scene.run(10.3, {0}), scene.run(10.1, {0})};
  // The first is looser than the richer run, and near it by chance.
  EXPECT_NEAR(judge.model_errors({runs, {{0, 0.1}, {0, 0.01}, {0, 0.001}}}).at(0), kMeasured * 0.1, 1e-12);
  // Fixed steps are the same in both.
  judge.compare_with(scene.run(10, {0, 1}), {0.01, 0});
  EXPECT_NEAR(judge.model_errors({runs, {{0.02, 0}, {0.01, 0}, {0.005, 0}}}).at(0), kMeasured * 0.3, 1e-12);
}

}  // namespace
}  // namespace lithe::test::solve_judgement_test
