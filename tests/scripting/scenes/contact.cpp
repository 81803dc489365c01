// A ball that falls onto a slope, rubs and rolls down to a floor: a scene of tests/scripting/fmu_scenes_test.cpp.
#include "lithe/lithe.h"

using namespace lithe;

StudyScene scene() {
  return {
      .name = "contact", .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
        const Matrix3 slope = rotation_about({0, 1, 0}, 0.3);
        auto& ball = graph.add<RigidBody>("ball", {.mass = 1, .inertia = {4e-3, 4e-3, 4e-3}, .position = {0, 0, 0.12}});
        const Compliance law{.stiffness = 1e4, .dissipation = Dissipation::fixed, .damping = 0.1};
        graph.add<Contact>(
            "slope", {{graph.ground().marker({}, slope), shape::half_space()}, {ball.marker(), shape::sphere(0.1)}},
            {.law = law, .friction = {.coefficient = 0.3}});
        graph.add<Contact>(
            "floor", {{graph.ground().marker({0, 0, -0.1}), shape::half_space()}, {ball.marker(), shape::sphere(0.1)}},
            {.law = law, .friction = {.coefficient = 0.3}});
        return {position(ball.marker(), "ball"), total_energy("energy")};
      }};
}
