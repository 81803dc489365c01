// robot: a six-axis robot with elastic gears moves 6 kg, and stands still as far off as its gears give.
// Dimensions are typical of a robot of 0.9 m reach and 6 kg payload; gears typical of wave gears of that size. On each
// axis: a rotor that spins with the motor, the gear's output coupled to it by the ratio, a torsional spring with
// damping to the link, and a PID controller on the motor's angle, as in a real drive: it does not see what the gear
// yields. Checked: at rest each spring carries its axis' share of the weights, τ_i = a_i · Σ (c_k - o_i) × m_k g, and
// the tool hangs
//          below its target by J K⁻¹ τ.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "examples/support/machine_report.h"

using namespace lithe;

namespace {

constexpr double kGravity = 9.81, kBegin = 0.2, kArrive = 1.4, kEnd = 4;  // m/s², s

/// An axis and the link behind it, as drawn: world axes, m.
struct Axis {
  int along;         // 0 x, 1 y, 2 z
  Vector3 point;     // on the axis
  double mass;       // of the link, kg
  Vector3 centre;    // of its mass
  double radius;     // of gyration, m
  double ratio;      // of the gear
  double rotor;      // kg m²
  double stiffness;  // of the gear, N m/rad at its output
  double inertia;    // of all that it moves, for the controller's gains, kg m²
  double target;     // rad
  Vector3 direction() const { return Vector3::Unit(along); }
  /// z along the axis.
  Matrix3 axes() const {
    return along == 2
               ? Matrix3(Matrix3::Identity())
               : rotation_about(along == 1 ? Vector3(1, 0, 0) : Vector3(0, 1, 0), along == 1 ? -M_PI / 2 : M_PI / 2);
  }
};
const Axis kAxes[] = {{2, {0, 0, 0.2}, 17, {0.02, 0, 0.33}, 0.12, 100, 3e-4, 6e4, 6, 0.9},
                      {1, {0.025, 0, 0.4}, 12, {0.03, 0.02, 0.63}, 0.17, 120, 3e-4, 6e4, 8, 0.5},
                      {1, {0.025, 0, 0.855}, 9, {0.08, 0, 0.89}, 0.09, 100, 1.5e-4, 2.5e4, 2.5, -0.3},
                      {0, {0.2, 0, 0.89}, 3.5, {0.33, 0, 0.89}, 0.07, 80, 5e-5, 1e4, 0.1, 0.6},
                      {1, {0.445, 0, 0.89}, 1.5, {0.47, 0, 0.89}, 0.04, 80, 5e-5, 7e3, 0.25, 0.7},
                      {0, {0.525, 0, 0.89}, 0.3, {0.53, 0, 0.89}, 0.02, 60, 3e-5, 5e3, 0.05, -0.8}};
constexpr int kCount = 6;
constexpr double kPayload = 6;                                    // kg
const Vector3 kTool(0.605, 0.05, 0.89), kFlange(0.535, 0, 0.89);  // centre of the payload; m

/// Where a point of link `last` comes to when the axes turn: the last one first.
Vector3 moved(Vector3 at, int last, const double* angles) {
  for (int i = last; i >= 0; --i)
    at = kAxes[i].point + rotation_about(kAxes[i].direction(), angles[i]) * (at - kAxes[i].point);
  return at;
}

}  // namespace

