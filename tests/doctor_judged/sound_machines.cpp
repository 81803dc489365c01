#include "engine/observe/sensors.h"
#include "joints/coordinate_coupling.h"
#include "joints/coordinate_drive.h"
#include "joints/fixed_joint.h"
#include "joints/forces/coordinate_motor.h"
#include "joints/forces/coordinate_spring.h"
#include "joints/forces/coordinate_stop.h"
#include "joints/forces/joint_friction.h"
#include "joints/gear_pair.h"
#include "joints/prismatic_joint.h"
#include "joints/revolute_joint.h"
#include "joints/universal_joint.h"
#include "tests/doctor_judged/machines.h"
#include "tests/doctor_judged/seeded_errors.h"

namespace lithe::test {
std::vector<JudgedScene> sound_machines() {
  return {
      {{.name = "a four-bar of hinges, whose rows repeat each other as in every planar mechanism",
        .duration = 2,
        .draw = [](SystemGraph& graph) { return draw_four_bar(graph); }}},
      {{.name = "a door on two hinges",
        .duration = 2,
        .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
          const auto [lower, upper] = add_door(graph);
          graph.add<CoordinateSpring>("closer", {lower.angle()}, {.stiffness = 12, .damping = 9, .free_value = 1.2});
          return {coordinate(lower.angle(), "angle")};
        }}},
      {{.name = "a slider-crank, driven from rest",
        .duration = 2,
        .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
          const auto [main, piston] = add_slider_crank(graph, {0, 0, 0.1}, {0.3, 0, 0});
          graph.add<CoordinateDrive>("motor", {main.angle()}, {.motion = smooth_step(0, 15, 0, 2)});
          return {position(piston.marker(), "piston")};
        }}},
      {{.name = "a robot's arm with a drive on each joint",
        .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
          const Vector3 elbow{0.4, 0, 0.2}, hand{0.8, 0, 0.1};
          auto& upper = add_rod(graph, "upper arm", kO, elbow, 6);
          auto& lower = add_rod(graph, "forearm", elbow, hand, 4);
          auto& a = tie<RevoluteJoint>(graph, "shoulder", graph.ground(), upper, kO);
          auto& b = tie<RevoluteJoint>(graph, "elbow", upper, lower, elbow);
          graph.add<CoordinateDrive>("first", {a.angle()}, {.motion = smooth_step(0, -0.8, 0, 1)});
          graph.add<CoordinateDrive>("second", {b.angle()}, {.motion = smooth_step(0, 1.1, 0, 0.7)});
          return {position(lower.marker_at_world(hand), "hand")};
        }}},
      {{.name = "a planetary gear with two planets, one of which is redundant",
        .gravity = {0, 0, 0},
        .characteristic_length = 0.1,
        .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
          auto& sun = graph.add<RigidBody>("sun", {.mass = 0.3, .inertia = {4e-5, 4e-5, 6e-5}});
          auto& carrier = graph.add<RigidBody>("carrier", {.inertia = {1e-3, 1e-3, 2e-3}});
          auto& shaft = tie<RevoluteJoint>(graph, "sun shaft", graph.ground(), sun, kO, kUp);
          auto& output = tie<RevoluteJoint>(graph, "output shaft", graph.ground(), carrier, kO, kUp);
          for (int i : {0, 1}) {
            const std::string number = std::to_string(i);
            const Vector3 centre{i == 0 ? 0.06 : -0.06, 0, 0};
            auto& planet = graph.add<RigidBody>("planet " + number,
                                                {.mass = 0.5, .inertia = {2e-4, 2e-4, 4e-4}, .position = centre});
            tie<RevoluteJoint>(graph, "planet pin " + number, carrier, planet, centre, kUp);
            graph.add<GearPair>("sun mesh " + number, {sun.marker(), planet.marker()},
                                {.radius_A = 0.02, .radius_B = 0.04});
            graph.add<GearPair>("ring mesh " + number, {graph.ground().marker(), planet.marker()},
                                {.radius_A = 0.1, .radius_B = -0.04});
          }
          graph.add<CoordinateMotor>("motor", {shaft.angle()}, {[](double, double, double w) { return 2 - 0.01 * w; }});
          graph.add<CoordinateSpring>("load", {output.angle()}, {.damping = 0.5});
          return {coordinate(output.angle(), "output")};
        }}},
      {{.name = "a fan behind a belt runs up",
        .duration = 3,
        .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
          const Vector3 beside{0.5, 0, 0};
          auto& motor = graph.add<RigidBody>("motor", {.mass = 9, .inertia = {0.02, 0.02, 0.03}});
          auto& fan = graph.add<RigidBody>("fan", {.mass = 4, .inertia = {0.05, 0.05, 0.1}, .position = beside});
          auto& one = tie<RevoluteJoint>(graph, "motor shaft", graph.ground(), motor, kO);
          auto& two = tie<RevoluteJoint>(graph, "fan shaft", graph.ground(), fan, beside);
          graph.add<CoordinateCoupling>("belt", {one.angle(), two.angle()}, {.factors = {1, -2.5}});
          graph.add<CoordinateMotor>("torque", {one.angle()}, {[](double, double, double w) { return 20 - 0.1 * w; }});
          graph.add<CoordinateMotor>("air", {two.angle()},
                                     {[](double, double, double w) { return -1e-3 * w * std::abs(w); }});
          return {coordinate_rate(two.angle(), "fan")};
        }}},
      {{.name = "an arm falls onto its stop and rests there",
        .duration = 3,
        .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
          auto& arm = add_rod(graph, "arm", kO, {0.5, 0, 0}, 2);
          auto& pin = tie<RevoluteJoint>(graph, "pin", graph.ground(), arm, kO);
          graph.add<CoordinateStop>("stop", {pin.angle()}, {.upper = 0.5, .stiffness = 5e4, .dissipation = 2});
          return {height(arm.marker(), "arm")};
        }}},
      {{.name = "a pendulum with friction in its bearing",
        .duration = 3,
        .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
          auto& arm = add_rod(graph, "arm", kO, {0.5, 0, 0}, 2);
          auto& pin = tie<RevoluteJoint>(graph, "pin", graph.ground(), arm, kO);
          graph.add<JointFriction>("rub", {pin.angle()},
                                   {.joint = &pin, .coefficient = 0.15, .creep_speed = 3e-3, .radius = 8e-3});
          return {height(arm.marker(), "arm")};
        }}},
      {{.name = "a chaotic double pendulum, for two seconds",
        .duration = 2,
        .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
          const Vector3 elbow{0.2, 0, 0.25}, tip{0.2, 0, 0.6};
          auto& first = add_rod(graph, "first", kO, elbow);
          auto& second = add_rod(graph, "second", elbow, tip);
          tie<RevoluteJoint>(graph, "top", graph.ground(), first, kO);
          tie<RevoluteJoint>(graph, "elbow", first, second, elbow);
          return {position(second.marker_at_world(tip), "tip")};
        }},
       "automatic",
       1e-9},
      {{.name = "a cardan shaft bent by 20 degrees turns at 100 rad/s",
        .duration = 0.3,
        .gravity = {0, 0, 0},
        .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
          const Matrix3 bent = rotation_about(kAcross, 0.35);
          const Vector3 end = bent * Vector3(0, 0, 0.3);
          auto& input =
              graph.add<RigidBody>("input", {.mass = 5, .inertia = {0.02, 0.02, 0.005}, .position = {0, 0, -0.3}});
          auto& output = graph.add<RigidBody>(
              "output", {.mass = 5, .inertia = {0.02, 0.02, 0.005}, .position = end, .orientation = bent});
          auto& bearing = tie<RevoluteJoint>(graph, "bearing", graph.ground(), input, {0, 0, -0.3}, kUp);
          graph.add<UniversalJoint>("cardan", {input.marker({0, 0, 0.3}), output.marker({0, 0, -0.3})});
          auto& far = tie<RevoluteJoint>(graph, "far bearing", graph.ground(), output, end, bent.col(2));
          graph.add<CoordinateDrive>("motor", {bearing.angle()}, {.motion = smooth_step(0, 30, 0, 0.6)});
          return {coordinate(far.angle(), "output")};
        }}},
      {{.name = "a turned hand on an arm, whose marker is turned alike",
        .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
          const Matrix3 yaw = rotation_about(kUp, 0.5), pitch = rotation_about(kAcross, 0.7);
          return {position(add_hand(graph, yaw, pitch, yaw * pitch).marker({0, 0.1, 0}), "finger")};
        }}},
      {{.name = "gears and a belt that agree: one of them is spare",
        .gravity = {0, 0, 0},
        .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
          const auto [one, two] = add_meshed_shafts(graph);
          graph.add<CoordinateCoupling>("crossed belt", {one.angle(), two.angle()}, {.factors = {1, 1}});
          graph.add<CoordinateMotor>("motor", {one.angle()}, {[](double, double, double w) { return 1 - w; }});
          return {coordinate(one.angle(), "input")};
        }}},
  };
}

}  // namespace lithe::test
