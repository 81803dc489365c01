// A long run, watched: whether memory grows, whether energy stays, how fast it goes. Exit code 1 if the resident memory
// grows by more than --allowed megabytes after the first minute of simulated time (or tenth of the run, if that is
// earlier).
//   endurance --bodies 10000 --duration 3600      pendulums of four links on ball joints, a rigid tree
//   endurance --flexible 200 --duration 3600      pendulums of two flexible rods on pins, their results written
//   endurance --contacts 10000 --duration 600     2,500 boxes that slide and stick on a shaken table, Moreau-Jean
//   endurance --restarts 1000 --duration 10       a run that is saved and resumed as often, each time by a new
//   simulation;
//                                                 it ends with the bits of the run that was not
// More: --step S, --modes N, --report SECONDS, --allowed MB, --results FOLDER.
#include <malloc.h>

#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>

#include "bodies/flexible/result_writer.h"
#include "engine/base/error.h"
#include "engine/base/interrupt.h"
#include "engine/observe/contact_sensors.h"
#include "engine/observe/sensors.h"
#include "engine/run/simulation.h"
#include "integrators/explicit_runge_kutta.h"
#include "integrators/generalized_alpha.h"
#include "integrators/moreau_jean.h"
#include "joints/contact/contact.h"
#include "tools/bench/measure.h"
#include "tools/endurance/scenes.h"

namespace lithe::endurance {
namespace {

constexpr double kMegabyte = 1 << 20;

struct Options {
  int bodies = 0, flexible = 0, contacts = 0, restarts = 0, modes = 4;
  double duration = 3600, step = 0, report = 0, allowed = 1;  // s, s, s, MB
  std::string results = ".";

  explicit Options(bench::Arguments& arguments) {
    bodies = arguments.integer("bodies", bodies);
    flexible = arguments.integer("flexible", flexible);
    contacts = arguments.integer("contacts", contacts);
    restarts = arguments.integer("restarts", restarts);
    modes = arguments.integer("modes", modes);
    duration = arguments.number("duration", duration);
    step = arguments.number("step", step);
    report = arguments.number("report", report);
    allowed = arguments.number("allowed", allowed);
    results = arguments.text("results", results);
    arguments.finish();
    if ((bodies > 0) + (flexible > 0) + (contacts > 0) + (restarts > 0) != 1)
      throw SceneError("say which scene", "endurance", "give one of --bodies, --flexible, --contacts and --restarts");
    if (report <= 0) report = duration / 60;
    if (step <= 0) step = bodies > 0 ? 0.1 : contacts > 0 ? 5e-3 : 0.02;
  }
};

std::unique_ptr<Integrator> method_of(const Options& options) {
  if (options.bodies > 0)
    return std::make_unique<ExplicitRungeKutta>(ExplicitRungeKutta::Parameters{.step = options.step});
  if (options.contacts > 0) return std::make_unique<MoreauJean>(MoreauJean::Parameters{.step = options.step});
  return std::make_unique<GeneralizedAlpha>(GeneralizedAlpha::Parameters{.step = options.step, .spectral_radius = 0.9});
}

/// Lines of time, memory and another figure; the growth since the first of them.
class MemoryWatch {
 public:
  explicit MemoryWatch(const char* figure) : began_(bench::cpu_seconds()) {
    std::printf("%10s %10s %12s %12s %14s %16s\n", "t, s", "CPU, s", "resident, MB", "malloc, MB", "grown, MB", figure);
  }
  void report(double t, double figure) {
    const double memory = bench::resident_memory();
    if (settled_ == 0) settled_ = memory, since_ = t;
    grown_ = memory - settled_;
    std::printf("%10.6g %10.1f %12.2f %12.2f %14.3f %16.2e\n", t, bench::cpu_seconds() - began_, memory / kMegabyte,
                static_cast<double>(mallinfo2().uordblks) / kMegabyte, grown_ / kMegabyte, figure);
    std::fflush(stdout);
  }
  /// Throws where it has grown by more, MB.
  void finish(double allowed) const {
    std::printf("%s: resident memory grew by %.3f MB after t = %g s\n", grown_ <= allowed * kMegabyte ? "ok" : "GROWS",
                grown_ / kMegabyte, since_);
    if (grown_ > allowed * kMegabyte) throw std::runtime_error("memory grows");
  }

