// A pendulum at rest with a motor, followed by the browser of tests/page/live.mjs.
#include <cstdio>

#include "bodies/rigid_body.h"
#include "engine/page/run.h"
#include "engine/run/simulation.h"
#include "integrators/generalized_alpha.h"
#include "joints/forces/coordinate_motor.h"
#include "joints/revolute_joint.h"

using namespace lithe;

int main() {
  SystemGraph graph{{.gravity = {0, 0, -9.81}}};
  auto& rod = graph.add<RigidBody>("rod", {.inertia = {1.0 / 12, 1.0 / 12, 1e-4}, .position = {0, 0, -0.5}});
  const Matrix3 along_y = rotation_about({1, 0, 0}, -M_PI / 2);
  auto& pin =
      graph.add<RevoluteJoint>("pin", {graph.ground().marker({0, 0, 0}, along_y), rod.marker({0, 0, 0.5}, along_y)});
  auto& torque = graph.add<Input>("torque", {.unit = "N m", .lower = -5, .upper = 5});
  graph.add<CoordinateMotor>("motor", {pin.angle()}, {.effort = torque});
  const System system = assemble(graph);
  State state = system.initial_state();
  Run run{system, {position(rod.marker({0, 0, -0.5}), "tip"), coordinate(pin.angle(), "angle")}, {.name = "live"}};
  run.follow({.speed = 1, .wait = 60});
  GeneralizedAlpha integrator{{.step = 2e-3, .spectral_radius = 0.9}};
  Simulation simulation{system, integrator};
  simulation.observe(run, every(0.02));
  simulation.run(state, 600);
  std::printf("%d states, ended by %s\n", run.frame_count(), simulation.stopped_by().c_str());
}
