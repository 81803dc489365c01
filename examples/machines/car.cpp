// car: a passenger car coasts over a curb and through a slalom, and ends in a steady turn.
//
// Typical dimensions of a compact car (1.36 t, wheelbase 2.6 m, track 1.5 m): double wishbones on bushings at all four
// wheels, a rack that steers the front ones, tyres 205/60 R15 (examples/data/tyres/car.tir). The chassis is rigid.
// Checked: the yaw rate of the steady turn against the single-track model with the tyres' own cornering stiffnesses;
// what
//          the tyres carry in the mean against the weight and the change of vertical momentum.
#include <cstdio>

#include "examples/support/machine_report.h"

using namespace lithe;

namespace {

constexpr double kSpeed = 15, kFront = 1.2, kRear = -1.4, kCentre = 0.294, kGravity = 9.81, kEnd = 9, kSprung = 1200;
const Matrix3 kAxle = rotation_about({1, 0, 0}, -M_PI / 2);  // z to the left

struct Corner {
  RigidBody *upright, *wheel;
  const Tyre* tyre;
};

/// One wheel, its wishbones, spring and tie rod; `rod` is where the tie rod meets rack or chassis.
struct Suspension {
  SystemGraph& graph;
  RigidBody& chassis;
  FirstOrderStates& carcasses;
  const TyreCoefficients tyre;
  const std::shared_ptr<const TyreRoad> road;
  double mass = 0;

  RigidBody& part(const std::string& name, double kg, const Vector3& inertia, const Vector3& at, double spin = 0) {
    mass += kg;
    return graph.add<RigidBody>(name, {.mass = kg,
                                       .inertia = inertia,
                                       .position = at,
                                       .orientation = spin != 0 ? kAxle : Matrix3(Matrix3::Identity()),
                                       .velocity = {kSpeed, 0, 0},
                                       .angular_velocity = {0, 0, spin}});
  }

  Corner draw(int place, double x, double side, double load, RigidBody& rod) {
    const std::string name = std::string(x > 0 ? "front " : "rear ") + (side > 0 ? "left" : "right");
    const auto at = [&](double along, double inwards, double up) {
      return Vector3(x + along, side * (0.75 - inwards), kCentre + up);
    };
    auto& upright = part(name + " upright", 12, {0.15, 0.15, 0.1}, at(0, 0.1, 0));
    auto& wheel = part(name + " wheel", 18, {0.55, 0.55, 0.95}, at(0, 0, 0), kSpeed / 0.307);
    graph.add<RevoluteJoint>(name + " hub", {upright.marker_at_world(at(0, 0, 0), kAxle), wheel.marker()});
    const auto wishbone = [&](const std::string& which, double height, double outer, double inner) -> RigidBody& {
      auto& arm = part(name + " " + which, 4, {0.04, 0.04, 0.06}, at(0, 0.5 * (outer + inner), height));
      const Vector3 ball = at(0, outer, 1.15 * height);
      graph.add<SphericalJoint>(name + " " + which + " ball",
                                {arm.marker_at_world(ball), upright.marker_at_world(ball)});
      for (const Vector3& pin : {at(-0.15, inner, height), at(0.15, inner, height)})
        graph.add<Bushing>(name + " " + which + (pin.x() > x ? " front" : " rear") + " bushing",
                           {chassis.marker_at_world(pin), arm.marker_at_world(pin)},
                           {.stiffness = Bushing::diagonal({3e6, 1e7, 1e7}, {2, 500, 500}),
                            .damping = Bushing::diagonal({3e3, 6e3, 6e3}, {0.2, 1, 1})});
      return arm;
    };
    auto& lower = wishbone("lower arm", -0.13, 0.10, 0.45);
    wishbone("upper arm", 0.13, 0.14, 0.40);
    // The spring's lever is 0.25 m of the arm's 0.35 m: 25 kN/m at the wheel.
    graph.add<SpringDamper>(name + " spring",
                            {lower.marker_at_world(at(0, 0.2, -0.13)), chassis.marker_at_world(at(0, 0.3, 0.35))},
                            {.stiffness = 5.1e4, .damping = 4.5e3, .preload = -1.43 * load});
    graph.add<DistanceJoint>(name + " tie rod",
                             {upright.marker_at_world(at(-0.12, 0.12, 0)), rod.marker_at_world(at(-0.12, 0.42, 0))});
    return {&upright, &wheel,
            &graph.add<Tyre>(name + " tyre", {graph.ground().marker(), wheel.marker(), carcasses.point(place)},
                             {.coefficients = tyre, .road = road, .mirrored = side < 0})};
  }
};

}  // namespace

