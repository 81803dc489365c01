#include "engine/observe/sensors.h"
#include "joints/coordinate_drive.h"
#include "joints/distance_joint.h"
#include "joints/forces/coordinate_motor.h"
#include "joints/forces/coordinate_spring.h"
#include "joints/forces/joint_friction.h"
#include "joints/forces/spring_damper.h"
#include "joints/forces/user_force.h"
#include "joints/gear_pair.h"
#include "joints/prismatic_joint.h"
#include "joints/revolute_joint.h"
#include "joints/spherical_joint.h"
#include "tests/doctor_judged/machines.h"
#include "tests/doctor_judged/seeded_errors.h"

/// Written when the rules had been mended for the first round, and not looked at by the doctor before.
namespace lithe::test {
namespace {

RigidBody& add_rotor(SystemGraph& graph, double speed) {
  return graph.add<RigidBody>("rotor", {.mass = 4, .inertia = {0.02, 0.02, 0.03}, .angular_velocity = {0, 0, speed}});
}

}  // namespace

std::vector<SeededError> errors_of_second_round() {
  return {
      {{{.name = "a connecting rod is too short for its crank to go round",
         .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
           const auto [main, piston] = add_slider_crank(graph, {0.07, 0, 0.07}, {0.12, 0, 0});
           graph.add<CoordinateDrive>("motor", {main.angle()}, {.motion = smooth_step(0, -3, 0, 1)});
           return {position(piston.marker(), "piston")};
         }}},
       {Cause::incompatible_drive},
       {{"motor"}}},
      {{{.name = "a marker in millimetres",
         .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
           auto& arm = add_rod(graph, "arm", kO, {0.3, 0, 0});
           graph.add<RevoluteJoint>(
               "shoulder", {graph.ground().marker(kO, axes_of(kAcross)), arm.marker({-150, 0, 0}, axes_of(kAcross))});
           return {height(arm.marker(), "arm")};
         }}},
       {Cause::open_joint, Cause::bad_unit},
       {{"shoulder"}}},
      {{{.name = "the wake of a sail is a root that turns negative as it sinks",
         .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
           auto& arm = add_rod(graph, "arm", kO, {0.6, 0, 0});
           tie<RevoluteJoint>(graph, "pin", graph.ground(), arm, kO);
           graph.add<UserForce>("wake", {arm.marker({0.3, 0, 0})}, {[](double, const MarkerView& m) {
                                  return force({0, 0, 0.1 * std::sqrt(m.p.z() + 0.4)});
                                }});
           return {height(arm.marker(), "arm")};
         }}},
       {Cause::no_number},
       {{"wake"}}},
      {{{.name = "a motor was copied",
         .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
           auto& shaft = tie<RevoluteJoint>(graph, "shaft", graph.ground(), add_rotor(graph, 0), kO, kUp);
           for (const char* name : {"motor", "motor 2"})
             graph.add<CoordinateMotor>(name, {shaft.angle()}, {[](double, double, double w) { return 3 - w; }});
           return {coordinate_rate(shaft.angle(), "speed")};
         }}},
       {},
       {{"motor 2"}, {"twice", "same", "duplicate", "copy"}}},
      {{{.name = "a dashpot as a user's force, of the wrong sign",
         .duration = 3,
         .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
           auto& block = graph.add<RigidBody>("block", {.mass = 2, .inertia = {0.1, 0.1, 0.1}});
           auto& slide = tie<PrismaticJoint>(graph, "slide", graph.ground(), block, kO, kAlong);
           graph.add<CoordinateSpring>("spring", {slide.displacement()}, {.stiffness = 800, .free_value = 0.01});
           graph.add<UserForce>("dashpot", {block.marker()},
                                {[](double, const MarkerView& m) { return force(25 * m.v); }});
           return {position(block.marker(), "block")};
         }}},
       {},
       {{"dashpot"}, {"sign", "grow", "energy", "negative damping"}}},
      {{{.name = "a relay switches without a band",
         .duration = 2,
         .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
           auto& shaft = tie<RevoluteJoint>(graph, "shaft", graph.ground(), add_rotor(graph, 0), kO, kUp);
           graph.add<CoordinateMotor>("relay", {shaft.angle()}, {[](double t, double x, double w) {
                                        return (x + 0.1 * w > 0.3 * std::sin(t) ? -5.0 : 5.0);
                                      }});
           return {coordinate(shaft.angle(), "angle")};
         }}},
       {Cause::discontinuity},
       {{"relay"}}},
      {{{.name = "the forearm's velocity forgets that of the elbow",
         .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
           auto& upper = graph.add<RigidBody>("upper", {.mass = 2,
                                                        .inertia = {1e-3, 0.02, 0.02},
                                                        .position = {0.2, 0, 0},
                                                        .velocity = {0, 0, -0.6},
                                                        .angular_velocity = {0, 3, 0}});
           auto& forearm = graph.add<RigidBody>(
               "forearm", {.inertia = {1e-3, 0.01, 0.01}, .position = {0.55, 0, 0}, .angular_velocity = {0, 3, 0}});
           tie<RevoluteJoint>(graph, "shoulder", graph.ground(), upper, kO);
           tie<RevoluteJoint>(graph, "elbow", upper, forearm, {0.4, 0, 0});
           return {position(forearm.marker(), "forearm")};
         }}},
       {Cause::inconsistent_start},
       {{"elbow"}, {"velocit"}}},
      {{{.name = "a knuckle of a microgram between two beams of tons",
         .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
           const Vector3 near{2, 0, 0}, far{2.01, 0, 0}, tip{4, 0, 0};
           auto& first = add_rod(graph, "first", kO, near, 3000);
           auto& knuckle = add_rod(graph, "knuckle", near, far, 1e-9);
           auto& second = add_rod(graph, "second", far, tip, 3000);
           tie<RevoluteJoint>(graph, "foot", graph.ground(), first, kO);
           tie<RevoluteJoint>(graph, "pin", first, knuckle, near);
           tie<RevoluteJoint>(graph, "bolt", knuckle, second, far);
           return {height(second.marker(), "second")};
         }}},
       {Cause::mass_ratio, Cause::bad_unit},
       {{"knuckle"}}},
      {{{.name = "a clock spring on a fast rotor under steps of more than a turn",
         .duration = 2,
         .gravity = {0, 0, 0},
         .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
           auto& shaft = tie<RevoluteJoint>(graph, "shaft", graph.ground(), add_rotor(graph, 200), kO, kUp);
           graph.add<CoordinateSpring>("clock spring", {shaft.angle()}, {.stiffness = 1e-4});
           return {coordinate_rate(shaft.angle(), "speed")};
         }},
        "generalized-alpha index 3, fixed step",
        0.02},
       {Cause::lost_turns, Cause::step_too_large},
       {{"step"}}},
      {{{.name = "a planet is pinned to the ground instead of the carrier",
         .gravity = {0, 0, 0},
         .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
           const Vector3 centre{0.06, 0, 0};
           auto& sun = graph.add<RigidBody>("sun", {.mass = 0.3, .inertia = {4e-5, 4e-5, 6e-5}});
           auto& carrier = graph.add<RigidBody>("carrier", {.inertia = {1e-3, 1e-3, 2e-3}});
           auto& planet =
               graph.add<RigidBody>("planet", {.mass = 0.5, .inertia = {2e-4, 2e-4, 4e-4}, .position = centre});
           auto& shaft = tie<RevoluteJoint>(graph, "sun shaft", graph.ground(), sun, kO, kUp);
           auto& output = tie<RevoluteJoint>(graph, "output shaft", graph.ground(), carrier, kO, kUp);
           tie<RevoluteJoint>(graph, "planet pin", graph.ground(), planet, centre, kUp);
           graph.add<GearPair>("sun mesh", {sun.marker(), planet.marker()}, {.radius_A = 0.02, .radius_B = 0.04});
           graph.add<GearPair>("ring mesh", {graph.ground().marker(), planet.marker()},
                               {.radius_A = 0.1, .radius_B = -0.04});
           graph.add<CoordinateMotor>("motor", {shaft.angle()}, {[](double, double, double w) { return 2 - w; }});
           return {coordinate(output.angle(), "output")};
         }}},
       {Cause::locked},
       {{"planet", "sun"}}},
  };
}

