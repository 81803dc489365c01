#pragma once

#include <memory>
#include <vector>

#include "engine/model/system_graph.h"

namespace lithe {

/// The islands of a scene: parts that no joint and no force element ties (ground does not tie), in the order of their
/// first bodies. An element that wants the reaction of a joint (friction) is of that joint's island; forces between
/// markers of ground move nothing and are left out. `graph` stays the owner and must outlive its islands.
std::vector<std::unique_ptr<SystemGraph>> split(SystemGraph& graph);

/// Whether anything in a scene may change while its bodies rest: drives, forces that know the time.
bool depends_on_time(const SystemGraph& graph);

}  // namespace lithe
