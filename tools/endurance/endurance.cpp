// A long run, watched: whether memory grows, whether energy stays, how fast it goes. Exit code 1 if the resident memory
// grows by more than --allowed megabytes after the first minute of simulated time (or tenth of the run, if that is
// earlier).
//   endurance --bodies 10000 --duration 3600      pendulums of four links on ball joints, a rigid tree
//   endurance --flexible 200 --duration 3600      pendulums of two flexible rods on pins, their results written
// More: --step S, --modes N, --report SECONDS, --allowed MB, --results FOLDER.
#include <malloc.h>

#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>

#include "bodies/flexible/flexible_body.h"
#include "bodies/flexible/reduction.h"
#include "bodies/flexible/result_writer.h"
#include "bodies/rigid_body.h"
#include "engine/base/error.h"
#include "engine/base/interrupt.h"
#include "engine/base/log.h"
#include "engine/observe/sensors.h"
#include "engine/run/simulation.h"
#include "integrators/explicit_runge_kutta.h"
#include "integrators/generalized_alpha.h"
#include "joints/revolute_joint.h"
#include "joints/spherical_joint.h"
#include "tools/bench/brick_mesh.h"
#include "tools/bench/measure.h"

namespace lithe {
namespace {

constexpr double kMegabyte = 1 << 20;

struct Options {
  int bodies = 0, flexible = 0, modes = 4;
  double duration = 3600, step = 0, report = 0, allowed = 1;  // s, s, s, MB
  std::string results = ".";

