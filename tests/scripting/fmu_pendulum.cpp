// A rigid pendulum under a torque, on a spring: a scene of tests/scripting/fmu_test.cpp.
#include "lithe/lithe.h"

using namespace lithe;

StudyScene scene() {
  return {
      .name = "pendulum", .duration = 2, .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
        const Matrix3 along_y = rotation_about({1, 0, 0}, -M_PI / 2);
        auto& torque = graph.add<Input>("torque", {.unit = "N m", .lower = -3, .upper = 3});
        auto& stiffness = graph.add<Input>("stiffness", {.value = 2, .lower = 0, .parameter = true});
        auto& target = graph.add<Input>("target", {.unit = "rad", .between = Input::Between::linear});
        auto& rod = graph.add<RigidBody>("rod", {.mass = 1, .inertia = {0.01, 0.03, 0.03}, .position = {0.3, 0, 0}});
        auto& pin =
            graph.add<RevoluteJoint>("pin", {graph.ground().marker({}, along_y), rod.marker({-0.3, 0, 0}, along_y)});
        auto& memory = graph.add<IntegralState>("memory");
        graph.add<CoordinateMotor>("motor", {pin.angle()}, {.effort = torque});
        graph.add<CoordinateSpring>("spring", {pin.angle()}, {.stiffness = stiffness});
        graph.add<PidController>("servo", {pin.angle(), memory.coordinate()},
                                 {.target = target, .proportional = 5, .integral = 3, .derivative = 0.5});
        graph.add<CoordinateStop>("stop", {pin.angle()}, {.lower = -2, .upper = 2, .stiffness = 100});  // not reached
        return {coordinate(pin.angle(), "angle"), position(rod.marker({0.3, 0, 0}), "tip"), joint_reaction(pin, "pin"),
                total_energy("energy")};
      }};
}
