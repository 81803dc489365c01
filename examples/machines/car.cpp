// car: a passenger car drives off, over a curb (5 cm, 80 m ahead), through a slalom, and ends in a steady turn. Typical
// of a compact car: 1.36 t, wheelbase 2.6 m, track 1.5 m, double wishbones on bushings, a rack that steers the front
// wheels, tyres 205/60 R15 (examples/data/tyres/car.tir), motors in the rear hubs that keep a speed, a flexible frame.
// Checked: the yaw rate of the steady turn against the single-track model with the tyres' stiffnesses and trails.
#include <cstdio>

#include "examples/support/machine_report.h"

using namespace lithe;

namespace {
constexpr double kSpeed = 15, kFront = 1.2, kRear = -1.4, kCentre = 0.294, kGravity = 9.81, kEnd = 18, kSprung = 1200;
const Matrix3 kAxle = rotation_about({1, 0, 0}, -M_PI / 2);  // z to the left
/// N, of the sprung mass on one wheel of the axle at x.
double on_spring(double x) { return kSprung * kGravity * (x > 0 ? -kRear : kFront) / (kFront - kRear) / 2; }

struct Corner {
  RigidBody *upright, *wheel;
  JointCoordinate turn;
  const Tyre* tyre;
};

/// A wheel on its wishbones; `mount` holds them, `rod` the tie rod's end. Places: front left, right, rear left, right.
struct Suspension {
  SystemGraph& graph;
  FirstOrderStates& carcasses;
  const TyreCoefficients tyre;
  const std::shared_ptr<const TyreRoad> road;
  double mass = 0;

  RigidBody& part(const std::string& name, double kg, const Vector3& inertia, const Vector3& at,
                  const Matrix3& axes = Matrix3::Identity()) {
    mass += kg;
    return graph.add<RigidBody>(name, {.mass = kg, .inertia = inertia, .position = at, .orientation = axes});
  }

  Corner draw(int place, RigidBody& mount, RigidBody& rod) {
    const double x = place < 2 ? kFront : kRear, side = place % 2 == 0 ? 1 : -1;
    const std::string name = std::string(place < 2 ? "front " : "rear ") + (side > 0 ? "left" : "right");
    const auto at = [&](double dx, double in, double dz) { return Vector3(x + dx, side * (0.75 - in), kCentre + dz); };
    auto& upright = part(name + " upright", 12, {0.15, 0.15, 0.1}, at(0, 0.1, 0));
    auto& wheel = part(name + " wheel", 18, {0.55, 0.55, 0.95}, at(0, 0, 0), kAxle);
    auto& hub = graph.add<RevoluteJoint>(name + " hub", {upright.marker_at_world(at(0, 0, 0), kAxle), wheel.marker()});
    const auto wishbone = [&](const std::string& which, double height, double outer, double inner) -> RigidBody& {
      auto& arm = part(name + " " + which, 4, {0.04, 0.04, 0.06}, at(0, 0.5 * (outer + inner), height));
      const Vector3 ball = at(0, outer, 1.15 * height);
      graph.add<SphericalJoint>(name + " " + which + " ball",
                                {arm.marker_at_world(ball), upright.marker_at_world(ball)});
      for (const Vector3& pin : {at(-0.15, inner, height), at(0.15, inner, height)})
        graph.add<Bushing>(name + " " + which + (pin.x() > x ? " front" : " rear") + " bushing",
                           {mount.marker_at_world(pin), arm.marker_at_world(pin)},
                           {.stiffness = Bushing::diagonal({3e6, 1e7, 1e7}, {2, 500, 500}),
                            .damping = Bushing::diagonal({3e3, 6e3, 6e3}, {0.2, 1, 1})});
      return arm;
    };
    auto& lower = wishbone("lower arm", -0.13, 0.10, 0.45);
    wishbone("upper arm", 0.13, 0.14, 0.40);
    // The spring's lever is 0.25 m of the arm's 0.35 m: 25 kN/m at the wheel.
    graph.add<SpringDamper>(name + " spring",
                            {lower.marker_at_world(at(0, 0.2, -0.13)), mount.marker_at_world(at(0, 0.3, 0.35))},
                            {.stiffness = 5.1e4, .damping = 4.5e3, .preload = -1.43 * on_spring(x)});
    graph.add<DistanceJoint>(name + " tie rod",
                             {upright.marker_at_world(at(-0.12, 0.12, 0)), rod.marker_at_world(at(-0.12, 0.42, 0))});
    return {&upright, &wheel, hub.angle(),
            &graph.add<Tyre>(name + " tyre", {graph.ground().marker(), wheel.marker(), carcasses.point(place)},
                             {.coefficients = tyre, .road = road, .mirrored = side < 0})};
  }
};
}  // namespace

