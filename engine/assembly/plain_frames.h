#pragma once

#include <map>
#include <typeindex>
#include <vector>

#include "engine/assembly/batch.h"
#include "engine/factor/block_structure.h"
#include "engine/model/system_graph.h"

namespace lithe {

/// Which frames of rigid bodies are plain (BlockStructure::Frame), and which joints act between such alone
/// (ConnectorRecord::rigid), while a scene is assembled. Frames of rigid bodies are marked as plain before.
class PlainFrames {
 public:
  /// Borrows both.
  PlainFrames(const SystemGraph& graph, BlockStructure& blocks) : graph_(graph), blocks_(blocks) {}

  /// A connector that acts on its frames in other ways than joints of RigidRows: they are not plain.
  void exclude(const ConnectorRecord& record);
  /// Likewise of the constraints, in the graph's order; and frames of many joints.
  void exclude_by(const std::vector<ConnectorRecord>& constraints);
  /// With all blocks planned: constraints between plain frames, and where G of their translations is ±E.
  void mark(std::vector<ConnectorRecord>& constraints);

 private:
  /// Of the graph's i-th constraint; null if its type has none.
  const RigidRows* rows_of(std::size_t i);

  const SystemGraph& graph_;
  BlockStructure& blocks_;
  std::map<std::type_index, const RigidRows*> by_type_;
};

}  // namespace lithe
