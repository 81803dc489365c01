#include "examples/support/machine_report.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <sstream>

#include "examples/support/energy_account.h"

namespace machine {

using namespace lithe;

namespace {

constexpr double kMostMegabytes = 3;  // of a page

double cpu_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

struct Pass {
  Table table;
  EnergyAccount::Sum energy;
  IntegratorStatistics statistics;
  double cost;  // s of CPU, records and account included
};

Pass pass(SystemGraph& graph, const System& system, const Machine& machine, Integrator& integrator, double duration,
          Run* page) {
  for (Input* input : graph.inputs()) input->reset();
  State state = machine.start ? machine.start(system) : system.initial_state();
  Recorder recorder(machine.sensors);
  EnergyAccount account(graph, machine.powers);
  Simulation simulation(system, integrator);
  if (machine.prepare) machine.prepare(simulation);
  simulation.observe(recorder, every(machine.interval));
  simulation.observe(account, every_step());
  if (page) simulation.observe(*page, every(machine.interval));
  const double begun = cpu_seconds();
  simulation.run(state, duration);
  const double cost = cpu_seconds() - begun;
  if (page) page->add(simulation.events());
  return {recorder.table(), account.sum(), simulation.statistics(), cost};
}

/// The largest of two tables of the same sensors, in parts of the largest change of each in the first one; the second
/// may be shorter.
struct Difference {
  double share = 0;
  std::string sensor = "none";
};
Difference difference(const std::vector<Sensor>& sensors, const Table& a, const Table& b) {
  Difference most;
  const int width = static_cast<int>(a.columns.size()), rows = b.row_count();
  using Rows = Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>;
  const Rows x(a.values.data(), a.row_count(), width), y(b.values.data(), rows, width);
  int column = 1;
  for (const Sensor& sensor : sensors) {
    const int columns = static_cast<int>(sensor.columns().size());
    const auto of_a = x.middleCols(column, columns), of_b = y.middleCols(column, columns);
    const double change = (of_a.rowwise() - of_a.row(0)).rowwise().norm().maxCoeff();
    const double share = (of_b - of_a.topRows(rows)).rowwise().norm().maxCoeff() / change;
    if (!(share <= most.share)) most = {share, sensor.name()};
    column += columns;
  }
  return most;
}

/// How the scene deforms, "24 modes, 60 beam elements".
std::string deformation(const SystemGraph& graph) {
  int modes = 0, elements = 0;
  for (const SystemGraph::BodyEntry& entry : graph.bodies()) {
    const auto* slender = dynamic_cast<const SlenderBody*>(entry.body);
    const auto* beam = slender ? slender->beam() : dynamic_cast<const Beam*>(entry.body);
    const auto* flexible = slender ? slender->flexible() : dynamic_cast<const FlexibleBody*>(entry.body);
    if (beam) elements += beam->element_count();
    if (flexible) modes += flexible->mode_count();
  }
  std::string text = modes ? std::to_string(modes) + " modes" : "";
  if (elements) text += (modes ? ", " : "") + std::to_string(elements) + " beam elements";
  return text.empty() ? "rigid" : text;
}

/// What solve() says that the machine may leave out, in a line; `met`: it states errors within what is wanted.
std::string left_out(SystemGraph& graph, const Machine& machine, bool& met) {
  for (Input* input : graph.inputs()) input->reset();
  const Certificate sheet =
      solve(graph, machine.solve_duration, machine.wants, {.scene = machine.name, .small_deflection = true})
          .certificate;
  met = sheet.met();
  std::ostringstream text;
  for (std::size_t i = 0; i < machine.wants.size(); ++i) {
    const CertifiedQuantity& quantity = sheet.quantities[i];
    text << (i ? ", " : "") << quantity.name << " to " << short_number(quantity.bound) << " (stated "
         << short_number(quantity.error.total()) << ")";
  }
  for (const ChosenBody& body : sheet.bodies)
    text << "; " << body.name << ": " << model_text(body.fidelity, static_cast<int>(body.modes.size()));
  for (const std::string& line : sheet.simplification) text << "; " << line.substr(0, line.find_last_not_of('.') + 1);
  return text.str();
}

}  // namespace

Outcome run(SystemGraph& graph, const Machine& machine) {
  const std::string page_path = "results/machines/" + machine.name + ".html", bends = deformation(graph);
  const System system = assemble(graph);
  Run page(system, machine.sensors, {.name = machine.name, .coordinates = false});
  if (machine.draw) machine.draw(page);
  Automatic automatic({.tolerance = machine.tolerance});
  const Pass first = pass(graph, system, machine, automatic, machine.duration, &page);
  write_page(page, page_path, {.title = machine.title});
  const double size = 1e-6 * static_cast<double>(std::filesystem::file_size(page_path));

  const std::unique_ptr<Integrator> other =
      machine.second ? machine.second(machine.tolerance)
                     : std::make_unique<Radau>(Radau::Parameters{.tolerance = machine.tolerance});
  const double compared = machine.compared > 0 ? machine.compared : machine.duration;
  const Pass second = pass(graph, system, machine, *other, compared, nullptr);
  const Difference apart = difference(machine.sensors, first.table, second.table);

  const double missing = first.energy.missing(), cost = first.cost / machine.duration;
  // Without the ground, and without what is a coordinate alone: integrals, the travel of ropes.
  const auto bodies = std::count_if(graph.bodies().begin() + 1, graph.bodies().end(),
                                    [](const auto& entry) { return !dynamic_cast<const PlacelessBody*>(entry.body); });
  const int freedoms = system.degrees_of_freedom();
  std::printf("%s: %td bodies, %d degrees of freedom, %s; %.4g s\n", machine.title.c_str(), bodies, freedoms,
              bends.c_str(), machine.duration);
  std::printf("automatic, tolerance %.0e: %ld steps, %.3g s of CPU a simulated second, %.3g times real time\n",
              machine.tolerance.relative, first.statistics.steps, cost, 1 / cost);
  std::printf("energy: change %.6g J, work %.6g J, missing %.1e of %.4g J turned over\n", first.energy.change,
              first.energy.work, missing, first.energy.turned_over);
  std::printf("%s, %.3g s: %ld steps, differs by %.1e of its change (%s), energy missing %.1e\n", other->name().c_str(),
              compared, second.statistics.steps, apart.share, apart.sensor.c_str(), second.energy.missing());
  std::printf("page: %s, %.2f MB\n", page_path.c_str(), size);
  bool met = true;
  std::string may_leave = "no body has models to choose from";
  if (!machine.wants.empty()) may_leave = left_out(graph, machine, met);
  std::printf("solve(): %s\n", may_leave.c_str());
  std::printf("| `%s` | %td | %d | %s | %.0e | %.3g | %.3g | %.0e | %.0e |\n", machine.name.c_str(), bodies, freedoms,
              bends.c_str(), machine.tolerance.relative, cost, 1 / cost, missing, apart.share);
  return {first.table, met && missing < machine.balance && second.energy.missing() < machine.balance &&
                           apart.share < machine.agreement && size < kMostMegabytes};
}

Sensor angular_momentum(const SystemGraph& graph) {
  return {"angular momentum",
          {"angular_momentum"},
          [&graph](Snapshot& now, std::span<double> out) {
            Vector3 sum = Vector3::Zero();
            for (const SystemGraph::BodyEntry& entry : graph.bodies()) {
              const BodyState state = now.body_state(*entry.body);
              if (const auto* flexible = dynamic_cast<const FlexibleBody*>(entry.body))
                sum += flexible->angular_momentum(state);
              if (const auto* rigid = dynamic_cast<const RigidBody*>(entry.body)) {
                const Eigen::Map<const Vector3> p(state.q), v(state.v), spin(state.v + 3);
                const Matrix3 axes = rotation_matrix(Eigen::Map<const Vector4>(state.q + 3));
                sum += rigid->parameters().mass * p.cross(v) + axes * (rigid->parameters().inertia.matrix * spin);
              }
            }
            out[0] = sum.norm();
          },
          {"N m s"}};
}

double at(const Table& table, const std::string& column, double time) {
  const std::vector<double> t = table.column("t"), x = table.column(column);
  const auto place = std::lower_bound(t.begin(), t.end(), time - 1e-9);
  if (place == t.end())
    throw SceneError("no sample at " + short_number(time) + " s", column, "ask for a time of the run");
  return x[static_cast<std::size_t>(place - t.begin())];
}

}  // namespace machine
