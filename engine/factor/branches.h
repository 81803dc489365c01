#pragma once

#include <vector>

#include "engine/factor/graph_topology.h"

namespace lithe {

/// Changes the order of an elimination so that branches come first: sets of vertices that know nothing of each other
/// before the rest, the trunk, is eliminated, so that threads may share them. Returns where each branch ends in the
/// order; none where that is not worth it. `work`: multiplications of each vertex. What it finds depends on the
/// elimination alone, not on who works.
std::vector<int> gather_branches(Elimination& elimination, const std::vector<double>& work);

}  // namespace lithe
