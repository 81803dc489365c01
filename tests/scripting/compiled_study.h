#pragma once

#include "bodies/rigid_body.h"
#include "engine/base/rotations.h"
#include "engine/study/study.h"
#include "joints/forces/coordinate_motor.h"
#include "joints/forces/coordinate_spring.h"
#include "joints/prismatic_joint.h"
#include "joints/revolute_joint.h"
#include "joints/spherical_joint.h"

namespace lithe::test {

/// An arm on a hinge with a motor, a bob on a ball, and a slider on a spring, its torque and stiffness Inputs: what a
/// compiled scene may hold, drawn both here and by the command.
inline StudyScene compiled_study() {
  return {
      .name = "arm", .duration = 1, .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
        const auto& torque = graph.add<Input>("torque", {.value = 0.7});
        const auto& stiffness = graph.add<Input>("stiffness", {.value = 60});
        auto& arm = graph.add<RigidBody>("arm", {.mass = 1.2, .inertia = {0.02, 0.12, 0.11}, .position = {0.5, 0, 0}});
        auto& bob = graph.add<RigidBody>("bob", {.mass = 0.8,
                                                 .inertia = {0.03, 0.02, 0.025},
                                                 .position = {1.1, 0.2, -0.3},
                                                 .angular_velocity = {1, 3, -2}});
        auto& slider =
            graph.add<RigidBody>("slider", {.mass = 0.5, .inertia = {0.004, 0.005, 0.006}, .position = {0.4, 0, 0.1}});
        const Matrix3 axes = axes_along({0, 1, 0.2}), along = axes_along({1, 0, 0.1});
        auto& pin =
            graph.add<RevoluteJoint>("pin", {graph.ground().marker({0, 0, 0}, axes), arm.marker({-0.5, 0, 0}, axes)});
        graph.add<SphericalJoint>("ball", {bob.marker({-0.1, -0.2, 0.3}), arm.marker({0.5, 0, 0})});
        auto& slide =
            graph.add<PrismaticJoint>("slide", {slider.marker({0, 0, -0.1}, along), arm.marker({-0.1, 0, 0}, along)});
        graph.add<CoordinateMotor>("motor", {pin.angle()}, {.effort = torque});
        graph.add<CoordinateSpring>("friction", {pin.angle()}, {.damping = 0.05});
        graph.add<CoordinateSpring>("spring", {-slide.displacement()},
                                    {.stiffness = stiffness, .damping = 0.4, .free_value = 0.02, .preload = 1});
        return {coordinate(pin.angle(), "pin"), coordinate(slide.displacement(), "slide")};
      }};
}

}  // namespace lithe::test
