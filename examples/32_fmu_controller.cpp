// 32_fmu_controller: a robot from a URDF file under controllers that are FMUs of another tool.
//
// Shows: read_model() and draw_model(); ModelExchangeFmu, whose states are integrated together with the robot, at
//        each joint of it; sensors of an FMU's variables. The FMU is built with this program (examples/fmu/).
// Expect: all seven joints come to their targets; there the torques are the slope of the robot's potential energy.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <deque>

#include "lithe/lithe.h"

using namespace lithe;

namespace {

const std::string kRobot = LITHE_EXAMPLE_DATA "/iiwa.urdf";            // KUKA iiwa 14, of rbd-benchmarks (MIT)
constexpr double kTargets[] = {0.5, 0.8, -0.4, -1.2, 0.3, 0.9, -0.6};  // rad
constexpr double kSizes[] = {3000, 3000, 1500, 1500, 300, 300, 30};    // of the gains, N m/rad
std::string joint(int i) { return "lbr_iiwa_joint_" + std::to_string(i + 1); }

/// Of the robot drawn with these angles, J.
double potential(const std::map<std::string, double>& angles) {
  const ModelDescription model = read_model(kRobot);
  SystemGraph graph{{.gravity = model.gravity}};
  draw_model(graph, model, {.positions = angles});
  const System system = assemble(graph);
  Snapshot drawn(system, system.initial_state());
  return drawn.energy().gravity;
}

}  // namespace

int main() {
  // 1. The robot, and a controller at each joint: an FMU reads the angle, and its torque acts on it.
  const ModelDescription model = read_model(kRobot);
  SystemGraph graph{{.gravity = model.gravity}};
  const DrawnModel robot = draw_model(graph, model);
  std::deque<ModelExchangeFmu> controllers;
  std::vector<Sensor> watched;
  for (int i = 0; i < 7; ++i) {
    const JointCoordinate angle = robot.coordinate(joint(i));
    auto& pid =
        controllers.emplace_back(graph, "pid " + std::to_string(i + 1), LITHE_EXAMPLE_FMU,
                                 ModelExchangeFmu::Parameters{.inputs = {{"angle", angle}},
                                                              .laws = {{"target", smooth_step(0, kTargets[i], 0, 1)}},
                                                              .outputs = {{"torque", angle}},
                                                              .values = {{"proportional", kSizes[i]},
                                                                         {"integration", 5 * kSizes[i]},
                                                                         {"derivation", kSizes[i] / 10},
                                                                         {"filter", 0.002}}});
    watched.push_back(coordinate(angle, joint(i)));
    watched.push_back(pid.sensor("torque", "torque " + std::to_string(i + 1)));
  }
  std::fputs(controllers[1].describe().c_str(), stdout);

  // 2. One run of robot and controllers, by one method under one tolerance.
  const System system = assemble(graph);
  Automatic integrator{{.tolerance = {.relative = 1e-6, .absolute = 1e-8}}};
  Simulation simulation{system, integrator};
  for (ModelExchangeFmu& pid : controllers) pid.join(simulation);
  Recorder recorder(watched);
  simulation.observe(recorder, every(0.02));
  State state = system.initial_state();
  simulation.run(state, 5);
  recorder.write_csv("results/fmu_controller.csv");

  // 3. At rest each torque holds the robot's weight: the slope of its potential energy along that joint.
  std::map<std::string, double> rest;
  for (int i = 0; i < 7; ++i) rest[joint(i)] = recorder.table().column(joint(i)).back();
  double worst_angle = 0, worst_torque = 0;
  for (int i = 0; i < 7; ++i) {
    const double d = 1e-4, torque = recorder.table().column("torque " + std::to_string(i + 1)).back();
    auto before = rest, after = rest;
    before[joint(i)] -= d, after[joint(i)] += d;
    const double weight = (potential(after) - potential(before)) / (2 * d);
    std::printf("joint %d: %8.5f rad of %4.1f, torque %9.4f N m of %9.4f\n", i + 1, rest[joint(i)], kTargets[i], torque,
                weight);
    worst_angle = std::max(worst_angle, std::abs(rest[joint(i)] - kTargets[i]));
    worst_torque = std::max(worst_torque, std::abs(torque - weight));
  }
  std::printf("%ld steps; angles to %.1e rad, torques to %.1e N m\n", simulation.statistics().steps, worst_angle,
              worst_torque);
  return worst_angle < 1e-6 && worst_torque < 1e-5 ? 0 : 1;
}
