#include "bodies/flexible/deformation_writer.h"

#include "engine/snapshot.h"

namespace lithe {

DeformationWriter::DeformationWriter(const FlexibleBody& body, std::string path)
    : body_(body), series_(std::move(path)) {
  for (const ElementBlock& block : body.basis().elements) cells_.push_back({block.type, block.nodes});
}

void DeformationWriter::observe(Snapshot& snapshot) {
  const BodyState state = snapshot.assembler().body_state(body_);
  const auto& slice = snapshot.system().layout().slice(body_);
  const auto motion = body_.nodal_motion(state, snapshot.state().v_dot.data() + slice.v);
  const Eigen::Map<const Vector3> origin(state.q);
  const Matrix3X rigid = (state.cache->A * body_.basis().nodes).colwise() + Vector3(origin);
  series_.add(
      snapshot.time(), motion.position, cells_,
      {{"deformation", motion.position - rigid}, {"velocity", motion.velocity}, {"acceleration", motion.acceleration}});
}

}  // namespace lithe
