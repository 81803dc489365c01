// Time of one step of the pendulum, from a rigid rod to thirty modes, and held by a three-node fixation.
#include <benchmark/benchmark.h>

#include "tools/bench/scenes.h"

namespace lithe::bench {
namespace {

void BM_pendulum_step(benchmark::State& run, PendulumVariant variant) {
  const Scene scene([&](SystemGraph& graph) { return draw_pendulum(graph, rod_model(), variant); });
  Evaluator evaluator(scene.system);
  State state = scene.system.initial_state();
  GeneralizedAlpha integrator({.step = 1e-3, .spectral_radius = 0.9, .newton_tolerance = 1e-10});
  integrator.start(evaluator, state);
  for (auto _ : run)
    if (!integrator.step(evaluator, state, state.time + 1e-3).ok()) run.SkipWithError("the step failed");
  run.counters["iterations"] = static_cast<double>(integrator.statistics().newton_iterations) /
                               static_cast<double>(integrator.statistics().steps);
}

BENCHMARK_CAPTURE(BM_pendulum_step, rigid, PendulumVariant{.modes = 0});
BENCHMARK_CAPTURE(BM_pendulum_step, 1_mode, PendulumVariant{.modes = 1});
BENCHMARK_CAPTURE(BM_pendulum_step, 3_modes, PendulumVariant{.modes = 3});
BENCHMARK_CAPTURE(BM_pendulum_step, 9_modes, PendulumVariant{.modes = 9});
BENCHMARK_CAPTURE(BM_pendulum_step, 30_modes, PendulumVariant{.modes = 30});
BENCHMARK_CAPTURE(BM_pendulum_step, 9_modes_three_node_fixation, PendulumVariant{.modes = 9, .fixation = true});

}  // namespace
}  // namespace lithe::bench

BENCHMARK_MAIN();
