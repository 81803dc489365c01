#pragma once

#include <array>
#include <vector>

namespace lithe {

/// A stretch of a line with Gauss's two points, each of which stands for `half` of it.
struct LinePiece {
  std::array<double, 2> arcs;
  double half;  // m
};
/// The stretch from `from` to `to` (m), cut at the nodes of its body, which begin at 0, and at other places. SceneError
/// for one that is empty or leaves the body.
std::vector<LinePiece> line_pieces(double from, double to, const std::vector<double>& nodes,
                                   const std::vector<double>& breaks);

}  // namespace lithe
