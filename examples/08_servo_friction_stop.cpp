// 08_servo_friction_stop: an arm with dry friction in its bearing is lifted by a PID servo; its twin falls onto a stop.
//
// Shows: friction driven by the joint's own reaction, a controller with memory, the end of a joint's travel.
// Expect: the servo reaches 1 rad in spite of gravity and friction; the arm without one ends on its stop at -0.5 rad.
#include <cstdio>

#include "lithe/lithe.h"

using namespace lithe;

int main() {
  // 1. An arm of 0.5 m on a horizontal axis (world y); its angle grows upwards.
  SystemGraph graph;
  auto& arm = graph.add<RigidBody>("arm", {.mass = 2, .inertia = {1e-3, 0.042, 0.042}, .position = {0.25, 0, 0}});
  const Matrix3 axis =
      rotation_about({1, 0, 0}, M_PI / 2);  // z of the markers along -y: right-handed turns lift the arm
  auto& pin =
      graph.add<RevoluteJoint>("pin", {graph.ground().marker({0, 0, 0}, axis), arm.marker({-0.25, 0, 0}, axis)});

  // 2. Friction by the pin's reaction, a servo, a stop.
  graph.add<JointFriction>("rub", {pin.angle()},
                           {.joint = &pin, .coefficient = 0.2, .static_coefficient = 0.25, .radius = 0.02});
  auto& memory = graph.add<IntegralState>("memory");
  auto& servo = graph.add<PidController>(
      "servo", {pin.angle(), memory.coordinate()},
      {.target = smooth_step(0, 1, 0, 1), .proportional = 60, .integral = 80, .derivative = 8, .limit = 15});
  auto& stop = graph.add<CoordinateStop>("stop", {pin.angle()}, {.lower = -0.5, .stiffness = 5e4, .dissipation = 2});

  const System system = assemble(graph);
  State state = system.initial_state();
  Recorder recorder{
      {coordinate(pin.angle(), "angle"), power(servo, "servo"), applied_force(stop, 1, kWorldAxes, "stop")}};
  GeneralizedAlpha integrator{{.step = 1e-3, .spectral_radius = 0.6}};
  Simulation simulation{system, integrator};
  simulation.observe(recorder, every(0.01));
  simulation.run(state, 6.0);
  const double reached = recorder.table().column("angle").back();

  // 3. The same arm without a servo.
  SystemGraph loose;
  auto& same = loose.add<RigidBody>("arm", {.mass = 2, .inertia = {1e-3, 0.042, 0.042}, .position = {0.25, 0, 0}});
  auto& hinge =
      loose.add<RevoluteJoint>("pin", {loose.ground().marker({0, 0, 0}, axis), same.marker({-0.25, 0, 0}, axis)});
  loose.add<JointFriction>("rub", {hinge.angle()},
                           {.joint = &hinge, .coefficient = 0.2, .static_coefficient = 0.25, .radius = 0.02});
  auto& end = loose.add<CoordinateStop>("stop", {hinge.angle()}, {.lower = -0.5, .stiffness = 5e4, .dissipation = 2});
  const System fallen = assemble(loose);
  State lying = fallen.initial_state();
  Recorder fall{{coordinate(hinge.angle(), "angle"), applied_force(end, 1, kWorldAxes, "stop")}};
  GeneralizedAlpha again{{.step = 2e-4, .spectral_radius = 0.6}};
  Simulation drop{fallen, again};
  drop.observe(fall, every(0.005));
  drop.run(lying, 4.0);
  fall.write_csv("results/servo_friction_stop/fall.csv");
  recorder.write_csv("results/servo_friction_stop/servo.csv");
  write_chart(
      {.title = "An arm with a servo, and one without",
       .x_label = "time (s)",
       .y_label = "angle (rad)",
       .lines = {{.title = "servo", .x = recorder.table().column("t"), .y = recorder.table().column("angle")},
                 {.title = "falls on a stop", .x = fall.table().column("t"), .y = fall.table().column("angle")}}},
      "results/servo_friction_stop/angle");

  // 4. Check the answer: the stop bears the weight's moment, and its depth is that of its law.
  const double rest = fall.table().column("angle").back(), moment = 2 * 9.81 * 0.25 * std::cos(rest);
  const double depth = std::pow(moment / 5e4, 1 / 1.5);
  std::printf("servo: %.6f rad of 1; stop: %.6f rad, by its law %.6f\n", reached, rest, -0.5 - depth);
  return std::abs(reached - 1) < 1e-3 && std::abs(rest + 0.5 + depth) < 1e-4 ? 0 : 1;
}
