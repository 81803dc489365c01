// 29_crane: a trolley runs out on a crane's boom with a load on reeved rope; the boom bends, the load swings.
//
// Shows: a joint that slides along a beam, friction in it; a rope from the tower over trolley and hook to the tip;
//        equilibrium of it all as a start; a page.
// Expect: the hook keeps its height while the trolley runs from 3 to 9 m, but for what the boom gives and the swing;
//         the tip sinks by 28 mm more, as a clamped beam does under that load; the load swings every 4.26 s;
//         results/crane/crane.html.
#include <cmath>
#include <cstdio>

#include "lithe/lithe.h"

using namespace lithe;

int main() {
  // 1. The boom: a steel tube of 12 m, held by the tower.
  const double length = 12, height_of_boom = 10, near_tower = 3, far = 9;  // m
  const Material steel{2.1e11, 0.3, 7850};
  SystemGraph graph;
  auto& ground = graph.ground();
  auto& boom = graph.add<Beam>(
      "boom", {.axis = BeamAxis::straight({0, 0, height_of_boom}, {length, 0, height_of_boom}, {0, 1, 0}),
               .sections = {{0, SectionShape::tube(0.22, 0.25).section(steel).damped(2e-3)}},
               .elements = 24});
  graph.add<FixedJoint>("tower", {ground.marker({0, 0, height_of_boom}, boom.axes(0)), boom.marker(0)});

  // 2. The trolley slides along it; wheels keep it upright, a drive moves it out.
  auto& trolley = graph.add<RigidBody>(
      "trolley", {.mass = 300, .inertia = {20, 20, 20}, .position = {near_tower, 0, height_of_boom - 0.2}});
  auto& runs = add_sliding_joint(graph, "runs", trolley.marker({0, 0, 0.2}), along(boom, 1, length));
  add_sliding_friction(graph, "rolling", runs, {.coefficient = 0.01, .creep_speed = 0.03});
  const Marker tower = ground.marker({0, 0, height_of_boom - 0.2});
  graph.add<OrientationJoint>("wheels", {tower, trolley.marker()});
  graph.add<CoordinateDrive>("drive", {displacement_between(tower, trolley.marker(), 0)},
                             {.motion = smooth_step(near_tower, far, 1, 7)});

  // 3. The rope: tower, over the trolley's first pulley, under the hook's, over the second, to the tip of the boom.
  const Matrix3 axle = rotation_about({1, 0, 0}, M_PI / 2);
  const double load = 2000, fall = 4.5;  // kg, m
  auto& hook = graph.add<RigidBody>(
      "hook", {.mass = load, .inertia = {300, 300, 300}, .position = {near_tower, 0, height_of_boom - 0.2 - fall}});
  const Rope rope =
      reeve(graph, "rope", {{ground.marker({0, 0, height_of_boom - 0.1})}, {boom.marker(length, {0, 0, -0.1})}},
            {.pulleys = {{trolley.marker({-0.4, 0, 0}, axle), 0.1, -1},
                         {hook.marker({0, 0, 0}, axle), 0.3, 1},
                         {trolley.marker({0.4, 0, 0}, axle), 0.1, -1}},
             .axial_stiffness = 1e7,
             .axial_damping = 1e5,
             .mass_per_length = 1,
             .pretension = 0.5 * load * 9.81});

  // 4. From rest, out, and four swings.
  const System system = assemble(graph);
  State state = find_equilibrium(system, system.initial_state()).state;
  const std::vector<Sensor> sensors{position(hook.marker(), "hook"), height(boom.marker(length), "tip"),
                                    place_on_rail(runs, "trolley"), tension(rope, 1, "rope")};
  Recorder recorder(sensors);
  Run run(system, sensors, {.name = "crane"});
  Radau radau({.tolerance = {1e-5, 1e-6}});
  Simulation simulation(system, radau);
  simulation.observe(recorder, every(0.02));
  simulation.observe(run, every(0.05));
  const double end = 24;
  simulation.run(state, end);
  recorder.write_csv("results/crane/crane.csv");
  write_page({run}, "results/crane/crane.html", {.title = "A crane: boom, trolley, rope"});

  // 5. Check the answer.
  const Table& table = recorder.table();
  const std::vector<double> t = table.column("t"), x = table.column("hook_x"), z = table.column("hook_z"),
                            tip = table.column("tip");
  double mean_tip = 0, lowest = z[0], highest = z[0];
  int counted = 0;
  std::vector<double> crossings;
  for (std::size_t i = 1; i < t.size(); ++i) {
    if (t[i] < 8) continue;
    mean_tip += tip[i], ++counted;
    lowest = std::min(lowest, z[i]), highest = std::max(highest, z[i]);
    if (x[i - 1] < far && x[i] >= far)
      crossings.push_back(t[i - 1] + (t[i] - t[i - 1]) * (far - x[i - 1]) / (x[i] - x[i - 1]));
  }
  mean_tip /= counted;
  const double period = (crossings.back() - crossings.front()) / static_cast<double>(crossings.size() - 1);
  // A clamped beam under what the trolley weighs with its load, and the rope's pull below the axis at the tip.
  const double EI = steel.young * M_PI / 4 * (std::pow(0.25, 4) - std::pow(0.22, 4)), weight = 9.81 * (load + 300);
  const auto dip = [&](double a) { return weight * a * a * (3 * length - a) / (6 * EI); };
  const double sunk = tip[0] - mean_tip, formula = dip(far) - dip(near_tower);
  const double pendulum = 2 * M_PI * std::sqrt(fall / 9.81);
  std::printf("trolley from %.1f to %.1f m: the hook is between %.3f and %.3f m high, before at %.3f m\n", near_tower,
              far, lowest, highest, z[0]);
  std::printf("the tip sinks by %.1f mm (clamped beam: %.1f mm)\n", 1e3 * sunk, 1e3 * formula);
  std::printf("the load swings every %.2f s (pendulum on the falls alone: %.2f s)\n", period, pendulum);
  return std::abs(sunk / formula - 1) < 0.02 && std::abs(period / pendulum - 1) < 0.02 && z[0] - lowest < 0.15 ? 0 : 1;
}
