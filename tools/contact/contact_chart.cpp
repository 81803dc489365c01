// Work against precision of rigid contact, on motions whose end is known: Bullet's stepper and the engine's by their
// steps, compliant surfaces with an adaptive method by their stiffness. Writes FOLDER/contact_MOTION.svg, .png, .csv.
//   contact_chart [--out FOLDER]
#include <algorithm>
#include <cstdio>
#include <limits>

#include "engine/assembly/evaluator.h"
#include "engine/motion/make_integrator.h"
#include "engine/output/chart.h"
#include "engine/output/csv.h"
#include "integrators/explicit_runge_kutta.h"
#include "integrators/moreau_jean.h"
#include "tools/bench/measure.h"
#include "tools/contact/bullet_stepper.h"
#include "tools/contact/known_motions.h"

using namespace lithe;
using namespace lithe::contact_bench;

namespace {

using Law = std::variant<Compliance, RigidSurfaces, Sensing>;

struct Sample {
  double setting, seconds = 0, error = 0;  // step, s, or stiffness, N/m; processor time; m
};

/// The cheapest of some runs of one motion.
Sample run(const KnownMotion& motion, const Law& law, const MakeIntegratorBy<const System&>& make, double setting) {
  SystemGraph graph({.gravity = {0, 0, -9.81}});
  motion.draw(graph, law);
  const System system = assemble(graph);
  Evaluator equations(system);
  Sample sample{setting, std::numeric_limits<double>::infinity()};
  double spent = 0;
  for (int repeat = 0; repeat < 5 && (repeat < 1 || spent < 1); ++repeat) {
    State state = system.initial_state();
    const auto integrator = make(system);
    integrator->start(equations, state);
    const double before = bench::cpu_seconds();
    while (state.time < motion.end)
      if (const auto result = integrator->step(equations, state, motion.end); !result.ok())
        throw std::runtime_error(motion.name + ", " + integrator->name() + ": " + result.why);
    const double seconds = bench::cpu_seconds() - before;
    spent += seconds;
    sample.seconds = std::min(sample.seconds, seconds);
    sample.error = motion.error(state);
  }
  return sample;
}

class Work {
 public:
  explicit Work(const KnownMotion& motion) : motion_(motion) {
    chart_ = {.title = motion.title,
              .x_label = "processor time, s",
              .y_label = "error, m",
              .lines = {},
              .log_x = true,
              .log_y = true};
  }
  void add(const std::string& title, const std::vector<double>& settings, const std::function<Sample(double)>& sample) {
    ChartLine line{.title = title, .x = {}, .y = {}, .style = LineStyle::marked};
    for (const double setting : settings) {
      const Sample s = sample(setting);
      std::printf("%-14s %-32s %8.2g  %10.3g s  %10.3g m\n", motion_.name.c_str(), title.c_str(), s.setting, s.seconds,
                  s.error);
      std::fflush(stdout);
      table_.add_row({static_cast<double>(chart_.lines.size()), s.setting, s.seconds, s.error});
      if (!(s.error < 10)) continue;  // it has left the scene
      line.x.push_back(s.seconds);
      line.y.push_back(std::max(s.error, 1e-15));
    }
    if (!line.x.empty()) chart_.lines.push_back(std::move(line));
  }
  void write(const std::string& folder) const {
    write_chart(chart_, folder + "/contact_" + motion_.name);
    write_csv(table_, folder + "/contact_" + motion_.name + ".csv");
  }

 private:
  const KnownMotion& motion_;
  Chart chart_;
  Table table_{.columns = {"line", "step in s or stiffness in N/m", "processor time in s", "error in m"}};
};

void draw(const KnownMotion& motion, const std::string& folder) {
  Work work(motion);
  const std::vector<double> steps{1.0 / 60, 1.0 / 120, 1.0 / 240, 1e-3, 3e-4, 1e-4, 3e-5};
  const RigidSurfaces rigid{.restitution = motion.restitution};
  work.add("Bullet, 10 sweeps, by step", steps, [&](double step) {
    return run(
        motion, rigid,
        [=](const System& system) -> std::unique_ptr<Integrator> {
          return std::make_unique<BulletStepper>(system, BulletStepper::Parameters{.step = step});
        },
        step);
  });
  work.add("Moreau-Jean, by step", steps, [&](double step) {
    return run(
        motion, rigid,
        [=](const System&) -> std::unique_ptr<Integrator> {
          return std::make_unique<MoreauJean>(MoreauJean::Parameters{.step = step});
        },
        step);
  });
  work.add("compliant, Runge-Kutta, by stiffness", {1e4, 1e5, 1e6, 1e7, 1e8}, [&](double stiffness) {
    const Compliance soft{
        .stiffness = stiffness, .exponent = 1.5, .restitution = motion.restitution > 0 ? motion.restitution : 0.05};
    return run(
        motion, soft,
        [](const System&) -> std::unique_ptr<Integrator> {
          return std::make_unique<ExplicitRungeKutta>(
              ExplicitRungeKutta::Parameters{.tolerance = {.relative = 1e-9, .absolute = 1e-10}});
        },
        stiffness);
  });
  work.write(folder);
}

}  // namespace

int main(int count, char** words) {
  return bench::run_program(count, words, [](bench::Arguments& arguments) {
    const std::string folder = arguments.text("out", "results/contact");
    arguments.finish();
    for (const KnownMotion& motion : known_motions()) draw(motion, folder);
  });
}
