// 16_events: a ball bounces along a table, rolls over its edge and drops onto a buffer on the floor.
//
// Shows: events that are recorded, that change the state (an impact) or that end the run; stops are met without asking.
// Expect: impacts at the times of the closed form to 1e-12 s, the edge at its time, the rebound of the buffer's law.
#include <cmath>
#include <cstdio>

#include "lithe/lithe.h"

using namespace lithe;

int main() {
  // 1. A ball 0.5 m above a table, thrown along it. Below the table's edge stands a buffer: a stop for its height.
  const double g = 9.81, drop = 0.5, along = 1.2, edge = 2, floor = -0.7, restitution = 0.7;
  SystemGraph graph{{.gravity = {0, 0, -g}}};
  auto& ball = graph.add<RigidBody>(
      "ball", {.mass = 0.2, .inertia = {1e-5, 1e-5, 1e-5}, .position = {0, 0, drop}, .velocity = {along, 0, 0}});
  const JointCoordinate above = displacement_between(graph.ground().marker(), ball.marker());
  graph.add<CoordinateStop>("buffer", {above}, {.lower = floor, .stiffness = 2e4, .exponent = 1});

  const System system = assemble(graph);
  State state = system.initial_state();
  ExplicitRungeKutta integrator{{.tolerance = {.relative = 1e-10, .absolute = 1e-10}}};
  Simulation simulation{system, integrator};

  // 2. What may happen. An impact keeps the velocity along the table and turns a part of the other back; the height at
  //    the top of each flight is recorded; past the edge the run stops.
  simulation.on({.name = "impact",
                 .function = watch(height(ball.marker())),
                 .direction = Event::Direction::falling,
                 .action = Event::Action::restart,
                 .change = [restitution, edge](State& now) {
                   if (now.q[0] < edge) now.v[2] *= -restitution;
                 }});
  simulation.on({.name = "top", .function = watch(velocity(ball.marker()), 2), .direction = Event::Direction::falling});
  simulation.on(
      {.name = "edge", .function = watch(position(ball.marker())), .level = edge, .action = Event::Action::stop});
  Recorder path{{position(ball.marker(), "ball")}};
  simulation.observe(path, every(0.005));
  simulation.run(state, 10);
  std::printf("the run ended with '%s' at %.12f s\n", simulation.stopped_by().c_str(), state.time);
  const double at_edge = state.time, height_there = state.q[2], rise = state.v[2];

  // 3. On, over the edge: the next run goes on where the last one stopped. The buffer is met and left within its own
  //    steps; its spring gives all energy back.
  const double fall = (rise + std::sqrt(rise * rise + 2 * g * (height_there - floor))) / g;
  simulation.run(state, at_edge + fall + 0.1);
  path.write_csv("results/events/path.csv");
  write_chart({.title = "A ball on a table, and beyond",
               .x_label = "x (m)",
               .y_label = "height (m)",
               .lines = {{.title = "ball", .x = path.table().column("ball_x"), .y = path.table().column("ball_z")}}},
              "results/events/path");

  // 4. Check the answer: impacts at t0 (1 + 2 e + 2 e² + …), t0 = sqrt(2 h/g); the edge at its distance; the energy.
  double expected = std::sqrt(2 * drop / g), flight = 2 * restitution * expected, worst = 0;
  int impacts = 0, tops = 0;
  for (const EventRecord& event : simulation.events()) {
    if (event.name == "top") ++tops;
    if (event.name != "impact" || event.time > at_edge) continue;
    worst = std::max(worst, std::abs(event.time - expected));
    expected += flight;
    flight *= restitution;
    ++impacts;
  }
  const double energy_at_edge = 0.5 * rise * rise + g * height_there;
  const double energy = 0.5 * state.v[2] * state.v[2] + g * state.q[2];
  std::printf("%d impacts, off by %.1e s; %d tops; edge off by %.1e s; energy after the buffer off by %.1e J/kg\n",
              impacts, worst, tops, std::abs(at_edge - edge / along), std::abs(energy - energy_at_edge));
  return impacts == 7 && worst < 1e-12 && std::abs(at_edge - edge / along) < 1e-12 && state.v[2] > 0 &&
                 std::abs(energy - energy_at_edge) < 1e-7
             ? 0
             : 1;
}
