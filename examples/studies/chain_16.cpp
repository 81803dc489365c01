// Sixteen slender rods on hinges, released from rest along +x: the chain that other engines were measured on.
//   lithe chart chain_16 --samples 1 --peers tools/charts/chain_16_peers.csv
// Compare the end alone (--samples 1), as they do: their error is that of the worst joint at 1 s.
#include "lithe/lithe.h"

using namespace lithe;

StudyScene scene() {
  return {.name = "chain of 16 hinged rods",
          .duration = 1,
          .characteristic_length = 1,  // m: a rod
          .draw = [](SystemGraph& graph) {
            std::vector<Sensor> joints;
            const Matrix3 along_y = rotation_about({1, 0, 0}, -M_PI / 2);
            Marker last = graph.ground().marker({0, 0, 0}, along_y);
            for (int i = 1; i <= 16; ++i) {
              const std::string number = std::to_string(i);
              auto& rod = graph.add<RigidBody>(
                  "rod " + number, {.mass = 1, .inertia = {1.25e-3, 1.0 / 12, 1.0 / 12}, .position = {i - 0.5, 0, 0}});
              graph.add<RevoluteJoint>("hinge " + number, {last, rod.marker({-0.5, 0, 0}, along_y)});
              last = rod.marker({0.5, 0, 0}, along_y);
              joints.push_back(position(last, "end_" + number));
            }
            return joints;
          }};
}
