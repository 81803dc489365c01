#pragma once

#include <utility>
#include <vector>

#include "engine/assembly/workspace.h"
#include "engine/motion/equations_of_motion.h"

namespace lithe {

class ContactForces;

/// Linear coordinates of one evaluator that stand still, and what that leaves of the blocks of a state.
class HeldBlocks final : public HeldCoordinates {
 public:
  /// Borrows all three; `contacts` may be null.
  HeldBlocks(const BlockStructure& blocks, Workspace& work, ContactForces* contacts)
      : blocks_(blocks), work_(work), contacts_(contacts) {}

  bool hold(const std::vector<int>& velocities) override;

  bool any() const { return !velocities_.empty(); }
  /// Clears the columns of G, of joints and contacts alike: what is held does not move them.
  void release_from_joints();
  /// The rows of the residual become v_dot = 0.
  void write_residual(ConstVectorRef v_dot, VectorRef r) const;
  /// The rows and columns of S become `acceleration` times the unit matrix.
  void write_tangent(double acceleration) const;

 private:
  const BlockStructure& blocks_;
  Workspace& work_;
  ContactForces* contacts_;
  std::vector<int> velocities_;
  std::vector<std::pair<int, int>> jacobian_;  // first value, count: zero
  std::vector<int> couplings_, diagonals_;     // values of S: zero, and the weight of the acceleration
};

}  // namespace lithe