  explicit Options(bench::Arguments& arguments) {
    bodies = arguments.integer("bodies", bodies);
    flexible = arguments.integer("flexible", flexible);
    modes = arguments.integer("modes", modes);
    duration = arguments.number("duration", duration);
    step = arguments.number("step", step);
    report = arguments.number("report", report);
    allowed = arguments.number("allowed", allowed);
    results = arguments.text("results", results);
    arguments.finish();
    if ((bodies > 0) == (flexible > 0))
      throw SceneError("say which scene", "endurance", "give --bodies 10000 or --flexible 200");
    if (report <= 0) report = duration / 60;
    if (step <= 0) step = bodies > 0 ? 0.1 : 0.02;
  }
};

/// Chains of four rods of 20 m on ball joints, in rows 100 m apart, let go at different angles. Gravity is the moon's.
void add_rigid_chains(SystemGraph& graph, int bodies) {
  constexpr int kLinks = 4;
  constexpr double kLength = 20, kMass = 100;
  const Vector3 half(kLength / 2, 0, 0);
  for (int i = 0; i < bodies; i += kLinks) {
    const int chain = i / kLinks;
    Vector3 end(100.0 * (chain % 50), 100.0 * (chain / 50), 0);
    Marker last = graph.ground().marker(end);
    for (int k = 0; k < std::min(kLinks, bodies - i); ++k) {
      const Matrix3 R = rotation_about(Vector3::UnitZ(), 0.7 * chain) *
                        rotation_about(Vector3::UnitY(), 0.3 + 0.1 * k + 0.01 * (chain % 40));
      auto& rod =
          graph.add<RigidBody>("rod " + std::to_string(i + k),
                               {.mass = kMass,
                                .inertia = {kMass, kMass * kLength * kLength / 12, kMass * kLength * kLength / 12},
                                .position = end + R * half,
                                .orientation = R});
      graph.add<SphericalJoint>("ball " + std::to_string(i + k), {last, rod.marker(-half)});
      last = rod.marker(half);
      end += R * Vector3(kLength, 0, 0);
    }
  }
}

/// Pairs of plastic rods, 10 m x 0.2 m x 0.2 m, on pins. All share one basis.
std::vector<FlexibleBody*> add_flexible_pairs(SystemGraph& graph, int bodies, int modes) {
  const FiniteElementModel bar =
      bench::brick_model({.bricks = {10, 1, 1}, .size = {10, 0.2, 0.2}, .young = 2e9, .poisson = 0.3, .density = 1500});
  const auto faces = [&](double x) {
    std::vector<int> ids;
    for (int i = 0; i < bar.nodes.cols(); ++i)
      if (std::abs(bar.nodes(0, i) - x) < 1e-9) ids.push_back(bar.node_ids[static_cast<std::size_t>(i)]);
    return ids;
  };
  const std::vector<int> start = faces(0), end = faces(10);
  const auto basis = make_basis(bar, TangentFrame{start}, modes);
  const Matrix3 y_axis = rotation_about(Vector3::UnitX(), -M_PI / 2);
  std::vector<FlexibleBody*> rods;
  Marker last;
  for (int i = 0; i < bodies; ++i) {
    const int pair = i / 2;
    const Vector3 pin(0, 5.0 * pair, 0);
    const Matrix3 R = rotation_about(Vector3::UnitY(), 0.2 + 0.01 * (pair % 40));
    auto& rod =
        graph.add<FlexibleBody>("rod " + std::to_string(i),
                                {.basis = basis, .position = pin + R * Vector3(i % 2 * 10.0, 0, 0), .orientation = R});
    if (i % 2 == 0) last = graph.ground().marker(pin + R * Vector3(0, 0.1, 0.1), y_axis);
    graph.add<RevoluteJoint>("pin " + std::to_string(i), {last, rod.average(start, y_axis)});
    last = rod.average(end, y_axis);
    rods.push_back(&rod);
  }
  return rods;
}

void run(const Options& options) {
  const InterruptGuard guard;
  SystemGraph graph{{.gravity = {0, 0, options.bodies > 0 ? -1.62 : -9.81}}};
  std::vector<FlexibleBody*> rods;
  if (options.bodies > 0)
    add_rigid_chains(graph, options.bodies);
  else
    rods = add_flexible_pairs(graph, options.flexible, options.modes);
  const System system = assemble(graph);
  State state = system.initial_state();
  std::unique_ptr<Integrator> integrator;
  if (options.bodies > 0)
    integrator = std::make_unique<ExplicitRungeKutta>(ExplicitRungeKutta::Parameters{.step = options.step});
  else
    integrator =
        std::make_unique<GeneralizedAlpha>(GeneralizedAlpha::Parameters{.step = options.step, .spectral_radius = 0.9});
  Simulation simulation(system, *integrator);
  std::optional<ResultWriter> results;
  if (!rods.empty()) simulation.observe(results.emplace(*rods.front(), options.results + "/endurance.h5"), every(1.0));

  Snapshot now(system, state);
  const Sensor energy = total_energy(), kinetic = kinetic_energy();
  const double first_energy = energy.value(now);
  double moved = 0, settled = 0, grown = 0;
  const double settling = std::min(60.0, options.duration / 10);
  std::printf("%d bodies, step %g s, %s\n%10s %10s %12s %12s %14s %16s\n", static_cast<int>(graph.bodies().size()) - 1,
              options.step, integrator->name().c_str(), "t, s", "CPU, s", "resident, MB", "malloc, MB", "grown, MB",
              "energy drift");
  const double began = bench::cpu_seconds();
  for (double t = 0; options.duration - t > 1e-9;) {
    t = std::min(options.duration, t < settling ? settling : t + options.report);
    simulation.run(state, t);
    now.evaluate(state);
    moved = std::max(moved, kinetic.value(now));
    const double memory = bench::resident_memory();
    if (settled == 0) settled = memory;
    grown = memory - settled;
    std::printf("%10.0f %10.1f %12.2f %12.2f %14.3f %16.2e\n", t, bench::cpu_seconds() - began, memory / kMegabyte,
                static_cast<double>(mallinfo2().uordblks) / kMegabyte, grown / kMegabyte,
                (energy.value(now) - first_energy) / moved);
    std::fflush(stdout);
  }
  std::printf("%s: resident memory grew by %.3f MB after t = %g s\n",
              grown <= options.allowed * kMegabyte ? "ok" : "GROWS", grown / kMegabyte, settling);
  if (grown > options.allowed * kMegabyte) throw std::runtime_error("memory grows");
}

}  // namespace
}  // namespace lithe

int main(int count, char** words) {
  return lithe::bench::run_program(count, words,
                                   [](lithe::bench::Arguments& arguments) { lithe::run(lithe::Options(arguments)); });
}
