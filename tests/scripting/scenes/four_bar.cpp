// A four-bar linkage in space, whose loop has three redundant rows: a scene of tests/scripting/fmu_scenes_test.cpp.
#include "lithe/lithe.h"

using namespace lithe;

StudyScene scene() {
  return {
      .name = "four_bar", .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
        // Crank 0.3 m and rocker 0.3 m, both upright, the coupler of 0.5 m level: a parallelogram about y.
        const Matrix3 along_y = rotation_about({1, 0, 0}, -M_PI / 2);
        const auto bar = [&](const char* name, const Vector3& at) -> RigidBody& {
          return graph.add<RigidBody>(name, {.mass = 1, .inertia = {0.02, 0.03, 0.02}, .position = at});
        };
        auto& crank = bar("crank", {0, 0, 0.15});
        auto& rocker = bar("rocker", {0.5, 0, 0.15});
        auto& coupler = bar("coupler", {0.25, 0, 0.3});
        auto& main = graph.add<RevoluteJoint>(
            "main", {graph.ground().marker({}, along_y), crank.marker({0, 0, -0.15}, along_y)});
        graph.add<RevoluteJoint>("foot",
                                 {graph.ground().marker({0.5, 0, 0}, along_y), rocker.marker({0, 0, -0.15}, along_y)});
        graph.add<RevoluteJoint>("elbow",
                                 {crank.marker({0, 0, 0.15}, along_y), coupler.marker({-0.25, 0, 0}, along_y)});
        graph.add<RevoluteJoint>("head", {rocker.marker({0, 0, 0.15}, along_y), coupler.marker({0.25, 0, 0}, along_y)});
        graph.add<CoordinateMotor>("motor", {main.angle()},
                                   {.effort = [](double t, double, double) { return std::cos(9 * t); }});
        return {coordinate(main.angle(), "turned"), position(coupler.marker(), "coupler"),
                joint_reaction(main, "main")};
      }};
}