int main() {
  // 1. The frame: a plate of elements, 1e4 N m of torsion a degree; the body hangs on all of it, subframes on its ends.
  SystemGraph graph{{.gravity = {0, 0, -kGravity}}};
  auto& carcasses = graph.add<FirstOrderStates>("carcasses", {.start = VectorX::Zero(12)});
  Suspension suspension{graph, carcasses, read_tir(LITHE_EXAMPLE_DATA "/tyres/car.tir"),
                        std::make_shared<TyreProfile>(TyreProfile::Parameters{
                            .x = {80, 80, 83, 83}, .heights = {0, 0.05, 0.05, 0}, .radius = 0.313})};
  const auto mesh =
      brick_mesh({.size = {kFront - kRear, 1, 0.12}, .divisions = {8, 4, 1}, .material = {7e9, 0.3, 641}});
  auto& frame = graph.add<FlexibleBody>("frame", {.basis = make_basis(mesh, MeanAxisFrame{}, 8),
                                                  .damping = {.modal_ratios = {0.02}},
                                                  .position = {kRear, -0.5, 0.24}});
  const auto on_frame = [&](const char* name, double kg, Vector3 J, Vector3 at, const char* nodes, double x) -> auto& {
    auto& body = suspension.part(name, kg, J, at);
    const Marker on = frame.average(mesh.node_sets.at(nodes));
    graph.add<FixedJoint>(std::string(name) + " bolts", {on, body.marker_at_world({x, 0, 0.3})});
    return body;
  };
  auto& chassis = on_frame("body", 880, {350, 1300, 1400}, {0.036, 0, 0.6}, "all", (kFront + kRear) / 2);
  auto& front = on_frame("front subframe", 60, {6, 3, 6}, {kFront, 0, 0.3}, "x_max", kFront);
  auto& rear = on_frame("rear subframe", 60, {6, 3, 6}, {kRear, 0, 0.3}, "x_min", kRear);
  auto& rack = suspension.part("rack", 4, {0.1, 0.01, 0.1}, {kFront - 0.12, 0, kCentre});
  const Corner corners[] = {suspension.draw(0, front, rack), suspension.draw(1, front, rack),
                            suspension.draw(2, rear, rear), suspension.draw(3, rear, rear)};

  // 2. Motors of equal torque, up to 15 m/s in 8 s. Steering by the rack: left, right, left, and held to the left.
  auto& guide = graph.add<PrismaticJoint>(
      "guide", {front.marker_at_world({kFront - 0.12, 0, kCentre}, kAxle), rack.marker({}, kAxle)});
  graph.add<CoordinateDrive>(
      "steering", {guide.displacement()},
      {.motion = smooth_step(0, -3e-3, 12, 12.5) + smooth_step(0, 6e-3, 13, 13.8) + smooth_step(0, -6e-3, 14.3, 15.1)});
  ControlDiagram motors;
  const ControlSignal turns = 0.5 * (motors.rate(corners[2].turn) + motors.rate(corners[3].turn)),
                      torque = 300 * (motors.law(smooth_step(0, kSpeed / 0.307, 0.5, 8.5)) - turns);
  for (int i : {2, 3}) motors.push(corners[i].turn, torque);
  const auto& states = graph.add<FirstOrderStates>("motor states", {.start = motors.start()});
  graph.add<ControlForce>("motors", motors.markers(states), {motors});

  // 3. Run.
  const auto steer = [&](Snapshot& now, std::span<double> out) {  // front against rear, which the bushings steer too
    const auto toe = [&](int i) { return angle_between(chassis.marker(), corners[i].upright->marker()); };
    out[0] = 0;
    for (int i = 0; i < 4; ++i) out[0] += (i < 2 ? 0.5 : -0.5) * coordinate(toe(i), "toe").value(now);
  };
  const std::vector<Sensor> sensors = {position(chassis.marker(), "car"),
                                       velocity(chassis.marker(), "car_v"),
                                       angular_velocity(chassis.marker(), "turn"),
                                       {"steer", {"steer"}, steer, {"rad"}},
                                       tyre_contact(*corners[0].tyre, "tyre")};
  const auto draw = [&](Run& page) {
    for (const Corner& c : corners) page.draw(*c.wheel, visual::cylinder(0.313, 0.2));
  };
  const machine::Outcome out = machine::run(graph, {.name = "car",
                                                    .title = "A car over a curb and through a slalom",
                                                    .duration = kEnd,
                                                    .interval = 0.04,
                                                    .sensors = sensors,
                                                    .draw = draw,
                                                    .wants = {want(sensors[0], percent(2))},
                                                    .solve_duration = 2});

  // 4. Check.
  const auto last = [&](const std::string& column) { return machine::at(out.table, column, kEnd); };
  const double speed = std::hypot(last("car_v_x"), last("car_v_y")), yaw = last("turn_z");
  // Of both tyres of an axle at about the slip angle of the turn: cornering stiffness, and trail of the side force.
  const auto axle = [&](double x) {
    const double load = on_spring(x) + 38 * kGravity, slip = 0.012;
    const MagicFormula& tyre = corners[0].tyre->formula();
    const auto left = tyre.at({.alpha = slip, .load = load, .speed = kSpeed});
    const auto right = tyre.at({.alpha = -slip, .load = load, .speed = kSpeed});
    return std::pair((right.Fy - left.Fy) / slip, (left.Mz - right.Mz) / (right.Fy - left.Fy));
  };
  const auto [C_front, t_front] = axle(kFront);
  const auto [C_rear, t_rear] = axle(kRear);
  const double a = kFront - t_front, b = -kRear + t_rear, m = suspension.mass + frame.mass();
  const double gradient = m / (a + b) * (b / C_front - a / C_rear);
  const double expected = speed * last("steer") / (kFront - kRear + gradient * speed * speed);
  std::printf("yaw rate %.4f rad/s (single-track model: %.4f)\n", yaw, expected);
  return out.good && std::abs(yaw / expected - 1) < 0.02 ? 0 : 1;
}
