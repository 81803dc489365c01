// 28_which_beam: a blade spins up; what must it be for the answer wanted: rigid, modes, or an exact beam?
//
// Shows: SlenderBody, one drawing at every fidelity; solve() chooses among them and the number of elements.
// Expect: results/which_beam/: the place of the tip to 10 % is a rigid blade's; the lag of the tip, a twentieth of the
//         length, takes exact elements, more for 1 % than for 5 %; true errors are below the stated.
#include <cmath>
#include <cstdio>
#include <ctime>

#include "lithe/lithe.h"

using namespace lithe;

namespace {

constexpr double kLength = 8, kSpeed = 6, kStart = 3, kEnd = 6;  // m, rad/s, s at speed, s

/// Smooth to full speed, then steady.
Motion turning(double t) {
  if (t >= kStart) return {kSpeed * (t - kStart / 2), kSpeed, 0};
  const double s = t / kStart;
  return {kSpeed * kStart * (s * s * s - s * s * s * s / 2), kSpeed * (3 - 2 * s) * s * s,
          kSpeed / kStart * 6 * (s - s * s)};
}

struct Rotor {
  SystemGraph graph;
  SlenderBody* blade = nullptr;
  std::vector<Sensor> sensors;  // lag, reach

  explicit Rotor(int elements) {
    // 1. An aluminium blade on a hub that a drive turns. Lag: how far the tip stays behind; reach: how far out it is.
    const Material aluminium{7e10, 0.3, 2700};
    const Beam::Parameters drawn{.axis = BeamAxis::straight({0, 0, 0}, {kLength, 0, 0}, {0, 1, 0}),
                                 .sections = {{0, BeamSection::rectangle(0.1, 0.2, aluminium).damped(1e-4)}},
                                 .elements = elements};
    auto& hub = graph.add<RigidBody>("hub", {.mass = 10});
    auto& bearing = graph.add<RevoluteJoint>("bearing", {graph.ground().marker(), hub.marker()});
    graph.add<CoordinateDrive>("drive", {bearing.angle()}, {.motion = turning});
    blade = &graph.add<SlenderBody>("blade", {.beam = drawn});
    graph.add<FixedJoint>("root", {hub.marker({0, 0, 0}, drawn.axis.pose(0).axes), blade->marker(0)});
    const Marker tip = blade->marker(kLength), straight = hub.marker({kLength, 0, 0});
    sensors = {coordinate(displacement_between(straight, tip, 1), "lag"), position(tip, "tip")};
  }
};

/// At one fidelity; `seconds`: of CPU.
Table run(const Fidelity& fidelity, int sensor, double tolerance, double* seconds = nullptr) {
  Rotor rotor(12);
  rotor.blade->set_fidelity(fidelity);
  const System system = assemble(rotor.graph);
  Recorder recorder{{rotor.sensors[sensor]}};
  Radau radau({.tolerance = {tolerance, 1e-3 * tolerance}});
  Simulation simulation(system, radau);
  simulation.observe(recorder, every(0.1));
  State state = system.initial_state();
  const std::clock_t begun = std::clock();
  simulation.run(state, kEnd);
  if (seconds) *seconds = static_cast<double>(std::clock() - begun) / CLOCKS_PER_SEC;
  return recorder.table();
}

/// With exact elements, so fine that two meshes tell what is left.
Table reference(int sensor) {
  Table samples[2];
  for (int i : {0, 1}) samples[i] = run({.deflection = Deflection::exact, .elements = 16 << i}, sensor, 1e-5);
  for (std::size_t k = 0; k < samples[1].values.size(); ++k)
    samples[1].values[k] += (samples[1].values[k] - samples[0].values[k]) / 3;
  return samples[1];
}

double largest_difference(const Table& a, const Table& b) {
  double most = 0;
  for (int row = 0; row < a.row_count(); ++row) {
    double squares = 0;
    for (int column = 1; column < static_cast<int>(a.columns.size()); ++column)
      squares += std::pow(a.at(row, column) - b.at(row, column), 2);
    most = std::max(most, std::sqrt(squares));
  }
  return most;
}

/// The error of the lag over the cost, for numbers of modes or elements.
ChartLine models(const std::string& title, const std::vector<Fidelity>& fidelities, const Table& truth) {
  ChartLine line{.title = title, .x = {}, .y = {}, .style = LineStyle::marked};
  for (const Fidelity& fidelity : fidelities) {
    double seconds = 0;
    const double off = largest_difference(run(fidelity, 0, 1e-4, &seconds), truth);
    line.x.push_back(seconds), line.y.push_back(off);
    std::printf("  %-32s off by %7.2f mm, %6.0f ms\n", model_text(fidelity, 12).c_str(), 1e3 * off, 1e3 * seconds);
  }
  return line;
}

std::vector<Fidelity> first_modes(Deflection deflection) {
  std::vector<Fidelity> out;
  for (int count : {1, 3, 6, 12}) {
    out.push_back({.deflection = deflection});
    for (int k = 0; k < count; ++k) out.back().modes.push_back(k);
  }
  return out;
}

}  // namespace

