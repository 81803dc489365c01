// 27_ropes: a hoist. A motor drives a drum by a belt, and its rope lifts a load on a block of two parts.
//
// Shows: a rope from a drum over a pulley and under the block of a hook; a belt drive with friction on its wheels; the
//        tensions of spans as sensors; creep; a page.
// Expect: the hook rises by half of what the drum winds up, to 1 mm; the belt, tighter on one side by the torque over
//         the wheel's radius, loses about 1 % of its way by creep, and then holds the load without slipping;
//         results/ropes/hoist.html.
#include <cstdio>

#include "lithe/lithe.h"

using namespace lithe;

int main() {
  // 1. Motor, drum and hook. Axles point along -y: x to the right, z up, angles counter-clockwise.
  SystemGraph graph;
  auto& ground = graph.ground();
  const Matrix3 axle = rotation_about({1, 0, 0}, M_PI / 2);
  auto& motor = graph.add<RigidBody>("motor", {.mass = 20, .inertia = {0.1, 0.1, 0.1}, .position = {-1.2, 0, 0}});
  auto& drum = graph.add<RigidBody>("drum", {.mass = 200, .inertia = {10, 10, 10}});
  auto& hook = graph.add<RigidBody>("hook", {.mass = 1000, .inertia = {80, 80, 80}, .position = {3.45, 0, 1.7}});
  auto& motor_pin =
      graph.add<RevoluteJoint>("motor pin", at_world(ground, motor, {.point = {-1.2, 0, 0}, .axis = {0, -1, 0}}));
  auto& drum_pin = graph.add<RevoluteJoint>("drum pin", at_world(ground, drum, {.axis = {0, -1, 0}}));
  const double turns = 60;  // rad
  graph.add<CoordinateDrive>("drive", {motor_pin.angle()}, {.motion = smooth_step(0, turns, 0.5, 6.5)});

  // 2. The rope: from the drum clockwise over a pulley, counter-clockwise under the hook's, up to where it is tied.
  const double r_drum = 0.3;
  const Rope rope =
      reeve(graph, "rope", {{drum_pin.markers()[1], r_drum, -1}, {ground.marker({3.65, 0, 6})}},
            {.pulleys = {{ground.marker({3, 0, 6}, axle), 0.25, -1}, {hook.marker({0, 0, 0.3}, axle), 0.2, 1}},
             .axial_stiffness = 5e6,
             .axial_damping = 1e5,
             .mass_per_length = 1.2,
             .pretension = 4905});

  // 3. The belt: a wheel of 0.1 m on the motor, one of 0.4 m on the drum.
  const double r_motor = 0.1, r_wheel = 0.4, friction = 0.5, EA = 4e5;
  const Rope belt = reeve(
      graph, "belt", {},
      {.pulleys =
           {{.marker = motor_pin.markers()[0], .radius = r_motor, .friction = friction, .wheel = motor_pin.angle()},
            {.marker = drum_pin.markers()[0], .radius = r_wheel, .friction = friction, .wheel = drum_pin.angle()}},
       .axial_stiffness = EA,
       .axial_damping = 4e3,
       .mass_per_length = 0.5,
       .pretension = 4000});

  // 4. Hoist for six seconds, then hold.
  const System system = assemble(graph);
  State state = system.initial_state();
  const std::vector<Sensor> sensors{height(hook.marker(), "hook"), coordinate(drum_pin.angle(), "drum"),
                                    tension(rope, 0, "rope"), tension(belt, 0, "belt_slack"),
                                    tension(belt, 1, "belt_tight")};
  Recorder recorder(sensors);
  Run run(system, sensors, {.name = "hoist"});
  Automatic automatic{{.tolerance = {.relative = 1e-6, .absolute = 1e-6}}};
  Simulation simulation{system, automatic};
  simulation.observe(recorder, every(0.05));
  simulation.observe(run, every(0.05));
  simulation.run(state, 10);
  recorder.write_csv("results/ropes/hoist.csv");
  write_page({run}, "results/ropes/hoist.html", {.title = "A hoist: belt, drum, rope"});

  // 5. Check the answer. In the middle of the hoist tensions change little.
  const Table& table = recorder.table();
  const auto at = [&](const char* column, double t) {
    return table.column(column)[static_cast<std::size_t>(std::lround(t / 0.05))];
  };
  const double wound = r_drum * (at("drum", 10) - at("drum", 0.5)), rise = at("hook", 10) - at("hook", 0.5);
  std::printf("the drum winds up %.4f m, the hook rises by %.4f m\n", wound, rise);
  const double tight = at("belt_tight", 3.5), slack = at("belt_slack", 3.5);
  std::printf("belt: %.0f and %.0f N, ratio %.2f; its friction would allow %.2f on the motor's wheel\n", tight, slack,
              tight / slack, std::exp(friction * belt.wraps[0]));
  const double lost = 1 - (at("drum", 10) - at("drum", 0.5)) * r_wheel / (turns * r_motor);
  std::printf("creep: %.2f %% of the way; (T1 - T2)/EA is %.2f %%\n", 100 * lost, 100 * (tight - slack) / EA);
  const double drift = at("hook", 10) - at("hook", 9);
  std::printf("held: the hook moves by %.1e m in the last second\n", drift);
  return std::abs(rise - wound / 2) < 1e-3 && std::abs(lost - (tight - slack) / EA) < 5e-4 && std::abs(drift) < 1e-5
             ? 0
             : 1;
}
