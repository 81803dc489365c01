#include "joints/three_node_fixation.h"

#include "engine/assembly/batch_of.h"

namespace lithe {

void ThreeNodeFixation::initialize(std::span<const MarkerView> m) {
  for (int i = 0; i < 3; ++i) held_[i] = m[0].R.transpose() * (m[i + 1].p - m[0].p);
}

template std::unique_ptr<ConstraintBatch> make_constraint_batch<ThreeNodeFixation>();

}  // namespace lithe
