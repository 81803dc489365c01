#pragma once

#include <vector>

#include "engine/model/system_graph.h"

namespace lithe {
class Contact;
class FlexibleBody;
}  // namespace lithe

/// What runs for long.
namespace lithe::endurance {

/// Chains of four rods of 20 m on ball joints, in rows 100 m apart, let go at different angles. Gravity is the moon's.
void add_rigid_chains(SystemGraph& graph, int bodies);
/// Pairs of plastic rods, 10 m x 0.2 m x 0.2 m, on pins. All share one basis.
std::vector<FlexibleBody*> add_flexible_pairs(SystemGraph& graph, int bodies, int modes);
/// Boxes on four corners each, on a table that shakes by 50 mm at 8 rad/s, 3.2 m/s²: they slide and stick in turn.
const Contact& add_shaken_boxes(SystemGraph& graph, int contacts);

}  // namespace lithe::endurance
