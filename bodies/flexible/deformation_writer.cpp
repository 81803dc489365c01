#include "bodies/flexible/deformation_writer.h"

#include "engine/observe/snapshot.h"

namespace lithe {
namespace {

/// VTK has yz before xz.
VtuField tensor_field(const std::string& name, Matrix6X values) {
  values.row(4).swap(values.row(5));
  return {name, std::move(values)};
}

}  // namespace

std::vector<VtuCells> vtu_cells(const ModalBasis& basis) {
  std::vector<VtuCells> cells;
  for (const ElementBlock& block : basis.elements) cells.push_back({block.type, block.nodes});
  return cells;
}

Matrix3X mesh_nodes(const ModalBasis& basis) { return (basis.rotation * basis.nodes).colwise() + basis.origin; }

DeformationWriter::DeformationWriter(const FlexibleBody& body, std::string path, const DeformationFields& fields)
    : body_(body), wanted_(fields), cells_(vtu_cells(body.basis())), series_(std::move(path)) {
  if (wanted_.stress || wanted_.strain) stress_.emplace(body, wanted_.recovery);
}

void DeformationWriter::observe(Snapshot& snapshot) {
  const BodyState state = snapshot.body_state(body_);
  const auto& slice = snapshot.system().layout().slice(body_);
  const auto motion = body_.nodal_motion(state, snapshot.accelerations().data() + slice.v);
  const Eigen::Map<const Vector3> origin(state.q);
  const Matrix3X rigid = (state.cache->A * body_.basis().nodes).colwise() + Vector3(origin);
  if (series_.frame_count() == 0) start_ = motion.position;
  std::vector<VtuField> fields = {{"displacement", motion.position - start_},
                                  {"deformation", motion.position - rigid},
                                  {"velocity", motion.velocity},
                                  {"acceleration", motion.acceleration}};
  if (wanted_.stress) {
    const Matrix6X stress = stress_->stress(snapshot);
    fields.push_back({"von_mises", von_mises(stress).transpose()});
    fields.push_back(tensor_field("stress", stress));
  }
  if (wanted_.strain) {
    Matrix6X strain = stress_->strain(snapshot);
    strain.bottomRows<3>() /= 2;
    fields.push_back(tensor_field("strain", strain));
  }
  series_.add(snapshot.time(), motion.position, cells_, fields);
}

}  // namespace lithe
