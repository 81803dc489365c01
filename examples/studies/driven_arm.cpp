// driven_arm: a flexible arm on a hinge, under a torque, on a spring whose stiffness may be tuned: the scene of the
// guide to FMUs (docs/fmu.md), with inputs, a parameter and outputs.
#include "lithe/lithe.h"

using namespace lithe;

StudyScene scene() {
  return {.name = "driven arm",
          .duration = 1,
          .characteristic_length = 0.4,  // m
          .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
            const Matrix3 along_y = rotation_about({1, 0, 0}, -M_PI / 2);
            auto& torque = graph.add<Input>(
                "torque", {.unit = "N m", .lower = -2, .upper = 2, .description = "of the motor at the hinge"});
            auto& stiffness = graph.add<Input>("stiffness", {.unit = "N m/rad",
                                                             .value = 1,
                                                             .lower = 0,
                                                             .upper = 50,
                                                             .parameter = true,
                                                             .description = "of the spring at the hinge"});
            auto& lift = graph.add<Input>("lift", {.unit = "m",
                                                   .value = 0.3,
                                                   .lower = 0.1,
                                                   .upper = 0.5,
                                                   .between = Input::Between::smooth,
                                                   .description = "free length of the spring at the tip"});
            const auto basis = make_basis(brick_mesh({.size = {0.4, 0.02, 0.02},
                                                      .divisions = {4, 1, 1},
                                                      .type = "C3D8I",
                                                      .material = {2e8, 0.3, 1200},
                                                      .name = "arm"}),
                                          MeanAxisFrame{}, 4);
            auto& arm = graph.add<FlexibleBody>("arm", {.basis = basis, .position = {0, 0, -0.01}});
            auto& hinge =
                graph.add<RevoluteJoint>("hinge", {graph.ground().marker({}, along_y), arm.average({1, 2}, along_y)});
            const Marker tip = arm.node(basis->node_ids.back());
            graph.add<CoordinateMotor>("motor", {hinge.angle()}, {.effort = torque});
            graph.add<CoordinateSpring>("spring", {hinge.angle()}, {.stiffness = stiffness, .damping = 0.02});
            graph.add<SpringDamper>("strut", {graph.ground().marker({0.4, 0, 0.3}), tip},
                                    {.stiffness = 20, .damping = 0.2, .natural_length = lift});
            return {coordinate(hinge.angle(), "angle"), position(tip, "tip"), acceleration(tip, "tip_a"),
                    joint_reaction(hinge, "hinge"), elastic_energy(arm, "energy")};
          }};
}