std::vector<JudgedScene> sound_second_round() {
  return {
      {{.name = "a boom held by a guy carries a swinging load",
        .duration = 2,
        .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
          const Vector3 head{6, 0, 5};
          auto& boom = add_rod(graph, "boom", kO, head, 300);
          auto& load = graph.add<RigidBody>("load", {.mass = 900, .inertia = {90, 90, 90}, .position = {7, 0, 1}});
          tie<RevoluteJoint>(graph, "foot", graph.ground(), boom, kO);
          graph.add<DistanceJoint>("guy", {graph.ground().marker({-3, 0, 5}), boom.marker_at_world(head)}, {});
          graph.add<DistanceJoint>("rope", {boom.marker_at_world(head), load.marker()}, {});
          return {position(load.marker(), "load")};
        }}},
      {{.name = "a self-excited oscillator on its way to its limit cycle",
        .duration = 8,
        .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
          auto& block = graph.add<RigidBody>("block", {.inertia = {0.1, 0.1, 0.1}, .velocity = {0.1, 0, 0}});
          auto& slide = tie<PrismaticJoint>(graph, "slide", graph.ground(), block, kO, kAlong);
          graph.add<CoordinateSpring>("spring", {slide.displacement()}, {.stiffness = 25});
          graph.add<CoordinateMotor>("valve", {slide.displacement()},
                                     {[](double, double x, double v) { return 2 * (1 - 25 * x * x) * v; }});
          return {coordinate(slide.displacement(), "x")};
        }}},
      {{.name = "a disc brake on a flywheel, pressed by 400 N",
        .duration = 2,
        .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
          auto& shaft = tie<RevoluteJoint>(graph, "shaft", graph.ground(), add_rotor(graph, 60), kO, kUp);
          graph.add<JointFriction>("pads", {shaft.angle()},
                                   {.joint = &shaft, .coefficient = 0.4, .radius = 0.15, .preload = 40});
          return {coordinate_rate(shaft.angle(), "speed")};
        }}},
      {{.name = "a table on four springs alike",
        .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
          auto& table = graph.add<RigidBody>("table", {.mass = 40, .inertia = {4, 5, 8}, .position = {0, 0, 0.3}});
          for (int i = 0; i < 4; ++i) {
            const Vector3 foot{i % 2 ? 0.5 : -0.5, i / 2 ? 0.4 : -0.4, 0};
            graph.add<SpringDamper>("leg " + std::to_string(i), {graph.ground().marker(foot), table.marker(foot)},
                                    {.stiffness = 6000, .damping = 120});
          }
          return {height(table.marker(), "table")};
        }}},
      {{.name = "a joint held by a drive that stands still, beside a pendulum",
        .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
          auto& arm = graph.add<RigidBody>("carriage", {.mass = 5, .inertia = {0.1, 0.1, 0.1}});
          auto& pendulum = add_rod(graph, "pendulum", {0, 0.3, 0}, {0.4, 0.3, 0});
          auto& slide = tie<PrismaticJoint>(graph, "slide", graph.ground(), arm, kO, kAlong);
          graph.add<CoordinateDrive>("hold", {slide.displacement()}, {.motion = constant(0)});
          tie<RevoluteJoint>(graph, "pin", graph.ground(), pendulum, {0, 0.3, 0});
          return {height(pendulum.marker(), "pendulum")};
        }}},
      {{.name = "two satellites drift apart on a weak tether",
        .duration = 20,
        .gravity = {0, 0, 0},
        .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
          auto& a = graph.add<RigidBody>("a", {.mass = 200, .inertia = {20, 30, 30}});
          auto& b = graph.add<RigidBody>(
              "b", {.mass = 100, .inertia = {10, 10, 10}, .position = {1, 0, 0}, .velocity = {0.4, 0, 0.01}});
          graph.add<SpringDamper>("tether", {a.marker(), b.marker()}, {.stiffness = 0.02, .damping = 0.1});
          return {position(b.marker(), "b")};
        }}},
      {{.name = "a turbine whose torque rises with its speed, up to a load",
        .duration = 4,
        .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
          auto& shaft = tie<RevoluteJoint>(graph, "shaft", graph.ground(), add_rotor(graph, 5), kO, kUp);
          graph.add<CoordinateMotor>("blades", {shaft.angle()},
                                     {[](double, double, double w) { return 0.1 * w / (1 + w * w / 900); }});
          graph.add<CoordinateSpring>("load", {shaft.angle()}, {.damping = 0.02});
          return {coordinate_rate(shaft.angle(), "speed")};
        }}},
      {{.name = "a dumbbell on a long boom in orbit, a flywheel at its middle",
        .duration = 3,
        .gravity = {0, 0, 0},
        .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
          auto& boom =
              graph.add<RigidBody>("boom", {.mass = 60, .inertia = {0.5, 6000, 6000}, .angular_velocity = {0, 0, 0.1}});
          auto& wheel = graph.add<RigidBody>(
              "wheel", {.mass = 8, .inertia = {0.05, 0.05, 0.09}, .angular_velocity = {0, 0, 90.1}});
          auto& axle = tie<RevoluteJoint>(graph, "axle", boom, wheel, kO, kUp);
          graph.add<CoordinateSpring>("bearing", {axle.angle()}, {.damping = 1e-3});
          return {coordinate_rate(axle.angle(), "speed")};
        }}},
      {{.name = "a top view of a clock: gravity lies along y",
        .duration = 2,
        .gravity = {0, -9.81, 0},
        .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
          auto& hand = add_rod(graph, "hand", kO, {0.3, 0, 0}, 0.1);
          tie<RevoluteJoint>(graph, "pin", graph.ground(), hand, kO, kUp);
          return {position(hand.marker({0.15, 0, 0}), "tip")};
        }}},
      {{.name = "a heavy point on a thin thread: its inertia is next to nothing",
        .duration = 2,
        .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
          auto& bob =
              graph.add<RigidBody>("bob", {.mass = 1, .inertia = {1e-6, 1e-6, 1e-6}, .position = {0.6, 0, -0.8}});
          graph.add<DistanceJoint>("thread", {graph.ground().marker(), bob.marker()}, {});
          return {position(bob.marker(), "bob")};
        }}},
  };
}

}  // namespace lithe::test
