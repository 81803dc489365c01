#include "joints/forces/line_pieces.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "engine/base/checks.h"

namespace lithe {

std::vector<LinePiece> line_pieces(double from, double to, const std::vector<double>& nodes,
                                   const std::vector<double>& breaks) {
  require::finite(from, "from");
  require::finite(to, "to");
  const double length = nodes.back(), least = 1e-9 * length;
  const std::string stretch = "the stretch from " + std::to_string(from) + " m to " + std::to_string(to) + " m";
  if (!(from < to)) throw SceneError(stretch + " is empty", "", "give from < to");
  if (!(from >= 0 && to <= length * (1 + 1e-9)))
    throw SceneError(stretch + " leaves its body", "", "give arc lengths from 0 to " + std::to_string(length));
  std::vector<double> all = nodes;
  all.insert(all.end(), breaks.begin(), breaks.end());
  std::sort(all.begin(), all.end());
  std::vector<double> ends{from};
  for (const double arc : all)
    if (arc > ends.back() + least && arc < to - least) ends.push_back(arc);
  ends.push_back(to);
  std::vector<LinePiece> pieces;
  for (std::size_t i = 0; i + 1 < ends.size(); ++i) {
    const double middle = 0.5 * (ends[i] + ends[i + 1]), half = 0.5 * (ends[i + 1] - ends[i]);
    pieces.push_back({{middle - half / std::sqrt(3.0), middle + half / std::sqrt(3.0)}, half});
  }
  return pieces;
}

}  // namespace lithe
