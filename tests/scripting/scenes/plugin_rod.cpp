// A bob on a rod that is a joint of a plug-in, which lies in the FMU's resources: a scene of
// tests/scripting/fmu_scenes_test.cpp.
#include "lithe/lithe.h"

using namespace lithe;

StudyScene scene() {
  return {
      .name = "plugin_rod", .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
        Registry registry;
        registry.load_plugin(resource("massless_rod.so"));
        auto& bob = graph.add<RigidBody>(
            "bob", {.mass = 2, .inertia = {1e-3, 1e-3, 1e-3}, .position = {0.3, 0, -0.4}, .velocity = {0, 1, 0}});
        graph.add(registry.joint("massless_rod"), "rod", {graph.ground().marker(), bob.marker()}, {{"length", 0.5}});
        return {position(bob.marker(), "bob"), total_energy("energy")};
      }};
}
