// 31_inputs_and_bode: a scene with inputs: what does a torque at a hinge do to the end of a flexible arm, and how does
// a controller that samples move it?
//
// Shows: Input; linearize() with inputs and outputs; Bode and Nyquist charts; SampledController, which sets the input.
// Expect: the linearized arm has a zero between its poles (where the hinge stands still and the end swings); the
//         sampled controller brings the arm to its target; charts in results/inputs/.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "lithe/lithe.h"

using namespace lithe;

int main() {
  // 1. A flexible arm on a hub that turns about the vertical, under a torque given from outside.
  SystemGraph graph;
  auto& torque = graph.add<Input>("torque", {.unit = "N m", .lower = -2, .upper = 2});
  auto& arm =
      graph.add<Beam>("arm", {.axis = BeamAxis::straight({0, 0, 0}, {1, 0, 0}),
                              .sections = {{0, BeamSection::rectangle(0.004, 0.03, {7e10, 0.3, 2700}).damped(2e-4)}},
                              .elements = 10});
  auto& hub = graph.add<RigidBody>("hub", {.mass = 1, .inertia = {0.02, 0.02, 0.02}});
  graph.add<FixedJoint>("clamp", {hub.marker({0, 0, 0}, arm.axes(0)), arm.marker(0)});
  auto& hinge = graph.add<RevoluteJoint>("hinge", {graph.ground().marker(), hub.marker()});
  graph.add<CoordinateMotor>("motor", {hinge.angle()}, {.effort = torque});
  const Marker end = arm.marker(arm.length());
  const System system = assemble(graph);

  // 2. The arm as a plant: one input, two outputs, about the pose in which it rests under its weight.
  const State rest = find_equilibrium(system, system.initial_state()).state;
  const StateSpace plant =
      linearize(system, rest, {&torque}, {coordinate(hinge.angle(), "angle"), position(end, "end")});
  const FrequencyResponse at_hinge = frequency_response(plant, 0, 0, 0.5, 60);
  const FrequencyResponse at_end = frequency_response(plant, 0, 2, 0.5, 60);
  write_bode({at_hinge, at_end}, "results/inputs/bode");
  write_nyquist({at_hinge}, "results/inputs/nyquist");
  write_hdf5(plant, "results/inputs/plant.h5");
  const auto slowest = [](const std::vector<Complex>& all) {
    double frequency = 0;
    for (const Complex s : all)
      if (s.imag() > 1 && (frequency == 0 || s.imag() < frequency)) frequency = s.imag();
    return frequency / (2 * M_PI);
  };
  const double zero = slowest(plant.zeros(0, 0)), pole = slowest(plant.poles());
  std::printf("hinge by torque: first zero %.2f Hz, first bending pole %.2f Hz\n", zero, pole);

  // 3. A run under the controller, which samples every 10 ms.
  GeneralizedAlpha integrator{{.step = 2e-3}};
  Simulation simulation{system, integrator};
  SampledController controller(
      {.name = "controller",
       .interval = 0.01,
       .inputs = {{coordinate(hinge.angle(), "angle")}, {coordinate_rate(hinge.angle(), "rate")}},
       .outputs = {&torque},
       .law = {.inputs = 2, .outputs = 1, .step = [&](double, const VectorX& u, VectorX&, VectorX& y) {
                 const auto& bounds = torque.parameters();
                 y[0] = std::clamp(0.6 * (0.5 - u[0]) - 0.4 * u[1], bounds.lower, bounds.upper);
               }}});
  Recorder recorder{{coordinate(hinge.angle(), "angle"), input_value(torque), position(end, "end")}};
  simulation.observe(recorder, every(0.01));
  controller.join(simulation);
  State state = rest;
  simulation.run(state, 4);
  recorder.write_csv("results/inputs/run.csv");
  const double angle = recorder.table().column("angle").back();
  std::printf("after 4 s the hinge stands at %.4f rad, %zu samples were set\n", angle, torque.samples().size());
  return zero < pole && zero > 0 && std::abs(angle - 0.5) < 0.01 ? 0 : 1;
}