 private:
  double began_, settled_ = 0, since_ = 0, grown_ = 0;
};

/// One run.
void endure(const Options& options) {
  SystemGraph graph{{.gravity = {0, 0, options.bodies > 0 ? -1.62 : -9.81}}};
  std::vector<FlexibleBody*> rods;
  const Contact* contact = nullptr;
  if (options.bodies > 0)
    add_rigid_chains(graph, options.bodies);
  else if (options.contacts > 0)
    contact = &add_shaken_boxes(graph, options.contacts);
  else
    rods = add_flexible_pairs(graph, options.flexible, options.modes);
  const System system = assemble(graph);
  State state = system.initial_state();
  const auto integrator = method_of(options);
  Simulation simulation(system, *integrator);
  std::optional<ResultWriter> results;
  if (!rods.empty()) simulation.observe(results.emplace(*rods.front(), options.results + "/endurance.h5"), every(1.0));

  Snapshot now(system, state);
  const Sensor energy = total_energy(), kinetic = kinetic_energy();
  const std::optional<Sensor> depth = contact ? std::optional(penetration(*contact)) : std::nullopt;
  const double first_energy = energy.value(now);
  double moved = 0;
  const double settling = std::min(60.0, options.duration / 10);
  std::printf("%d bodies, step %g s, %s\n", static_cast<int>(graph.bodies().size()) - 1, options.step,
              integrator->name().c_str());
  MemoryWatch watch(contact ? "deepest, m" : "energy drift");
  for (double t = 0; options.duration - t > 1e-9;) {
    t = std::min(options.duration, t < settling ? settling : t + options.report);
    simulation.run(state, t);
    now.evaluate(state);
    moved = std::max(moved, kinetic.value(now));
    watch.report(t, depth ? depth->value(now) : (energy.value(now) - first_energy) / moved);
  }
  watch.finish(options.allowed);
}

/// Runs to `end` from a checkpoint, or from the start where there is none, and saves.
State leg(const Options& options, const std::string& from, const std::string& to, double end) {
  SystemGraph graph{{.gravity = {0, 0, -9.81}}};
  add_flexible_pairs(graph, 4, options.modes);
  const System system = assemble(graph);
  const auto integrator = method_of(options);
  Simulation simulation(system, *integrator);
  State state = from.empty() ? system.initial_state() : simulation.resume(from);
  simulation.run(state, end);
  simulation.save(state, to);
  return state;
}

/// The same run by two ways: at one go with as many stops, and resumed at each of them.
void restart(const Options& options) {
  const std::string file = options.results + "/endurance_checkpoint.h5";
  const auto time_of = [&](int i) { return options.duration * i / options.restarts; };
  SystemGraph graph{{.gravity = {0, 0, -9.81}}};
  add_flexible_pairs(graph, 4, options.modes);
  const System system = assemble(graph);
  const auto integrator = method_of(options);
  Simulation simulation(system, *integrator);
  State through = system.initial_state();
  MemoryWatch watch("off by");
  State resumed;
  const int settling = std::max(1, options.restarts / 10), lines = std::max(1, options.restarts / 60);
  for (int i = 1; i <= options.restarts; ++i) {
    simulation.run(through, time_of(i));
    resumed = leg(options, i == 1 ? "" : file, file, time_of(i));
    const double off =
        std::max((resumed.q - through.q).lpNorm<Eigen::Infinity>(), (resumed.v - through.v).lpNorm<Eigen::Infinity>());
    if (i == settling || (i > settling && i % lines == 0) || i == options.restarts) watch.report(time_of(i), off);
    if (off != 0) throw std::runtime_error("restart " + std::to_string(i) + " leaves the run that was not interrupted");
  }
  watch.finish(options.allowed);
}

void run(const Options& options) {
  const InterruptGuard guard;
  if (options.restarts > 0)
    restart(options);
  else
    endure(options);
}

}  // namespace
}  // namespace lithe::endurance

int main(int count, char** words) {
  return lithe::bench::run_program(count, words, [](lithe::bench::Arguments& arguments) {
    lithe::endurance::run(lithe::endurance::Options(arguments));
  });
}
