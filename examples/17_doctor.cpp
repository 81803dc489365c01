// 17_doctor: a hoist whose rope is far stiffer than its run needs; the doctor says so, and tries what helps.
//
// Shows: diagnose(): why a run fails or creeps, which part is to blame, what to change; and the cure tried; the
// findings
//        on the page of a run.
// Expect: the rope is named with its frequency, sqrt(k/m) to a percent; an implicit method passes; the fixed scene is
//         sound; in results/doctor/hoist.html a click on the rope's name selects it.
#include <cmath>
#include <cstdio>

#include "lithe/lithe.h"

using namespace lithe;

namespace {

constexpr double kCrate = 20;  // kg

/// 1. A trolley on a rail carries a crate on a rope: a spring of `stiffness` N/m, with little damping.
StudyScene hoist(double stiffness) {
  return {
      .name = "hoist", .duration = 4, .draw = [stiffness](SystemGraph& graph) {
        auto& trolley = graph.add<RigidBody>("trolley", {.mass = 200, .inertia = {5, 5, 5}});
        auto& crate =
            graph.add<RigidBody>("crate", {.mass = kCrate, .inertia = {0.5, 0.5, 0.5}, .position = {0.6, 0, -1.8}});
        const Matrix3 along_x = rotation_about({0, 1, 0}, M_PI / 2);
        graph.add<PrismaticJoint>("rail",
                                  {graph.ground().marker({0, 0, 0}, along_x), trolley.marker({0, 0, 0}, along_x)});
        graph.add<SpringDamper>("rope", {trolley.marker(), crate.marker()}, {.stiffness = stiffness, .damping = 50});
        return std::vector<Sensor>{position(trolley.marker(), "trolley"), position(crate.marker(), "crate")};
      }};
}

StudyMethod runge_kutta() {
  return {"explicit Runge-Kutta 5(4)", StudyMethod::Setting::tolerance, [](double tolerance) {
            return std::make_unique<ExplicitRungeKutta>(
                ExplicitRungeKutta::Parameters{.tolerance = {.relative = tolerance, .absolute = tolerance}});
          }};
}

StudyMethod generalized_alpha() {
  return {"generalized-alpha", StudyMethod::Setting::step, [](double step) {
            return std::make_unique<GeneralizedAlpha>(
                GeneralizedAlpha::Parameters{.step = step, .form = GeneralizedAlpha::Form::stabilized_index2});
          }};
}

}  // namespace

int main() {
  // 2. Somebody gave the rope the stiffness of a steel block, and took an explicit method.
  const double stiffness = 2e9;
  const Diagnosis sick =
      diagnose(hoist(stiffness), runge_kutta(),
               {.setting = 1e-6, .try_cures = true, .others = {generalized_alpha()}, .time_limit = 2});
  std::printf("%s\n", sick.text().c_str());

  // 3. A rope of 2e4 N/m.
  const Diagnosis sound = diagnose(hoist(2e4), runge_kutta(), {.setting = 1e-6});
  std::printf("%s\n", sound.text().c_str());

  // 4. The method that helped, on a page with what was found.
  SystemGraph graph;
  const std::vector<Sensor> sensors = hoist(stiffness).draw(graph);
  const System system = assemble(graph);
  State state = system.initial_state();
  const auto integrator = generalized_alpha().make(1e-3);
  Simulation simulation{system, *integrator};
  Run run{system, sensors, {.name = "hoist"}};
  simulation.observe(run, every(0.02));
  simulation.run(state, 2);
  write_page(run, "results/doctor/hoist.html", {.findings = page_findings(sick)});

  // 5. Check the answer: the cause and the part first, with its frequency; the cure; no alarm when fixed. The rail lets
  //    the trolley give way along the rope's horizontal part alone.
  const double horizontal = 0.6 / std::hypot(0.6, 1.8);
  const double frequency = std::sqrt(stiffness * (1 / kCrate + horizontal * horizontal / 200));
  char told[32];
  std::snprintf(told, sizeof told, "%.3g rad/s", frequency);
  const bool named =
      !sick.findings.empty() && sick.findings[0].cause == Cause::stiff &&
      sick.findings[0].what.find("'rope' between 'trolley' and 'crate' rings at " + std::string(told)) == 0;
  return named && !sick.reached && sick.cures.size() == 1 && sick.cures[0].helped && sound.sound() && sound.reached ? 0
                                                                                                                    : 1;
}
