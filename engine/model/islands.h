#pragma once

#include <memory>
#include <vector>

#include "engine/model/system_graph.h"

namespace lithe {

/// The islands of a scene: parts not connected by a joint or force element (ground does not connect), in the order of
/// their first bodies. An element that needs the reaction of a joint (friction) belongs to that joint's island; forces
/// between markers of ground have no effect and are left out. `graph` stays the owner and must outlive its islands.
std::vector<std::unique_ptr<SystemGraph>> split(SystemGraph& graph);

/// Whether anything in a scene may change while its bodies rest: drives, forces that depend on time.
bool depends_on_time(const SystemGraph& graph);

}  // namespace lithe