int main() {
  // 1. Links, motors, gears and controllers.
  SystemGraph graph{{.gravity = {0, 0, -kGravity}}};
  std::vector<Sensor> sensors;
  std::vector<const RigidBody*> wheels;
  RigidBody* links[kCount];
  for (int i = 0; i < kCount; ++i) {
    const Axis& axis = kAxes[i];
    const std::string number = std::to_string(i + 1);
    const double own = axis.mass * axis.radius * axis.radius;
    links[i] = &graph.add<RigidBody>("link " + number,
                                     {.mass = axis.mass, .inertia = {own, own, own}, .position = axis.centre});
    auto& rotor = graph.add<RigidBody>(
        "rotor " + number, {.mass = 0.3, .inertia = Vector3(Vector3::Constant(axis.rotor)), .position = axis.point});
    auto& output =
        graph.add<RigidBody>("output " + number, {.mass = 0.2, .inertia = {2e-3, 2e-3, 2e-3}, .position = axis.point});
    const Marker base = i == 0 ? graph.ground().marker(axis.point, axis.axes())
                               : links[i - 1]->marker_at_world(axis.point, axis.axes());
    const auto hinge = [&](const std::string& name, RigidBody& body) -> RevoluteJoint& {
      return graph.add<RevoluteJoint>(name + number, {base, body.marker_at_world(axis.point, axis.axes())});
    };
    hinge("bearing ", *links[i]);
    auto &motor = hinge("motor bearing ", rotor), &gear = hinge("gear bearing ", output);
    graph.add<CoordinateCoupling>("gear " + number, {motor.angle(), gear.angle()}, {.factors = {1, -axis.ratio}});
    wheels.insert(wheels.end(), {&rotor, &output});
    const JointCoordinate yield = angle_between(output.marker_at_world(axis.point, axis.axes()),
                                                links[i]->marker_at_world(axis.point, axis.axes()));
    graph.add<CoordinateSpring>("elasticity " + number, {yield},
                                {.stiffness = axis.stiffness, .damping = 2e-3 * axis.stiffness});
    // Gains of a drive of 40 rad/s, damped at 0.7, seen from the motor.
    const double inertia = axis.rotor + axis.inertia / (axis.ratio * axis.ratio), speed = 40;
    auto& memory = graph.add<IntegralState>("integral " + number);
    graph.add<PidController>("drive " + number, {motor.angle(), memory.coordinate()},
                             {.target = smooth_step(0, axis.ratio * axis.target, kBegin, kArrive),
                              .proportional = inertia * speed * speed,
                              .integral = 8 * inertia * speed * speed,
                              .derivative = 1.4 * inertia * speed});
    sensors.push_back(coordinate(yield, "yield " + number));
  }
  auto& payload = graph.add<RigidBody>("payload", {.mass = kPayload, .inertia = {0.02, 0.02, 0.02}, .position = kTool});
  graph.add<FixedJoint>("gripper", {links[5]->marker_at_world(kTool), payload.marker()});
  sensors.push_back(position(payload.marker(), "tool"));
  // 2. From rest in the drawn pose to the target, and at rest there.
  const auto draw = [&](Run& page) {
    for (int i = 0; i < kCount; ++i) {
      const Vector3 next = i + 1 < kCount ? kAxes[i + 1].point : kFlange;
      page.draw(*links[i], visual::rod(kAxes[i].point - kAxes[i].centre, next - kAxes[i].centre, 0.07 - 0.007 * i));
    }
    for (int k = 0; k < 2 * kCount; ++k)
      page.draw(*wheels[k], visual::cylinder(0.09 - 0.005 * k, 0.02 + 0.02 * (k % 2)).at({}, kAxes[k / 2].axes()));
    page.draw(payload, visual::box({0.1, 0.1, 0.1}));
  };
  const machine::Outcome out = machine::run(graph, {.name = "robot",
                                                    .title = "A six-axis robot with elastic gears",
                                                    .duration = kEnd,
                                                    .interval = 0.02,
                                                    .tolerance = {1e-6, 1e-8},
                                                    .sensors = sensors,
                                                    .draw = draw,
                                                    .wants = {want(sensors.back(), percent(1))},
                                                    .solve_duration = 2});

  // 3. Check: torques of the weights at the pose where the links stand, and the tool below its target.
  double targets[kCount], angles[kCount], worst = 0, largest = 0;
  for (int i = 0; i < kCount; ++i) {
    targets[i] = kAxes[i].target;
    angles[i] = targets[i] + machine::at(out.table, "yield " + std::to_string(i + 1), kEnd);
  }
  const Vector3 target = moved(kTool, kCount - 1, targets);
  Vector3 sag = Vector3::Zero();
  for (int i = 0; i < kCount; ++i) {
    const Vector3 origin = moved(kAxes[i].point, i, angles), ahead = kAxes[i].point + kAxes[i].direction(),
                  direction = moved(ahead, i, angles) - origin;
    double torque = 0;
    const auto weigh = [&](double mass, const Vector3& at) {
      torque += direction.dot((at - origin).cross(Vector3(0, 0, -mass * kGravity)));
    };
    for (int k = i; k < kCount; ++k) {
      weigh(kAxes[k].mass, moved(kAxes[k].centre, k, angles));
      if (k > i) weigh(0.5, moved(kAxes[k].point, k - 1, angles));  // rotor and output on the link before
    }
    weigh(kPayload, moved(kTool, kCount - 1, angles));
    worst = std::max(worst, std::abs(torque - kAxes[i].stiffness * (angles[i] - targets[i])));
    largest = std::max(largest, std::abs(torque));
    sag += direction.cross(moved(kTool, kCount - 1, angles) - origin) * torque / kAxes[i].stiffness;
  }
  const auto at_end = [&](const char* column) { return machine::at(out.table, column, kEnd); };
  const Vector3 tool(at_end("tool_x"), at_end("tool_y"), at_end("tool_z"));
  std::printf("torques to %.1e of %.1f N m; the tool hangs by %.3f mm (J K⁻¹ τ: %.3f mm), off by %.4f mm\n", worst,
              largest, 1e3 * (tool - target).norm(), 1e3 * sag.norm(), 1e3 * (tool - target - sag).norm());
  return out.good && worst < 1e-3 * largest && (tool - target - sag).norm() < 0.01 * sag.norm() ? 0 : 1;
}