int main() {
  // 2. The same question, more and more precise.
  struct Asked {
    int sensor;
    double percent;
  };
  const Table truth[] = {reference(0), reference(1)};
  Chart lag{.title = "Lag of the tip", .x_label = "time (s)", .y_label = "lag (m)"};
  bool good = true;
  for (const auto& [sensor, wanted] : {Asked{1, 10}, Asked{0, 5}, Asked{0, 1}}) {
    Rotor rotor(12);
    const Solution answer =
        solve(rotor.graph, kEnd, {want(rotor.sensors[sensor], percent(wanted))}, {.samples = 60, .scene = "blade"});

    // 3. The certificate says which model, and the graph is left with it.
    const Certificate& sheet = answer.certificate;
    const CertifiedQuantity& quantity = sheet.quantities.front();
    const std::string model = model_text(rotor.blade->fidelity(), 12);
    const double off = largest_difference(answer.samples, truth[sensor]);
    std::printf("%s to %g %%: %s; error asked %.1f mm, stated %.2f mm, true %.2f mm\n", quantity.name.c_str(), wanted,
                model.c_str(), 1e3 * quantity.bound, 1e3 * quantity.error.total(), 1e3 * off);
    good &= sheet.met() && off < quantity.error.total();
    if (sensor == 1) good &= rotor.blade->fidelity() == Fidelity{};
    if (sensor == 0) good &= rotor.blade->beam() != nullptr;
    sheet.write_json("results/which_beam/" + quantity.name + "_" + short_number(wanted) + ".json");
    if (sensor == 0)
      lag.lines.push_back({.title = short_number(wanted) + " %: " + model,
                           .x = answer.samples.column("t"),
                           .y = answer.samples.column("lag")});
    if (wanted == 1) std::printf("\n%s\n", sheet.text().c_str());
  }
  lag.lines.push_back({.title = "much finer elements",
                       .x = truth[0].column("t"),
                       .y = truth[0].column("lag"),
                       .style = LineStyle::dashed});
  write_chart(lag, "results/which_beam/lag");

  // 4. All models by hand, error over cost: where a line lies flat, more modes do not help.
  std::vector<Fidelity> exact;
  for (int elements : {4, 8, 16}) exact.push_back({.deflection = Deflection::exact, .elements = elements});
  write_chart(
      {.title = "A blade that spins up: models",
       .x_label = "CPU time (s)",
       .y_label = "error of the lag (m)",
       .lines = {models("rigid", {{}}, truth[0]), models("linear modes", first_modes(Deflection::linear), truth[0]),
                 models("stiffened modes", first_modes(Deflection::stiffened), truth[0]),
                 models("exact elements", exact, truth[0])},
       .log_x = true,
       .log_y = true},
      "results/which_beam/models");
  std::printf("%s\n", good ? "the certificates tell the truth" : "NOT as the certificates say");
  return good ? 0 : 1;
}
