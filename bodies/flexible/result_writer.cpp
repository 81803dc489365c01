#include "bodies/flexible/result_writer.h"

namespace lithe {

ResultWriter::ResultWriter(const FlexibleBody& body, std::string path, const ResultContents& contents)
    : body_(body), positions_(contents.positions), file_(std::move(path)) {
  const ModalBasis& basis = body.basis();
  file_.write("/node_ids", basis.node_ids);
  file_.write("/nodes", MatrixX((basis.rotation * basis.nodes).colwise() + basis.origin));
  file_.attribute("/", "body", body.name());
  file_.attribute("/", "units", "m, kg, s, Pa");
  if (contents.stress) {
    stress_.emplace(body, contents.recovery);
    std::vector<int> ids = contents.stress_nodes.empty() ? basis.node_ids : contents.stress_nodes;
    for (int id : ids) stress_nodes_.push_back(basis.node_index(id));
    const auto count = static_cast<int>(ids.size());
    file_.write("/stress_node_ids", ids);
    file_.add("/stress", 6 * count);
    file_.attribute("/stress", "components", "xx yy zz xy xz yz, axes of the mesh");
    file_.add("/von_mises", count);
  }
  if (positions_) {
    file_.add("/position", static_cast<int>(basis.nodes.size()));
    file_.attribute("/position", "axes", "world");
  }
  file_.add("/frame", 7);
  file_.attribute("/frame", "components", "x y z, quaternion w x y z; world axes");
  if (body.mode_count() > 0) {
    file_.add("/eta", body.mode_count());
    file_.add("/eta_rate", body.mode_count());
  }
  file_.add("/time", 1);
  file_.begin();
}

void ResultWriter::observe(Snapshot& snapshot) {
  const BodyState state = snapshot.body_state(body_);
  if (stress_) {
    const Matrix6X stress = stress_->stress(snapshot)(Eigen::all, stress_nodes_);
    file_.append("/stress", stress.reshaped());
    file_.append("/von_mises", von_mises(stress));
  }
  if (positions_) {
    const VectorX rest = VectorX::Zero(6 + body_.mode_count());
    file_.append("/position", body_.nodal_motion(state, rest.data()).position.reshaped());
  }
  file_.append("/frame", Eigen::Map<const VectorX>(state.q, 7));
  if (const int modes = body_.mode_count(); modes > 0) {
    file_.append("/eta", Eigen::Map<const VectorX>(state.q + 7, modes));
    file_.append("/eta_rate", Eigen::Map<const VectorX>(state.v + 6, modes));
  }
  file_.flush();
  file_.append("/time", VectorX::Constant(1, snapshot.time()));
  file_.flush();
}

}  // namespace lithe
