// F11: a belt drive that is braked beyond what its friction can carry, and one that holds a torque: a fixed ratio never
// slips, friction smoothed over the speed always creeps.
#include "bodies/rigid_body.h"
#include "engine/observe/snapshot.h"
#include "joints/coordinate_coupling.h"
#include "joints/coordinate_drive.h"
#include "joints/forces/coordinate_motor.h"
#include "joints/revolute_joint.h"
#include "joints/rope/rope.h"
#include "tools/stability/bench.h"
#include "tools/stability/methods/ordinary.h"
#include "tools/stability/scenes/candidates.h"

namespace lithe::lab {
namespace {

constexpr double kR1 = 0.1, kR2 = 0.2, kAxles = 1, kInertia = 0.02;  // m, kg m²
constexpr double kFriction = 0.15, kEA = 1e5, kPretension = 100, kSpeed = 20;
/// Euler and Eytelwein: T₁/T₂ = e^(μα) on the smaller wheel, T₁ + T₂ as drawn.
const double kWrap = M_PI - 2 * std::asin((kR2 - kR1) / kAxles);
const double kCarried = 2 * kPretension * std::tanh(kFriction * kWrap / 2);  // N, T₁ - T₂

struct Wheels {
  RevoluteJoint *driver, *driven;
  Wheels(SystemGraph& graph, double speed) {
    const auto wheel = [&](const std::string& name, double x, double spin) {
      auto& body = graph.add<RigidBody>(
          name, {.inertia = {kInertia, kInertia, kInertia}, .position = {x, 0, 0}, .angular_velocity = {0, 0, spin}});
      return &graph.add<RevoluteJoint>(name + " pin", {graph.ground().marker({x, 0, 0}), body.marker()});
    };
    driver = wheel("driver", 0, speed), driven = wheel("driven", kAxles, speed * kR1 / kR2);
    graph.add<CoordinateDrive>("motor", {driver->angle()}, {.motion = ramp(0, speed)});
  }
};
Rope belt_of(SystemGraph& graph, const Wheels& wheels, double speed) {
  const auto pulley = [&](const RevoluteJoint& pin, double radius) {
    return RopePulley{.marker = pin.markers()[0], .radius = radius, .friction = kFriction, .wheel = pin.angle()};
  };
  return reeve(graph, "belt", {},
               {.pulleys = {pulley(*wheels.driver, kR1), pulley(*wheels.driven, kR2)},
                .axial_stiffness = kEA,
                .axial_damping = 1e3,
                .mass_per_length = 0.1,
                .pretension = kPretension,
                .speed = speed * kR1});
}

/// A brake that asks for 4 N m s of speed: at the speed of the belt twice what friction carries.
constexpr double kBrake = 4;
Finding of_carried(double force, std::vector<Figure> more, const std::string& why) {
  std::vector<Figure> figures{{"force on the braked wheel over what friction carries", force / kCarried}};
  figures.insert(figures.end(), more.begin(), more.end());
  return {judged(force / kCarried - 1, 0.01), figures, why};
}

Finding fixed_ratio() {
  RevoluteJoint* driven = nullptr;
  Bench scene(Vector3::Zero(), [&](SystemGraph& graph) {
    const Wheels wheels(graph, kSpeed);
    driven = wheels.driven;
    graph.add<CoordinateMotor>("brake", {driven->angle()},
                               {[](double, double, double speed) { return -kBrake * speed; }});
    graph.add<CoordinateCoupling>("belt", {wheels.driver->angle(), driven->angle()}, {.factors = {kR1, -kR2}});
  });
  const Method method = alpha_index2(1e-3);
  scene.run(*method, 1);
  Snapshot now(scene.system, scene.state);
  const double speed = coordinate_rate(driven->angle(), "w2").value(now);
  return of_carried(kBrake * speed / kR2, {}, "a coupling of the wheels carries any torque");
}

Finding braked(Integrator& method) {
  Rope belt;
  RevoluteJoint* driven = nullptr;
  Bench scene(Vector3::Zero(), [&](SystemGraph& graph) {
    const Wheels wheels(graph, kSpeed);
    driven = wheels.driven;
    graph.add<CoordinateMotor>("brake", {driven->angle()},
                               {[](double, double, double speed) { return -kBrake * speed; }});
    belt = belt_of(graph, wheels, kSpeed);
  });
  const auto course = scene.run(method, 2);
  if (!course.reached) return {Outcome::unstable, {{"stopped at, s", course.end}}, course.why};
  Snapshot now(scene.system, scene.state);
  const double slack = tension(belt, 0).value(now), tight = tension(belt, 1).value(now);
  const double slip = 1 - coordinate_rate(driven->angle(), "w2").value(now) * kR2 / (kSpeed * kR1);

  // The same belt at rest with four fifths of that torque, held for half a minute after it has settled.
  RevoluteJoint* held = nullptr;
  Bench resting(Vector3::Zero(), [&](SystemGraph& graph) {
    const Wheels wheels(graph, 0);
    held = wheels.driven;
    graph.add<CoordinateMotor>("torque", {held->angle()}, {[](double t, double, double speed) {
                                 return 0.8 * kCarried * kR2 * std::min(1.0, t) - 0.5 * speed;
                               }});
    belt_of(graph, wheels, 0);
  });
  const Method other = radau(1e-8).make();
  resting.run(*other, 5);
  Snapshot before(resting.system, resting.state);
  const double settled = coordinate(held->angle(), "a").value(before);
  resting.go_on(*other, 35);
  Snapshot after(resting.system, resting.state);
  const double drift = kR2 * (coordinate(held->angle(), "a").value(after) - settled);
  Finding found = of_carried(tight - slack,
                             {{"ratio of the tensions over e^(μα)", tight / slack / std::exp(kFriction * kWrap)},
                              {"slip of the driven wheel", slip},
                              {"drift in 30 s under 4/5 of it, m", drift},
                              {"steps", static_cast<double>(course.steps)}},
                             "");
  if (!(std::abs(drift) < 1e-6)) found.outcome = Outcome::inaccurate;
  return found;
}

/// One wheel, held by friction F tanh(v/v_d) against four fifths of F: m v̇ = 0.8 F - F tanh(v/v_d).
Finding smoothed(double v_d) {
  VectorX y = VectorX::Zero(2);
  const double mass = kInertia / (kR2 * kR2), h = 0.2 * mass * v_d / kCarried;
  const Rates rates = [=](double, const VectorX& x) {
    VectorX out(2);
    out << x[1], kCarried / mass * (0.8 - std::tanh(x[1] / v_d));
    return out;
  };
  // Its steady speed within 5 s; from there on it is constant.
  const double end = std::min(5.0, 2000 * h);
  for (double t = 0; t < end; t += h) y = rk4_step(rates, t, y, h);
  const double drift = 30 * y[1];
  return {judged(drift, 1e-6),
          {{"drift in 30 s under 4/5 of the torque, m", drift}, {"by v_d atanh(4/5)", 30 * v_d * std::atanh(0.8)}},
          "smoothed over the speed, friction holds nothing at rest"};
}

const Registered scene{
    with_candidates({"F11",
                     "a belt that slips",
                     {{"fixed ratio of the wheels", fixed_ratio, Role::also},
                      {"friction smoothed by tanh(v/0.01)", [] { return smoothed(0.01); }, Role::also}}},
                    {automatic(1e-7), radau(1e-7), alpha(2e-4)}, {1e-7, 2e-4}, braked)};

}  // namespace
}  // namespace lithe::lab
