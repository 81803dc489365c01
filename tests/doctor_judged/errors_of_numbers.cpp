#include "engine/observe/sensors.h"
#include "joints/contact/contact.h"
#include "joints/fixed_joint.h"
#include "joints/forces/bushing.h"
#include "joints/forces/coordinate_motor.h"
#include "joints/forces/coordinate_spring.h"
#include "joints/forces/joint_friction.h"
#include "joints/forces/spring_damper.h"
#include "joints/forces/user_force.h"
#include "joints/prismatic_joint.h"
#include "joints/revolute_joint.h"
#include "tests/doctor_judged/seeded_errors.h"

namespace lithe::test {
namespace {

const Vector3 kElbow{0.3, 0, 0}, kTip{0.6, 0, 0};

/// Two arms that hang from a shoulder, let go level; the first one as given.
std::vector<Sensor> draw_arms(SystemGraph& graph, RigidBody& upper) {
  auto& lower = add_rod(graph, "lower arm", kElbow, kTip, 0.4);
  tie<RevoluteJoint>(graph, "shoulder", graph.ground(), upper, kO);
  tie<RevoluteJoint>(graph, "elbow", upper, lower, kElbow);
  return {position(lower.marker_at_world(kTip), "tip")};
}
std::vector<Sensor> draw_plain_arms(SystemGraph& graph) {
  return draw_arms(graph, add_rod(graph, "upper arm", kO, kElbow, 0.4));
}

/// A quarter of a car on its strut, 0.3 m long.
std::vector<Sensor> draw_quarter_car(SystemGraph& graph, double stiffness, bool copied) {
  auto& body = graph.add<RigidBody>("body", {.mass = 250, .inertia = {20, 60, 60}, .position = {0, 0, 0.3}});
  tie<PrismaticJoint>(graph, "rail", graph.ground(), body, {0, 0, 0.3}, kUp);
  const SpringDamper::Parameters strut{.stiffness = stiffness, .damping = 1200};
  graph.add<SpringDamper>("strut", {graph.ground().marker(), body.marker()}, strut);
  if (copied) graph.add<SpringDamper>("strut_1", {graph.ground().marker(), body.marker()}, strut);
  return {height(body.marker(), "body")};
}

}  // namespace

std::vector<SeededError> errors_of_numbers() {
  return {
      {{{.name = "an inertia in kg mm² beside masses in kg",
         .draw =
             [](SystemGraph& graph) {
               return draw_arms(
                   graph, graph.add<RigidBody>("upper arm",
                                               {.mass = 0.4, .inertia = {30, 3000, 3000}, .position = {0.15, 0, 0}}));
             }}},
       {Cause::bad_unit},
       {{"upper arm"}}},
      {{{.name = "a mass in grams beside an inertia in kg m²",
         .draw =
             [](SystemGraph& graph) {
               return draw_arms(
                   graph, graph.add<RigidBody>("upper arm",
                                               {.mass = 400, .inertia = {3e-5, 3e-3, 3e-3}, .position = {0.15, 0, 0}}));
             }}},
       {Cause::bad_unit},
       {{"upper arm"}}},
      {{{.name = "mass and inertia of a link of 50 mm are left at 1",
         .characteristic_length = 0.05,
         .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
           auto& lever = add_rod(graph, "lever", kO, {0.05, 0, 0}, 0.02);
           auto& link = graph.add<RigidBody>("link", {.position = {0.05, 0, -0.025}});
           tie<RevoluteJoint>(graph, "pivot", graph.ground(), lever, kO);
           tie<RevoluteJoint>(graph, "eye", lever, link, {0.05, 0, 0});
           return {position(link.marker_at_world({0.05, 0, -0.05}), "hook")};
         }}},
       {Cause::bad_unit},
       {{"link"}}},
      {{{.name = "a strut's stiffness in N/mm",
         .characteristic_length = 0.3,
         .draw = [](SystemGraph& graph) { return draw_quarter_car(graph, 20, false); }}},
       {Cause::bad_unit},
       {{"strut"}}},
      {{{.name = "a strut is drawn twice",
         .characteristic_length = 0.3,
         .draw = [](SystemGraph& graph) { return draw_quarter_car(graph, 2e4, true); }}},
       {},
       {{"strut_1"}, {"twice", "same", "duplicate", "copy"}}},
      {{{.name = "gravity in mm/s²", .gravity = {0, 0, -9810}, .draw = draw_plain_arms}},
       {Cause::bad_unit},
       {{"gravity"}}},
      {{{.name = "a bushing with Young's modulus for its stiffness, under an explicit method",
         .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
           auto& engine = graph.add<RigidBody>("engine", {.mass = 120, .inertia = {5, 9, 9}});
           graph.add<Bushing>("mount", {graph.ground().marker(), engine.marker({0.1, 0.2, -0.3})},
                              {.stiffness = Bushing::diagonal({2e11, 2e11, 2e11}, {2e3, 2e3, 2e3})});
           return {height(engine.marker(), "engine")};
         }},
        "explicit Runge-Kutta 5(4)"},
       {Cause::stiff, Cause::bad_unit},
       {{"mount"}}},
      {{{.name = "a brake whose torque has the wrong sign",
         .duration = 2,
         .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
           auto& rotor = graph.add<RigidBody>(
               "rotor", {.mass = 3, .inertia = {0.01, 0.01, 0.02}, .angular_velocity = {0, 0, 50}});
           auto& shaft = tie<RevoluteJoint>(graph, "shaft", graph.ground(), rotor, kO, kUp);
           graph.add<CoordinateMotor>("brake", {shaft.angle()}, {[](double, double, double w) { return 0.4 * w; }});
           return {coordinate_rate(shaft.angle(), "speed")};
         }}},
       {},
       {{"brake"}, {"sign", "grow", "energy", "negative damping"}}},
      {{{.name = "a ball is drawn half inside the floor",
         .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
           auto& ball =
               graph.add<RigidBody>("ball", {.mass = 4, .inertia = {0.016, 0.016, 0.016}, .position = {0, 0, 0.05}});
           graph.add<Contact>("floor",
                              {{graph.ground().marker(), shape::half_space()}, {ball.marker(), shape::sphere(0.1)}},
                              {.law = Compliance{.stiffness = 1e7, .restitution = 0.5}});
           return {height(ball.marker(), "ball")};
         }}},
       {},
       {{"floor", "ball"}, {"overlap", "penetrat", "inside", "into each other", "deep"}}},
      {{{.name = "a double pendulum under steps of 80 ms", .duration = 2, .draw = draw_plain_arms}, "RATTLE", 0.08},
       {Cause::step_too_large},
       {{"step"}}},
      {{{.name = "a swing under a tolerance of 0.3",
         .duration = 4,
         .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
           auto& arm = add_rod(graph, "arm", kO, {0.6, 0, 0});
           tie<RevoluteJoint>(graph, "pin", graph.ground(), arm, kO);
           return {height(arm.marker(), "arm")};
         }},
        "explicit Runge-Kutta 5(4)",
        0.3},
       {Cause::step_too_large},
       {{"tolerance"}}},
      {{{.name = "a sensor divides by a speed that is zero at first",
         .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
           auto& wheel = graph.add<RigidBody>("wheel", {.mass = 12, .inertia = {0.4, 0.7, 0.4}});
           auto& axle = tie<RevoluteJoint>(graph, "axle", graph.ground(), wheel, kO);
           graph.add<CoordinateMotor>("motor", {axle.angle()}, {[](double, double, double w) { return 5 - w; }});
           return {coordinate(axle.angle(), "angle"),
                   Sensor{"slip", {"slip"}, [rim = wheel.marker({0, 0, 0.3})](Snapshot& now, std::span<double> out) {
                            const double speed = now.marker(rim).v.x();
                            out[0] = (now.marker(rim).w.y() * 0.31 - speed) / speed;
                          }}};
         }}},
       {Cause::no_number},
       {{"slip"}}},
      {{{.name = "a bearing's friction radius in mm",
         .duration = 2,
         .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
           auto& arm = add_rod(graph, "arm", kO, {0.5, 0, 0});
           auto& pin = tie<RevoluteJoint>(graph, "pin", graph.ground(), arm, kO);
           graph.add<JointFriction>("rub", {pin.angle()}, {.joint = &pin, .coefficient = 0.1, .radius = 8});
           return {height(arm.marker(), "arm")};
         }}},
       {Cause::bad_unit, Cause::locked},
       {{"rub"}}},
  };
}

}  // namespace lithe::test
