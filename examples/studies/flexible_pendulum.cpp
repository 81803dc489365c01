// The flexible pendulum of example 02 with nine modes: a slow swing with fast vibrations of a soft rod in it.
//   lithe chart flexible_pendulum
#include <filesystem>

#include "lithe/lithe.h"

using namespace lithe;

StudyScene scene() {
  return {
      .name = "flexible pendulum, nine modes",
      .duration = 1,
      .characteristic_length = 0.1,  // m: the rod
      .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
        const auto here = std::filesystem::path(__FILE__).parent_path();
        const auto model = read_calculix((here / "../data/pendulum/hex8i/calculix/matrices").string());
        const std::vector<int>& edge = model.node_set("hinge");
        auto& rod = graph.add<FlexibleBody>("rod", {.basis = make_basis(model, HingeFrame{edge}, 9)});
        const Matrix3 along_y = rotation_about({1, 0, 0}, -M_PI / 2);
        graph.add<RevoluteJoint>("hinge", {graph.ground().marker({0, 0.005, 0}, along_y), rod.average(edge, along_y)});
        return {position(rod.node(model.node_set("tip").front()), "tip")};
      }};
}
