// 03_rigid_or_flexible: must the pendulum be flexible at all? Say what you want to know and how well; solve() answers.
//
// Shows: one scene, drawn once; solve() chooses the model for each precision and states how large the error is.
// Expect: results/rigid_or_flexible/ with a certificate for each precision of the tip, and charts: for 30 % a rigid
//         rod serves, for 1 % it must bend, for 0.1 % with geometric stiffening; true errors are below the stated.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>

#include "lithe/lithe.h"

using namespace lithe;

namespace {

constexpr int kModes = 16;  // to choose from
const std::string kData = std::string(LITHE_EXAMPLE_DATA) + "/pendulum/hex8i";
const std::string kFolder = "results/rigid_or_flexible/";

/// Distance of the tip from where nonlinear finite elements have it (a row a millisecond), every 10 ms.
std::vector<double> distances(const Table& tip, const Table& reference) {
  std::vector<double> out;
  for (int row = 0; row < tip.row_count(); ++row)
    out.push_back(std::hypot(tip.at(row, 1) - reference.at(10 * row, 1), tip.at(row, 2) - reference.at(10 * row, 2),
                             tip.at(row, 3) - reference.at(10 * row, 3)));
  return out;
}
double largest(const std::vector<double>& distances) { return *std::max_element(distances.begin(), distances.end()); }

}  // namespace

int main() {
  // 1. Draw the scene once, with a rod that may bend: so many modes to choose from, with what they do at second order.
  const FiniteElementModel model = read_calculix(kData + "/calculix/matrices");
  const std::vector<int> hinge = model.node_set("hinge");
  SystemGraph graph;
  auto& rod = graph.add<FlexibleBody>(
      "rod", {.basis = make_basis(model, HingeFrame{hinge}, kModes, {.deflection = Deflection::quadratic})});
  const Matrix3 along_y = rotation_about({1, 0, 0}, -M_PI / 2);
  graph.add<RevoluteJoint>("pin", {graph.ground().marker({0, 0.005, 0}, along_y), rod.average(hinge, along_y)});
  const Marker tip = rod.average(model.node_set("tip"));

  // 2. Say what you want to know, and how well.
  const Table reference = read_csv(kData + "/trajectory.csv");
  Chart motion{.title = "Rigid or flexible?", .x_label = "time (s)", .y_label = "tip z (m)"};
  Chart misses{.title = "Distance of the tip from nonlinear finite elements",
               .x_label = "time (s)",
               .y_label = "distance (m)",
               .log_y = true};
  bool good = true;
  double second_order = 0;  // m
  for (const double wanted : {30.0, 10.0, 1.0, 0.1}) {
    const Solution answer = solve(graph, 1.0, {want(position(tip, "tip"), percent(wanted))}, {.scene = "pendulum"});
    const Certificate& sheet = answer.certificate;
    const ChosenBody& chosen = sheet.bodies.front();
    const CertifiedQuantity& quantity = sheet.quantities.front();
    if (wanted == 1) std::printf("\n%s\n", sheet.text().c_str());

    // 3. The certificate says which model, and why; nonlinear finite elements say whether its error is true.
    const bool rigid = chosen.fidelity.modes.empty();
    const std::string name = short_number(wanted), used = model_text(chosen.fidelity, kModes);
    const std::vector<double> distance = distances(answer.samples, reference);
    std::printf("for %s %%: %s%s: %s\n", name.c_str(), rigid ? "" : "flexible, ", used.c_str(), chosen.why.c_str());
    std::printf("   error asked %.3f mm, stated %.3f mm, true %.3f mm; %.0f ms of CPU\n", 1e3 * quantity.bound,
                1e3 * quantity.error.total(), 1e3 * largest(distance), 1e3 * sheet.cost);
    good &= sheet.met() && largest(distance) < quantity.error.total() && (rigid ? wanted > 1 : wanted < 30);
    if (!chosen.deflection_effect.empty()) second_order = chosen.deflection_effect.front();

    sheet.write_json(kFolder + "certificate_" + name + ".json");
    write_chart(sheet.chart(), kFolder + "certificate_" + name);
    const std::string title = name + " %: " + used;
    const std::vector<double> times = answer.samples.column("t");
    motion.lines.push_back({.title = title, .x = times, .y = answer.samples.column("tip_z")});
    misses.lines.push_back(
        {.title = title, .x = {times.begin() + 1, times.end()}, .y = {distance.begin() + 1, distance.end()}});
  }

  // 4. Second order (stiffening) is what no number of linear modes brings, says the certificate. All of them do miss
  // it.
  Fidelity all{.modes = std::vector<int>(kModes)};
  std::iota(all.modes.begin(), all.modes.end(), 0);
  rod.set_fidelity(all);
  const System system = assemble(graph);
  State state = system.initial_state();
  Recorder recorder{{position(tip, "tip")}};
  Automatic integrator{{.tolerance = {1e-5, 1e-8}}};
  Simulation simulation{system, integrator};
  simulation.observe(recorder, every(0.01));
  simulation.run(state, 1.0);
  const double linear = largest(distances(recorder.table(), reference));
  std::printf("no number of linear modes brings %.2f mm of stiffening: all %d of them miss by %.2f mm\n",
              1e3 * second_order, kModes, 1e3 * linear);
  good &= linear > 8e-4 && std::abs(linear / second_order - 1) < 0.3;

  // 5. The answers beside each other.
  motion.lines.push_back({.title = "nonlinear finite elements",
                          .x = reference.column("t"),
                          .y = reference.column("z"),
                          .style = LineStyle::dashed});
  write_chart(motion, kFolder + "tip");
  write_chart(misses, kFolder + "error");
  std::printf("%s\n", good ? "the certificates tell the truth" : "NOT as the certificates say");
  return good ? 0 : 1;
}
