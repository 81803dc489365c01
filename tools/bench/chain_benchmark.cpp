// Time of one step of the falling chain, by its length and its joints.
#include <benchmark/benchmark.h>

#include "tools/bench/scenes.h"

namespace lithe::bench {
namespace {

void BM_chain_step(benchmark::State& run, ChainJoint joint) {
  const int count = static_cast<int>(run.range(0));
  const Scene scene([&](SystemGraph& graph) { return draw_chain(graph, count, joint); });
  Evaluator evaluator(scene.system);
  State state = scene.system.initial_state();
  GeneralizedAlpha integrator({.step = 1e-3, .spectral_radius = 0.9, .newton_tolerance = 1e-9});
  integrator.start(evaluator, state);
  for (auto _ : run)
    if (!integrator.step(evaluator, state, state.time + 1e-3).ok()) run.SkipWithError("the step failed");
  const double steps = static_cast<double>(integrator.statistics().steps);
  run.counters["iterations"] = static_cast<double>(integrator.statistics().newton_iterations) / steps;
  run.counters["links/s"] = benchmark::Counter(steps * count, benchmark::Counter::kIsRate);
}

BENCHMARK_CAPTURE(BM_chain_step, spherical, ChainJoint::spherical)
    ->Arg(4)
    ->Arg(16)
    ->Arg(64)
    ->Arg(256)
    ->Arg(1000)
    ->Arg(4000)
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(BM_chain_step, spherical_derived, ChainJoint::spherical_derived)->Arg(1000);
BENCHMARK_CAPTURE(BM_chain_step, revolute_derived, ChainJoint::revolute_derived)->Arg(1000);
BENCHMARK_CAPTURE(BM_chain_step, revolute, ChainJoint::revolute)
    ->Arg(4)
    ->Arg(16)
    ->Arg(64)
    ->Arg(256)
    ->Arg(1000)
    ->Arg(4000)
    ->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace lithe::bench

BENCHMARK_MAIN();
