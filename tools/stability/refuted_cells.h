#pragma once

#include <set>
#include <string>
#include <utility>

namespace lithe::lab {

/// Cells whose published outcome, by theory, is refuted: the dynamics of S44 ends on the anti-parallelogram, as static
/// continuation does, by ours and by Exudyn (tools/bench/peers/exudyn_four_bar.py).
inline const std::set<std::pair<std::string, std::string>> kRefutedCells{{"S44", "dynamics"}};

}  // namespace lithe::lab
