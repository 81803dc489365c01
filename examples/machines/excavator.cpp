// excavator: boom, stick and bucket on three cylinders: the bucket comes down, presses on the ground, is pulled in and
// lifted. Dimensions are typical of an excavator of 20 t; a straight boom, the two boom cylinders as one, the bucket
// without its linkage, the carriage held to the ground.
// Checked: as long as the closed valves hold the bucket on the ground, the ground's force against the balance of
// moments
//          about the boom's foot of weights and oil; the pump's work against heat, compressed oil and what the links
//          got.
#include <cmath>
#include <cstdio>

#include "examples/support/machine_report.h"

using namespace lithe;

namespace {

constexpr double kGravity = 9.81;

/// In the plane of the machine, x ahead, z up: positive turns up what lies ahead.
double moment(const Vector3& arm, const Vector3& force) { return arm.x() * force.z() - arm.z() * force.x(); }
Vector3 along(double degrees) { return {std::cos(degrees * M_PI / 180), 0, std::sin(degrees * M_PI / 180)}; }

double disc(double diameter) { return M_PI / 4 * diameter * diameter; }

struct Link {
  RigidBody& body;
  double mass;
  Vector3 centre;
};
Link add_link(SystemGraph& graph, const char* name, const Vector3& from, const Vector3& to, double width, double mass) {
  const Vector3 d = to - from, centre = 0.5 * (from + to);
  const MassProperties shape = box({d.norm(), width, width}, mass / (d.norm() * width * width));
  return {graph.add<RigidBody>(name, {.mass = mass,
                                      .inertia = shape.inertia,
                                      .position = centre,
                                      .orientation = rotation_about({0, 1, 0}, -std::atan2(d.z(), d.x()))}),
          mass, centre};
}

/// A cylinder between points of two bodies. Its oil holds, as drawn, what hangs on the link beyond `pivot`.
struct Ram {
  double bore, rod, closed_length, stroke, valve_area;
  MotionLaw command;
};
HydraulicCylinder& add_ram(SystemGraph& graph, const std::string& name, Marker A, Marker B, const Vector3& from,
                           const Vector3& to, const Vector3& pivot, const std::vector<Link>& beyond, const Ram& ram) {
  double weight = 0;
  for (const Link& link : beyond) weight += link.mass * kGravity * (link.centre - pivot).x();
  const double push = weight / moment(to - pivot, (to - from).normalized());
  const double cap = disc(ram.bore), ring = cap - disc(ram.rod), least = 2e6;
  const bool pushes = push > 0;
  auto& oil = graph.add<FirstOrderStates>(
      name + " oil", {.start = HydraulicCylinder::start(pushes ? (push + ring * least) / cap : least,
                                                        pushes ? least : (cap * least - push) / ring)});
  return graph.add<HydraulicCylinder>(name, {A, B, oil.point(0)},
                                      {.bore = ram.bore,
                                       .rod = ram.rod,
                                       .stroke = ram.stroke,
                                       .closed_length = ram.closed_length,
                                       .cap_dead_volume = 2e-3,
                                       .rod_dead_volume = 2e-3,
                                       .friction = 2e4,
                                       .oil = {.air = 0.005},
                                       .valve = {.area = ram.valve_area,
                                                 .command = ram.command,
                                                 .time_constant = 0.03,
                                                 .supply = constant(2.5e7),
                                                 .relief = 3e7,
                                                 .relief_flow = 1e-9,
                                                 .makeup_flow = 1e-8}});
}

/// Opens a valve to x for some time.
MotionLaw pulse(double x, double begin, double end) {
  return smooth_step(0, x, begin, begin + 0.3) + smooth_step(0, -x, end - 0.3, end);
}

}  // namespace

