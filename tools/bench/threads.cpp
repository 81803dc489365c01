// threads: how much faster one scene is stepped by several threads than by one; generalized-alpha at a fixed step, time
// that passes, by turns. Beside it what the machine gives: the same scene on one thread, as many at once.
//
//   --scene chain|flexible  rods on ball joints; rods of nine modes on ball joints   --n 5000, 200  bodies
//   --threads 2   --dt 1e-3  step, s   --steps 100   --repeat 5  turns, the least time counts
#include <thread>

#include "bodies/flexible/flexible_body.h"
#include "joints/spherical_joint.h"
#include "tools/bench/scenes.h"

namespace lithe::bench {
namespace {

/// Rods of the pendulum's mesh in a row, each at the end of the one before.
void draw_flexible_chain(SystemGraph& graph, int count) {
  const FiniteElementModel model = rod_model();
  const std::vector<int>&hinge = model.node_set("hinge"), &tip = model.node_set("tip");
  const auto basis = make_basis(model, HingeFrame{hinge}, 9);
  const int first = hinge.front(), last = tip.front();
  const Vector3 along = model.nodes.col(model.node_index(last)) - model.nodes.col(model.node_index(first));
  Marker end = graph.ground().marker(model.nodes.col(model.node_index(first)));
  for (int i = 0; i < count; ++i) {
    const std::string number = std::to_string(i + 1);
    auto& rod = graph.add<FlexibleBody>("rod " + number, {.basis = basis, .position = i * along});
    graph.add<SphericalJoint>("joint " + number, {end, rod.node(first)});
    end = rod.node(last);
  }
}

/// One scene on so many threads; run() takes the same steps each time.
class Runner {
 public:
  Runner(const std::function<void(SystemGraph&)>& draw, int threads, double step, long steps)
      : graph_({.gravity = {0, 0, -9.81}}), system_(drawn(draw, threads)), step_(step), steps_(steps) {}

  State run() {
    Evaluator evaluator(system_);
    State state = system_.initial_state();
    GeneralizedAlpha integrator({.step = step_, .spectral_radius = 0.9, .newton_tolerance = 1e-9});
    integrator.start(evaluator, state);
    const double started = wall_seconds();
    for (long i = 1; i <= steps_; ++i) {
      const StepResult result = integrator.step(evaluator, state, step_ * static_cast<double>(i));
      if (!result.ok()) throw std::runtime_error(result.why);
    }
    least = std::min(least, wall_seconds() - started);
    return state;
  }

  double least = 1e30;  // s, of all runs

 private:
  System drawn(const std::function<void(SystemGraph&)>& draw, int threads) {
    draw(graph_);
    return assemble(graph_, {.threads = threads});
  }
  SystemGraph graph_;
  const System system_;
  double step_;
  long steps_;
};

}  // namespace
}  // namespace lithe::bench

int main(int argument_count, char** words) {
  using namespace lithe::bench;
  return run_program(argument_count, words, [](Arguments& arguments) {
    const std::string kind = arguments.text("scene", "chain");
    if (kind != "chain" && kind != "flexible")
      throw std::invalid_argument("no scene '" + kind + "'; known are chain, flexible");
    const int count = arguments.integer("n", kind == "chain" ? 5000 : 200), threads = arguments.integer("threads", 2);
    const double step = arguments.number("dt", 1e-3);
    const int steps = arguments.integer("steps", 100), repeats = arguments.integer("repeat", 5);
    arguments.finish();

    const auto draw = [&](lithe::SystemGraph& graph) {
      if (kind == "chain")
        draw_chain(graph, count, ChainJoint::spherical);
      else
        draw_flexible_chain(graph, count);
    };
    Runner alone(draw, 1, step, steps), shared(draw, threads, step, steps);
    std::vector<std::unique_ptr<Runner>> together;
    for (int i = 0; i < threads; ++i) together.push_back(std::make_unique<Runner>(draw, 1, step, steps));
    bool same = true;
    double at_once = 1e30;
    for (int i = 0; i < repeats; ++i) {
      const lithe::State a = alone.run(), b = shared.run();
      same = same && a.q == b.q && a.v == b.v && a.lambda == b.lambda;
      const double started = wall_seconds();
      std::vector<std::thread> others;
      for (const auto& one : together) others.emplace_back([&one] { one->run(); });
      for (std::thread& other : others) other.join();
      at_once = std::min(at_once, wall_seconds() - started);
    }
    JsonLine line;
    line.add("program", "threads").add("scene", kind).add("n", count).add("threads", threads);
    line.add("us_per_step_alone", 1e6 * alone.least / steps, 5)
        .add("us_per_step_shared", 1e6 * shared.least / steps, 5);
    line.add("times_faster", alone.least / shared.least, 4);
    line.add("times_by_machine", threads * alone.least / at_once, 4);
    line.add("same_bits", std::string(same ? "yes" : "no")).print();
  });
}
