#include "tests/integrators/smooth_scenes.h"

#include <algorithm>
#include <cmath>

#include "bodies/flexible/flexible_body.h"
#include "bodies/flexible/reduction.h"
#include "joints/revolute_joint.h"
#include "tests/bodies/bar_model.h"

namespace lithe::test {
namespace {

/// A rubber bar of 0.3 m, hung by one end, with two modes beside those that its load brings.
Scene rubber_pendulum() {
  static const auto basis = [] {
    const FiniteElementModel model =
        bar_model({.size = {0.3, 0.04, 0.03}, .bricks = {4, 1, 1}, .young = 3e6, .density = 1000});
    return make_basis(model, MeanAxisFrame{}, 2, {.loaded = {{model.node_set("start")}}});
  }();
  static const auto start =
      bar_model({.size = {0.3, 0.04, 0.03}, .bricks = {4, 1, 1}, .young = 3e6, .density = 1000}).node_set("start");
  return Scene({0, 0, -9.81}, [](SystemGraph& graph) {
    auto& bar = graph.add<FlexibleBody>("bar", {.basis = basis});
    const Matrix3 axes = rotation_about({1, 0, 0}, M_PI / 2);
    graph.add<RevoluteJoint>("pin", {graph.ground().marker(Vector3::Zero(), axes), bar.average(start, axes)});
  });
}

}  // namespace

const std::array<SmoothScene, 5> kSmoothScenes{{
    {"pendulum", [] { return mass_chain({M_PI / 3}); }, 1.5},
    {"heavy top",
     [] {
       return heavy_top(15, 1, 15.234375, 0.46875, {0, 15, -4.61538});
     },
     1},
    {"chain of ball joints", [] { return box_chain(4, false); }, 0.5},
    {"chain of hinges", [] { return box_chain(4, true); }, 0.5},
    {"rubber pendulum", [] { return rubber_pendulum(); }, 0.1},
}};

RunErrors run_difference(const State& a, const State& b) {
  return {(a.q - b.q).cwiseAbs().maxCoeff(), (a.v - b.v).cwiseAbs().maxCoeff(),
          (a.lambda - b.lambda).norm() / b.lambda.norm()};
}

std::vector<State> five_states(const SmoothScene& smooth, Method method) {
  Scene scene = smooth.make();
  std::vector<State> states;
  for (int k = 1; k <= 5; ++k) {
    scene.run(*method, k * smooth.end / 5);
    states.push_back(scene.state);
  }
  return states;
}

RunErrors run_difference(const std::vector<State>& a, const std::vector<State>& b) {
  RunErrors worst{};
  for (std::size_t i = 0; i < a.size(); ++i) {
    const RunErrors here = run_difference(a[i], b[i]);
    worst = {std::max(worst.q, here.q), std::max(worst.v, here.v), std::max(worst.lambda, here.lambda)};
  }
  return worst;
}

}  // namespace lithe::test