int main() {
  // 1. Chassis, rack, and the road: a speed table of 5 cm with edges like a curb's, 20 m ahead.
  SystemGraph graph{{.gravity = {0, 0, -kGravity}}};
  auto& chassis = graph.add<RigidBody>(
      "chassis", {.mass = kSprung, .inertia = {400, 1700, 1900}, .position = {0, 0, 0.5}, .velocity = {kSpeed, 0, 0}});
  auto& carcasses = graph.add<FirstOrderStates>("carcasses", {.start = VectorX::Zero(12)});
  Suspension suspension{graph, chassis, carcasses, read_tir(LITHE_EXAMPLE_DATA "/tyres/car.tir"),
                        std::make_shared<TyreProfile>(TyreProfile::Parameters{
                            .x = {20, 20, 23, 23}, .heights = {0, 0.05, 0.05, 0}, .radius = 0.313})};
  auto& rack = suspension.part("rack", 4, {0.1, 0.01, 0.1}, {kFront - 0.12, 0, kCentre});
  const double wheelbase = kFront - kRear, front = kSprung * kGravity * -kRear / wheelbase / 2,
               rear = kSprung * kGravity * kFront / wheelbase / 2;
  const Corner corners[] = {suspension.draw(0, kFront, 1, front, rack), suspension.draw(1, kFront, -1, front, rack),
                            suspension.draw(2, kRear, 1, rear, chassis), suspension.draw(3, kRear, -1, rear, chassis)};

  // 2. Steering by the rack: left, right, left, and held to the left.
  auto& guide = graph.add<PrismaticJoint>(
      "guide", {chassis.marker_at_world({kFront - 0.12, 0, kCentre}, kAxle), rack.marker({}, kAxle)});
  graph.add<CoordinateDrive>(
      "steering", {guide.displacement()},
      {.motion = smooth_step(0, -3e-3, 3, 3.5) + smooth_step(0, 6e-3, 4, 4.8) + smooth_step(0, -6e-3, 5.3, 6.1)});

  // 3. Run.
  const auto load = [&](Snapshot& now, std::span<double> out) {
    out[0] = 0;
    for (const Corner& c : corners) out[0] += tyre_contact(*c.tyre).value(now, 6);
  };
  const auto steer = [&](Snapshot& now, std::span<double> out) {  // front against rear, which the bushings steer too
    const auto toe = [&](int i) { return angle_between(chassis.marker(), corners[i].upright->marker()); };
    out[0] = 0;
    for (int i = 0; i < 4; ++i) out[0] += (i < 2 ? 0.5 : -0.5) * coordinate(toe(i), "toe").value(now);
  };
  const machine::Outcome out = machine::run(graph, {.name = "car",
                                                    .title = "A car over a curb and through a slalom",
                                                    .duration = kEnd,
                                                    .interval = 0.018,
                                                    .tolerance = {1e-5, 1e-7},
                                                    .sensors = {position(chassis.marker(), "car"),
                                                                velocity(chassis.marker(), "car_v"),
                                                                angular_velocity(chassis.marker(), "turn"),
                                                                {"load", {"load"}, load, {"N"}},
                                                                {"steer", {"steer"}, steer, {"rad"}},
                                                                tyre_contact(*corners[0].tyre, "tyre")},
                                                    .draw = [&](Run& page) {
                                                      page.draw(chassis, visual::box({3.9, 1.2, 0.25}));
                                                      for (const Corner& c : corners)
                                                        page.draw(*c.wheel, visual::cylinder(0.313, 0.2));
                                                    }});

  // 4. Check.
  const auto last = [&](const std::string& column) { return machine::at(out.table, column, kEnd); };
  const double speed = std::hypot(last("car_v_x"), last("car_v_y")), yaw = last("turn_z"),
               total = kSprung + suspension.mass, unsprung = suspension.mass / 4 * kGravity;
  // Of both tyres of an axle at about the slip angle of the turn: cornering stiffness, and trail of the side force.
  const auto axle = [&](double on_spring) {
    MagicFormula::Slip slip{.alpha = 0.012, .load = on_spring + unsprung, .speed = kSpeed};
    const auto left = corners[0].tyre->formula().at(slip);
    slip.alpha *= -1;
    const auto right = corners[0].tyre->formula().at(slip);
    return std::pair((right.Fy - left.Fy) / 0.012, (left.Mz - right.Mz) / (right.Fy - left.Fy));
  };
  const auto [C_front, trail_front] = axle(front);
  const auto [C_rear, trail_rear] = axle(rear);
  const double a = kFront - trail_front, b = -kRear + trail_rear,
               gradient = total / (a + b) * (b / C_front - a / C_rear);
  const double expected = speed * last("steer") / (wheelbase + gradient * speed * speed);
  double mean = 0;
  for (const double F : out.table.column("load")) mean += F / static_cast<double>(out.table.row_count());
  std::printf("yaw rate %.4f rad/s (single-track model: %.4f); mean load %.0f N (weight: %.0f N)\n", yaw, expected,
              mean, total * kGravity);
  return out.good && std::abs(yaw / expected - 1) < 0.02 && std::abs(mean / (total * kGravity) - 1) < 2e-3 ? 0 : 1;
}
