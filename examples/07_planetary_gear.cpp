// 07_planetary_gear: the sun drives, the ring stands still, the carrier turns slowly and strong.
//
// Shows: gears that mesh by pitch radii on moving centres, a motor with a falling torque, a load, redundancy among
// planets. Expect: the sun turns 1 + z_ring / z_sun times as fast as the carrier; at steady speed motor power goes into
// the load.
#include <cstdio>

#include "lithe/lithe.h"

using namespace lithe;

int main() {
  // 1. Pitch radii of sun, planets and ring; three planets on a carrier. All axes along z.
  const double sun_radius = 0.02, planet_radius = 0.04, ring_radius = sun_radius + 2 * planet_radius;
  const double arm = sun_radius + planet_radius;
  SystemGraph graph{{.gravity = {0, 0, 0}}};
  auto& ground = graph.ground();
  auto& sun = graph.add<RigidBody>("sun", {.mass = 0.3, .inertia = {4e-5, 4e-5, 6e-5}});
  auto& carrier = graph.add<RigidBody>("carrier", {.mass = 1, .inertia = {1e-3, 1e-3, 2e-3}});
  auto& shaft = graph.add<RevoluteJoint>("sun shaft", {ground.marker(), sun.marker()});
  auto& output = graph.add<RevoluteJoint>("output shaft", {ground.marker(), carrier.marker()});
  for (int i = 0; i < 3; ++i) {
    const std::string number = std::to_string(i + 1);
    const Vector3 centre = rotation_about({0, 0, 1}, 2 * M_PI * i / 3) * Vector3(arm, 0, 0);
    auto& planet =
        graph.add<RigidBody>("planet " + number, {.mass = 0.5, .inertia = {2e-4, 2e-4, 4e-4}, .position = centre});
    graph.add<RevoluteJoint>("planet pin " + number, {carrier.marker(centre), planet.marker()});
    graph.add<GearPair>("sun mesh " + number, {sun.marker(), planet.marker()},
                        {.radius_A = sun_radius, .radius_B = planet_radius});
    graph.add<GearPair>("ring mesh " + number, {ground.marker(), planet.marker()},
                        {.radius_A = ring_radius, .radius_B = -planet_radius});
  }

  // 2. A motor whose torque falls with speed, a load that grows with it.
  auto& motor = graph.add<CoordinateMotor>("motor", {shaft.angle()},
                                           {.effort = [](double, double, double rate) { return 2 - 0.01 * rate; }});
  auto& load = graph.add<CoordinateSpring>("load", {output.angle()}, {.damping = 0.5});

  // 3. From rest to steady speed: some fifty turns of the sun.
  const System system = assemble(graph);
  std::printf("%s\n", describe(system).c_str());
  State state = system.initial_state();
  Recorder recorder{{coordinate(shaft.angle(), "sun"), coordinate(output.angle(), "carrier"), power(motor, "motor"),
                     power(load, "load"), coordinate_rate(shaft.angle(), "rate")}};
  GeneralizedAlpha integrator{{.step = 1e-3, .form = GeneralizedAlpha::Form::stabilized_index2}};
  Simulation simulation{system, integrator};
  simulation.observe(recorder, every(0.01));
  simulation.run(state, 5.0);
  recorder.write_csv("results/planetary_gear/gear.csv");

  // 4. Check the answer: 2 - 0.01 ω = 0.5 ω / ratio² at steady speed.
  const auto last = [&](const char* column) { return recorder.table().column(column).back(); };
  const double ratio = 1 + ring_radius / sun_radius, steady = 2 / (0.01 + 0.5 / (ratio * ratio));
  std::printf(
      "turns: sun %.2f, carrier %.2f, ratio %.9f (exact %.0f); speed %.6f rad/s (exact %.6f); powers %.4f W, %.4f W\n",
      last("sun") / (2 * M_PI), last("carrier") / (2 * M_PI), last("sun") / last("carrier"), ratio, last("rate"),
      steady, last("motor"), last("load"));
  return std::abs(last("sun") / last("carrier") - ratio) < 1e-9 && std::abs(last("rate") / steady - 1) < 1e-5 &&
                 std::abs(last("motor") + last("load")) < 1e-3 * last("motor")
             ? 0
             : 1;
}
