#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bodies/flexible/body_stress.h"
#include "engine/observe/observer.h"
#include "engine/output/hdf5_series.h"

namespace lithe {

/// What a ResultWriter writes beside times and coordinates.
struct ResultContents {
  bool positions = false;  // of all nodes
  bool stress = false;
  std::vector<int> stress_nodes{};  // labels; none: all nodes
  /// How stresses are recovered; null: by the body's elements (body_stress.h).
  std::shared_ptr<const StressRecovery> recovery{};
};

/// Writes a flexible body's motion at every observed state to one HDF5 file, a row a state:
///   /time         s; written last: its length counts the complete states
///   /frame        of the body: position (m), quaternion w x y z; world axes
///   /eta, /eta_rate   modal coordinates and their rates
///   /position     x y z of node after node, m, world axes
///   /stress       xx yy zz xy xz yz of node after node, Pa, axes of the mesh, which turn with the body frame
///   /von_mises    Pa, a column a node
/// and once: /node_ids, /nodes (m, mesh axes), /stress_node_ids. The file is there from the first state on and holds
/// every state that was observed, also after a run that was killed (engine/output/hdf5_series.h). Throws FileError if
/// it cannot be written, SceneError for unknown nodes and stresses that cannot be recovered.
class ResultWriter final : public Observer {
 public:
  ResultWriter(const FlexibleBody& body, std::string path, const ResultContents& contents = {});
  void observe(Snapshot& snapshot) override;

 private:
  const FlexibleBody& body_;
  bool positions_;
  std::vector<int> stress_nodes_;  // indices
  std::optional<BodyStress> stress_;
  Hdf5Series file_;
};

}  // namespace lithe