int main() {
  // 1. Links in their plane.
  SystemGraph graph{{.gravity = {0, 0, -kGravity}}};
  auto& ground = graph.ground();
  const Vector3 foot(0, 0, 1.8), elbow = foot + 5.7 * along(35), wrist = elbow + 2.9 * along(-70);
  const Vector3 tip = wrist + 1.4 * along(-110), front = along(20);  // front: across the stick
  const Link boom = add_link(graph, "boom", foot, elbow, 0.45, 1500);
  const Link stick = add_link(graph, "stick", elbow - 0.8 * along(-70), wrist, 0.35, 800);
  const Link bucket = add_link(graph, "bucket", wrist, tip, 0.6, 600);
  const auto pin = [&](const char* name, auto& a, auto& b, const Vector3& at) {
    graph.add<RevoluteJoint>(name, at_world(a, b, {.point = at, .axis = {0, -1, 0}}));
  };
  pin("foot", ground, boom.body, foot), pin("elbow", boom.body, stick.body, elbow),
      pin("wrist", stick.body, bucket.body, wrist);

  // 2. Cylinders, and what their valves do: down, hold, pull in, lift and curl.
  const double hold = 4, end = 9;
  const Vector3 lift_from(0.9, 0, 1.3), lift_to = foot + 2.3 * along(35);
  auto& lift =
      add_ram(graph, "lift", ground.marker(lift_from), boom.body.marker_at_world(lift_to), lift_from, lift_to, foot,
              {boom, stick, bucket}, {0.17, 0.12, 1.5, 1.2, 4e-5, pulse(-0.5, 0.3, 2.6) + pulse(0.7, hold + 0.8, 8)});
  const Vector3 arm_from = foot + 2.5 * along(35) + 0.6 * along(125), arm_to = elbow - 0.8 * along(-70);
  auto& arm = add_ram(graph, "arm", boom.body.marker_at_world(arm_from), stick.body.marker_at_world(arm_to), arm_from,
                      arm_to, elbow, {stick, bucket}, {0.13, 0.09, 2.2, 1.6, 3e-5, pulse(0.4, hold, 7)});
  const Vector3 curl_from = elbow + 0.5 * along(-70) + 0.45 * front, curl_to = wrist + 0.45 * front;
  auto& curl = add_ram(graph, "curl", stick.body.marker_at_world(curl_from), bucket.body.marker_at_world(curl_to),
                       curl_from, curl_to, wrist, {bucket}, {0.115, 0.08, 1.5, 1.3, 2e-5, pulse(0.6, hold + 1.5, 7.5)});
  auto& soil = graph.add<Contact>(
      "soil", {{ground.marker(), shape::half_space()}, {bucket.body.marker_at_world(tip), shape::sphere(0.1)}},
      {.law = Compliance{.stiffness = 1e7, .restitution = 0.3}, .friction = {.coefficient = 0.4, .creep_speed = 0.02}});

  // 3. Run.
  const Marker teeth = bucket.body.marker_at_world(tip), lifted = boom.body.marker_at_world(lift_to);
  const machine::Outcome out =
      machine::run(graph, {.name = "excavator",
                           .title = "An excavator",
                           .duration = end,
                           .interval = 0.05,
                           .tolerance = {1e-6, 1e-6},
                           .sensors = {position(teeth, "tip"), position(lifted, "lifted"),
                                       position(boom.body.marker(), "boom"), position(stick.body.marker(), "stick"),
                                       position(bucket.body.marker(), "bucket"), lift.pressures("lift"),
                                       arm.pressures("arm"), curl.pressures("curl"), contact_force(soil, 1, "soil")},
                           .draw =
                               [&](Run& page) {
                                 page.draw(boom.body, visual::box({5.7, 0.4, 0.5}));
                                 page.draw(stick.body, visual::box({3.7, 0.3, 0.35}));
                                 page.draw(bucket.body, visual::box({1.4, 1.1, 0.4}));
                               },
                           .powers = {contact_power(soil)}});

  // 4. Check: moments about the foot, the bucket pressed on the ground and all valves closed.
  const auto value = [&](const std::string& column) { return machine::at(out.table, column, hold - 0.1); };
  const auto point = [&](const std::string& of) { return Vector3(value(of + "_x"), 0, value(of + "_z")); };
  const Vector3 rod = point("lifted") - lift_from;
  const double oil = disc(0.17) * value("lift_cap") - (disc(0.17) - disc(0.12)) * value("lift_rod");
  double sum = moment(point("lifted") - foot, oil * rod.normalized());
  for (const auto& [name, link] : {std::pair("boom", &boom), {"stick", &stick}, {"bucket", &bucket}})
    sum += moment(point(name) - foot, {0, 0, -kGravity * link->mass});
  // The ground's force acts where the moment about the teeth's centre says.
  const Vector3 press(value("soil_force_x"), 0, value("soil_force_z"));
  const double by_ground = moment(point("tip") - foot, press) - value("soil_moment_y");
  std::printf(
      "the bucket presses on the ground with %.1f kN; its moment about the foot is %.2f kN m (oil and weights: "
      "%.2f kN m)\n",
      press.z() / 1000, by_ground / 1000, -sum / 1000);
  return out.good && press.z() > 1e4 && std::abs(by_ground / sum + 1) < 0.01 ? 0 : 1;
}
