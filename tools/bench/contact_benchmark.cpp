// Time of a step of piles at rest: 1,000 spheres in a box, ten cubes on one another, by Bullet and by the engine.
#include <benchmark/benchmark.h>

#include <cmath>

#include "integrators/moreau_jean.h"
#include "tools/contact/bullet_stepper.h"
#include "tools/contact/piles.h"

namespace lithe::contact_bench {
namespace {

constexpr double kStep = 1.0 / 240;

std::unique_ptr<Stepper> bullet(const Pile& pile) { return plain_bullet(pile, kStep, 10, false); }
std::unique_ptr<Stepper> stepper(const Pile& pile) {
  return lithe_stepper(pile, kStep, [](const System& system) {
    return std::make_unique<BulletStepper>(system, BulletStepper::Parameters{.step = kStep});
  });
}
std::unique_ptr<Stepper> moreau_jean(const Pile& pile) {
  return lithe_stepper(
      pile, kStep, [](const System&) { return std::make_unique<MoreauJean>(MoreauJean::Parameters{.step = kStep}); });
}

/// After the fall: the first second is not measured.
void BM_pile_step(benchmark::State& run, const Pile& pile, std::unique_ptr<Stepper> (*make)(const Pile&)) {
  const auto by = make(pile);
  for (int i = 0; i < std::lround(1 / kStep); ++i) by->step();
  for (auto _ : run) by->step();
  Motions motions;
  by->read(motions);
  run.counters["overlap_mm"] = 1e3 * overlap(pile, motions);
  run.counters["bodies/s"] =
      benchmark::Counter(static_cast<double>(run.iterations()) * pile.count(), benchmark::Counter::kIsRate);
}

BENCHMARK_CAPTURE(BM_pile_step, spheres_bullet, spheres(1000, 2), bullet)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(BM_pile_step, spheres_bullet_stepper, spheres(1000, 2), stepper)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(BM_pile_step, spheres_moreau_jean, spheres(1000, 2), moreau_jean)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(BM_pile_step, stack_bullet, stack("stack", 10, 1, 4), bullet)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(BM_pile_step, stack_bullet_stepper, stack("stack", 10, 1, 4), stepper)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(BM_pile_step, stack_moreau_jean, stack("stack", 10, 1, 4), moreau_jean)
    ->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace lithe::contact_bench

BENCHMARK_MAIN();
