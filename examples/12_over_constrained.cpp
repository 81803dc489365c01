// 12_over_constrained: a scissor lift of four stages, all of it spatial hinges, is spread by a slide at its foot.
//
// Shows: redundant rows are detected, reported and handled; the kinematic analysis does not mind them.
// Expect: the top follows height = stages · sqrt(L² - width²) to 1e-10 m; the drive's force is that of virtual work.
#include <cstdio>

#include "lithe/lithe.h"

using namespace lithe;

int main() {
  // 1. In each stage two bars cross; hinges turn about y. Left ends lie on x = 0, right ends on x = width.
  constexpr int kStages = 4;
  const double L = 1, mass = 2, width = 0.8, rise = std::sqrt(L * L - width * width), g = 9.81;
  SystemGraph graph{{.gravity = {0, 0, -g}}};
  const Matrix3 along_y = rotation_about({1, 0, 0}, -M_PI / 2), along_x = rotation_about({0, 1, 0}, M_PI / 2);
  std::vector<RigidBody*> up, down;  // bars from lower left to upper right, from lower right to upper left
  for (int i = 0; i < kStages; ++i) {
    const Vector3 centre(width / 2, 0, (i + 0.5) * rise);
    const auto bar = [&](const std::string& name, double slope) -> RigidBody* {
      return &graph.add<RigidBody>(name + std::to_string(i + 1),
                                   {.mass = mass,
                                    .inertia = {1e-3, mass * L * L / 12, mass * L * L / 12},
                                    .position = centre,
                                    .orientation = rotation_about({0, 1, 0}, -std::atan2(slope * rise, width))});
    };
    up.push_back(bar("up ", 1));
    down.push_back(bar("down ", -1));
  }
  // A hinge at the ends or centres (s: half lengths along the bar) of two bars; its axis is y for both.
  const auto hinge = [&](const std::string& name, RigidBody& a, double s_a, RigidBody& b, double s_b) {
    graph.add<RevoluteJoint>(name, {a.marker({s_a * L / 2, 0, 0}, along_y), b.marker({s_b * L / 2, 0, 0}, along_y)});
  };
  for (int i = 0; i < kStages; ++i) {
    const std::string stage = std::to_string(i + 1);
    hinge("cross " + stage, *up[i], 0, *down[i], 0);
    if (i + 1 == kStages) continue;
    hinge("right " + stage, *up[i], 1, *down[i + 1], 1);
    hinge("left " + stage, *down[i], -1, *up[i + 1], -1);
  }

  // 2. The foot: the left end is hinged to ground, the right end to a block on a slide, which a drive pulls in.
  auto& block = graph.add<RigidBody>("block", {.mass = 1, .inertia = {1e-3, 1e-3, 1e-3}, .position = {width, 0, 0}});
  graph.add<RevoluteJoint>("left foot",
                           {graph.ground().marker({0, 0, 0}, along_y), up[0]->marker({-L / 2, 0, 0}, along_y)});
  hinge("right foot", block, 0, *down[0], 1);
  auto& slide =
      graph.add<PrismaticJoint>("slide", {graph.ground().marker({0, 0, 0}, along_x), block.marker({0, 0, 0}, along_x)});
  auto& drive = graph.add<CoordinateDrive>("drive", {slide.displacement()}, {.motion = smooth_step(width, 0.4, 0, 2)});

  // 3. Assemble, and lift.
  const System system = assemble(graph);
  std::printf("%zu redundant rows, the first: %s repeats %s\n", system.redundant_rows().size(),
              system.redundant_rows()[0].name.c_str(), system.redundant_rows()[0].repeats.c_str());
  State state = system.initial_state();
  Recorder recorder{{position(up.back()->marker({L / 2, 0, 0}), "top"), coordinate(slide.displacement(), "width"),
                     drive_force(drive, "force"), drive_power(drive, "power"), total_energy("energy"),
                     constraint_residual("gap")}};
  Kinematics kinematics{{.step = 1e-2}};
  Simulation simulation{system, kinematics};
  simulation.observe(recorder, every(1e-2));
  simulation.run(state, 2.0);
  recorder.write_csv("results/over_constrained/lift.csv");
  const auto column = [&](const char* name) { return recorder.table().column(name); };
  const auto t = column("t"), top = column("top_z"), w = column("width"), power = column("power"),
             energy = column("energy"), gap = column("gap");
  write_chart({.title = "Scissor lift",
               .x_label = "time (s)",
               .y_label = "force of the drive (N)",
               .lines = {{.title = "force", .x = t, .y = column("force")}}},
              "results/over_constrained/force");

  // 4. Check the answer. At rest at the end: force · dw = weight · dh, h = stages / 2 · sqrt(L² - w²) of the centre.
  double off = 0, worst = 0, work = 0;
  for (std::size_t i = 0; i < t.size(); ++i) {
    off = std::max(off, std::abs(top[i] - kStages * std::sqrt(L * L - w[i] * w[i])));
    worst = std::max(worst, gap[i]);
    if (i > 0) work += (power[i] + power[i - 1]) / 2 * (t[i] - t[i - 1]);
  }
  const double end = w.back(), weight = 2 * kStages * mass * g;
  const double exact = -weight * kStages / 2 * end / std::sqrt(L * L - end * end);
  std::printf("top off by %.1e m, residual %.1e m; force at the end %.6f N, exact %.6f N; work %.3f J, energy %.3f J\n",
              off, worst, column("force").back(), exact, work, energy.back() - energy.front());
  return off < 1e-10 && worst < 1e-10 && std::abs(column("force").back() / exact - 1) < 1e-6 &&
                 std::abs(work - energy.back() + energy.front()) < 0.05
             ? 0
             : 1;
}
