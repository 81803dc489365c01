#include "bodies/flexible/readers/labelled_mesh.h"

#include <unordered_map>

namespace lithe {

FiniteElementModel labelled_mesh(const std::string& path, const std::vector<int>& labels,
                                 const std::vector<Vector3>& positions, const std::vector<ElementBlock>& elements) {
  FiniteElementModel model;
  model.name = path;
  model.node_ids = labels;
  model.elements = elements;
  model.nodes.resize(3, static_cast<Eigen::Index>(positions.size()));
  std::unordered_map<int, int> index;
  for (size_t i = 0; i < positions.size(); ++i) {
    model.nodes.col(static_cast<Eigen::Index>(i)) = positions[i];
    index.emplace(labels[i], static_cast<int>(i));
  }
  for (ElementBlock& block : model.elements)
    for (auto& element : block.nodes)
      for (int& node : element) node = index.at(node);
  return model;
}

}  // namespace lithe
