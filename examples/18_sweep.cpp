// 18_sweep: the same pendulum many times over, with other parameters, on all processors.
//
// Shows: sweep() runs a scene at every point of a grid or of a random sample; results come as a table in the order of
//        the points, the same to the last bit for any number of threads, and under mpirun for any number of ranks.
// Expect: results/sweep/rod.svg/.png/.csv: how far a rod bends as it swings, over release angle and stiffness;
//         results/sweep/tolerance.csv: how a workshop's pendulums scatter.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>

#include "lithe/lithe.h"

using namespace lithe;

namespace {

const std::string kRod = std::string(LITHE_EXAMPLE_DATA) + "/pendulum/hex8i/";
const Matrix3 kAlongY = rotation_about({1, 0, 0}, -M_PI / 2);  // hinges turn about the z axes of their markers
constexpr double kGravity = 9.81;

/// Released at rest at `angle`, the pendulum has swung through once its hinge has turned by as much: a quarter period.
double period(const System& system, const RevoluteJoint& pin, double angle, Recorder* watched = nullptr) {
  State state = system.initial_state();
  ExplicitRungeKutta integrator{
      {.method = ExplicitRungeKutta::Method::dormand_prince8, .tolerance = {.relative = 1e-9, .absolute = 1e-9}}};
  Simulation simulation{system, integrator};
  simulation.on({.name = "through",
                 .function = watch(coordinate(pin.angle(), "angle")),
                 .level = angle,
                 .action = Event::Action::stop});
  if (watched) simulation.observe(*watched, every(1e-3));
  simulation.run(state, 5);
  if (simulation.stopped_by().empty()) throw SimulationError("it does not swing through", "period", "");
  return 4 * state.time;
}

/// Where the tip is, in the axes of the body's frame.
Vector3 seen_from(Snapshot& now, const Marker& frame, const Marker& tip) {
  return now.marker(frame).R.transpose() * (now.marker(tip).p - now.marker(frame).p);
}

/// Rest to rest and back, from a given angle: 4 K(sin(angle/2)) sqrt(I / (m g d)).
double exact_period(double angle, double inertia, double mass, double centre) {
  return 4 * std::comp_ellint_1(std::sin(angle / 2)) * std::sqrt(inertia / (mass * kGravity * centre));
}

}  // namespace

