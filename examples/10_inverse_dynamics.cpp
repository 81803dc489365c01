// 10_inverse_dynamics: which torques make a two-link arm draw a straight line?
//
// Shows: drives on all freedoms, kinematic analysis (nothing is integrated), the forces of the drives as its result.
// Expect: the tip follows the line to 1e-12 m; the drives' work is the change of energy.
#include <cstdio>

#include "lithe/lithe.h"

using namespace lithe;

int main() {
  // 1. An arm of two links in the vertical plane y = 0, its tip in a slot that another drive moves along.
  const double l = 0.5;
  SystemGraph graph{{.gravity = {0, 0, -9.81}}};
  const Matrix3 axis = rotation_about({1, 0, 0}, M_PI / 2);
  const double bend = std::acos(0.6);  // both links at that angle above and below the x axis: the tip is at x = 0.6
  const Matrix3 up = rotation_about({0, 1, 0}, -bend), down = rotation_about({0, 1, 0}, bend);
  auto& upper = graph.add<RigidBody>(
      "upper", {.mass = 3, .inertia = {1e-2, 0.07, 0.07}, .position = up * Vector3(l / 2, 0, 0), .orientation = up});
  auto& lower = graph.add<RigidBody>("lower", {.mass = 2,
                                               .inertia = {1e-2, 0.05, 0.05},
                                               .position = up * Vector3(l, 0, 0) + down * Vector3(l / 2, 0, 0),
                                               .orientation = down});
  auto& shoulder = graph.add<RevoluteJoint>(
      "shoulder", {graph.ground().marker({0, 0, 0}, axis), upper.marker({-l / 2, 0, 0}, axis)});
  auto& elbow =
      graph.add<RevoluteJoint>("elbow", {upper.marker({l / 2, 0, 0}, axis), lower.marker({-l / 2, 0, 0}, axis)});

  // 2. The angles that the line needs: shoulder φ = acos(x / 2l), elbow -2φ, as functions of time.
  const MotionLaw x = smooth_step(0.6, 0.9, 0, 1);
  const MotionLaw phi = [x, l](double t) {
    const Motion at = x(t);
    const double u = at.value / (2 * l), u1 = at.rate / (2 * l), u2 = at.acceleration / (2 * l),
                 root = std::sqrt(1 - u * u);
    return Motion{std::acos(u), -u1 / root, -u2 / root - u * u1 * u1 / (root * root * root)};
  };
  const MotionLaw twice = [phi](double t) {
    const Motion at = phi(t);
    return Motion{-2 * at.value, -2 * at.rate, -2 * at.acceleration};
  };
  auto& first = graph.add<CoordinateDrive>("shoulder drive", {shoulder.angle()}, {.motion = phi});
  auto& second = graph.add<CoordinateDrive>("elbow drive", {elbow.angle()}, {.motion = twice});

  // 3. Kinematic analysis; the multipliers of the drives are the answer.
  const System system = assemble(graph);
  State state = system.initial_state();
  const Marker tip = lower.marker({l / 2, 0, 0});
  Recorder recorder{{position(tip, "tip"), drive_force(first, "shoulder"), drive_force(second, "elbow"),
                     power(first, "p1"), power(second, "p2"), total_energy("energy")}};
  Kinematics kinematics{{.step = 1e-3}};
  Simulation simulation{system, kinematics};
  simulation.observe(recorder, every(1e-3));
  simulation.run(state, 1.0);
  recorder.write_csv("results/inverse_dynamics/arm.csv");
  const auto column = [&](const char* name) { return recorder.table().column(name); };
  write_chart({.title = "Torques that draw a straight line",
               .x_label = "time (s)",
               .y_label = "torque (N m)",
               .lines = {{.title = "shoulder", .x = column("t"), .y = column("shoulder")},
                         {.title = "elbow", .x = column("t"), .y = column("elbow")}}},
              "results/inverse_dynamics/torques");

  // 4. Check the answer.
  const auto t = column("t"), z = column("tip_z"), p1 = column("p1"), p2 = column("p2"), energy = column("energy");
  double off = 0, work = 0;
  for (std::size_t i = 0; i < t.size(); ++i) {
    off = std::max(off, std::abs(z[i]));
    if (i > 0) work += (p1[i] + p2[i] + p1[i - 1] + p2[i - 1]) / 2 * (t[i] - t[i - 1]);
  }
  std::printf("tip off the line by %.1e m; work %.6f J, energy %.6f J; torques at the start %.4f and %.4f N m\n", off,
              work, energy.back() - energy.front(), column("shoulder").front(), column("elbow").front());
  return off < 1e-12 && std::abs(work - (energy.back() - energy.front())) < 1e-5 ? 0 : 1;
}
