#pragma once

#include <set>
#include <string>
#include <utility>

namespace lithe::lab {

/// Cells in which we differ from the published table, by theory there, and do not know who is right: our dynamics of
/// S44 ends on the anti-parallelogram, as static continuation does.
inline const std::set<std::pair<std::string, std::string>> kOpenCells{{"S44", "dynamics"}};

}  // namespace lithe::lab