int main() {
  // 1. The scene as a function of its parameters: the rod of example 02, its stiffness multiplied, released at an angle
  //    from the vertical. Each call draws a graph of its own and reduces a model of its own; all share the one that was
  //    read before and does not change.
  const FiniteElementModel soft = read_calculix(kRod + "calculix/matrices");
  const double mass = 0.26, inertia = 8.861666666666667e-4;  // kg, kg m² about the hinge
  const double centre = std::hypot(0.05, 0.0075);            // m, of mass, from the hinge
  const double rise = std::atan2(0.0075, 0.05);              // of the line to it, over the rod's lower edge
  const SweepScene swing = [&](const SweepPoint& point) -> SweepValues {
    FiniteElementModel model = soft;
    model.stiffness *= point["stiffness"];
    const std::vector<int>& edge = model.node_set("hinge");
    const double angle = point["angle"];
    const Matrix3 released = rotation_about({0, 1, 0}, M_PI / 2 - angle + rise);
    SystemGraph graph{{.gravity = {0, 0, -kGravity}}};
    auto& rod =
        graph.add<FlexibleBody>("rod", {.basis = make_basis(model, HingeFrame{edge}, 3), .orientation = released});
    auto& pin = graph.add<RevoluteJoint>(
        "pin", {graph.ground().marker({0, 0.005, 0}, released * kAlongY), rod.average(edge, kAlongY)});
    const Marker tip = rod.node(model.node_set("tip").front()), frame = rod.frame();
    const System system = assemble(graph);
    Snapshot first{system, system.initial_state()};
    const Vector3 straight = seen_from(first, frame, tip);
    Recorder bend{{Sensor{"bend", {"bend"}, [&](Snapshot& now, std::span<double> out) {
                            out[0] = (seen_from(now, frame, tip) - straight).norm();
                          }}}};
    const double seconds = period(system, pin, angle, &bend);
    return {{"period", seconds}, {"bend", std::ranges::max(bend.table().column("bend"))}};
  };

  // 2. All combinations of two parameters, on all processors; then on one thread, which must not matter.
  const std::vector<double> stiffness{1, 10, 100}, angles = evenly_spaced(0.1, 3.0, 30);
  const Table points = grid({{"stiffness", stiffness}, {"angle", angles}});
  const auto timed = [&](int threads, SweepResult& result) {
    const auto begun = std::chrono::steady_clock::now();
    result = sweep(swing, points, {.threads = threads});
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  };
  SweepResult result, alone;
  const double together = timed(0, result), serial = timed(1, alone);
  const bool same = result.failures.empty() && result.table.values == alone.table.values;
  result.write_csv("results/sweep/rod.csv");

  // 3. A line a stiffness. Under mpirun all ranks have the table; rank 0 alone writes and prints.
  const std::vector<double> seconds = result.table.column("period"), bend = result.table.column("bend");
  Chart chart{.title = "A swinging rod bends", .x_label = "release angle (rad)", .y_label = "tip's largest way (m)"};
  chart.log_y = true;
  std::vector<double> slower, bends;  // a stiffness: on average, what softness adds to the rigid rod's period; m
  std::size_t row = 0;
  for (const double factor : stiffness) {
    ChartLine line{.title = "stiffness x " + short_number(factor), .x = angles};
    double added = 0;
    for (const double angle : angles) {
      line.y.push_back(bend[row]);
      added += seconds[row++] / exact_period(angle, inertia, mass, centre) - 1;
    }
    slower.push_back(added / static_cast<double>(angles.size()));
    bends.push_back(std::ranges::max(line.y));
    chart.lines.push_back(line);
  }
  if (result.rank == 0) write_chart(chart, "results/sweep/rod");

  // 4. A random sample instead of a grid: slender rods, 1 m long to 2 %, whose pin sits up to 5 mm off their end. A
  //    point that cannot be drawn or run would be told, and the others kept.
  const SweepScene workshop = [](const SweepPoint& point) -> SweepValues {
    const double length = point["length"], arm = length / 2 - point["offset"], turning = length * length / 12;
    SystemGraph graph{{.gravity = {0, 0, -kGravity}}};
    const Matrix3 released = rotation_about({0, 1, 0}, M_PI / 2 - 0.1);
    auto& rod = graph.add<RigidBody>("rod", {.mass = 1,
                                             .inertia = {1e-4, turning, turning},
                                             .position = released * Vector3(arm, 0, 0),
                                             .orientation = released});
    auto& pin = graph.add<RevoluteJoint>(
        "pin", {graph.ground().marker({0, 0, 0}, released * kAlongY), rod.marker({-arm, 0, 0}, kAlongY)});
    const System system = assemble(graph);
    const double exact = exact_period(0.1, turning + arm * arm, 1, arm);
    const double seconds_a_swing = period(system, pin, 0.1);
    return {{"period", seconds_a_swing}, {"error", seconds_a_swing / exact - 1}};
  };
  const SweepResult sample =
      sweep(workshop, latin_hypercube({{"length", 0.98, 1.02}, {"offset", 0, 0.005}}, 200, /*seed=*/1));
  sample.write_csv("results/sweep/tolerance.csv");
  double mean = 0, squares = 0, off = 0;
  for (const double value : sample.table.column("period")) mean += value / sample.table.row_count();
  for (const double value : sample.table.column("period")) squares += (value - mean) * (value - mean);
  for (const double value : sample.table.column("error")) off = std::max(off, std::abs(value));
  const double scatter = std::sqrt(squares / sample.table.row_count());

  // 5. Check the answer: bending, and what it adds to the exact period of the rigid rod, go with 1 / stiffness; the
  //    workshop's periods are exact, and scatter as sqrt(length) does, uniform over +-2 %: by 0.02 / sqrt(3) / 2 of the
  //    mean (the pin's seat hardly counts: inertia and arm shrink together).
  const double expected = 0.02 / std::sqrt(3.0) / 2 * mean;
  if (result.rank == 0) {
    std::printf("%s%s", result.report().c_str(), sample.report().c_str());
    std::printf("%d points in %.2f s, on one thread in %.2f s: %s\n", result.table.row_count(), together, serial,
                same ? "the same bits" : "DIFFERENT");
    std::printf("slower than rigid by %.1e, %.1e, %.1e; bends %.2e, %.2e, %.2e m\n", slower[0], slower[1], slower[2],
                bends[0], bends[1], bends[2]);
    std::printf("workshop: %.4f +- %.4f s, expected scatter %.4f s; each off by at most %.1e\n", mean, scatter,
                expected, off);
    std::printf("across processes: mpirun -n 2 build/release/examples/18_sweep\n");
  }
  bool sound = same && sample.failures.empty() && off < 1e-8 && std::abs(scatter / expected - 1) < 0.05;
  for (const std::vector<double>& softness : {slower, bends})
    for (int i = 0; i < 2; ++i) sound = sound && std::abs(softness[i] / softness[i + 1] - 10) < 0.5;
  return sound ? 0 : 1;
}
