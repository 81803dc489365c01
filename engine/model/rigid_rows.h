#pragma once

#include <array>

namespace lithe {

/// The rows of a joint of two markers that holds a point and axes at right angles, and nothing else, in their order:
/// p_B - p_A = 0 if `point`, then axis a of A · axis b of B = 0 for each of `perpendicular`. A joint that has them as
/// its constant kRigidRows writes the same rows in evaluate(); between rigid bodies the engine then forms their blocks
/// from the poses (engine/assembly/rigid_pairs.h).
struct RigidRows {
  struct Axes {
    int a, b;  // 0: x, 1: y, 2: z
  };
  bool point = false;
  int angles = 0;
  std::array<Axes, 3> perpendicular{};
  constexpr int rows() const { return (point ? 3 : 0) + angles; }
};

}  // namespace lithe
