#include "joints/contact/capsules.h"

#include "engine/base/checks.h"
#include "engine/base/error.h"

namespace lithe {

std::vector<CapsulePiece> capsule_pieces(const std::vector<double>& arcs, double radius) {
  require::positive(radius, "the radius of the capsules");
  std::vector<CapsulePiece> pieces;
  for (std::size_t i = 0; i < arcs.size(); ++i) {
    const double from = i == 0 ? radius : 0.5 * (arcs[i - 1] - arcs[i]);
    const double to = i + 1 == arcs.size() ? -radius : 0.5 * (arcs[i + 1] - arcs[i]);
    if (!(to > from))
      throw SceneError("capsules of radius " + std::to_string(radius) + " m do not fit into the ends of the line", "",
                       "give a radius below half of its end elements, or take fewer elements");
    pieces.push_back({0.5 * (from + to), to - from});
  }
  return pieces;
}

}  // namespace lithe
