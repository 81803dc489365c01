#pragma once

#include <string>

#include "bodies/flexible/readers/matrix_market.h"
#include "bodies/flexible/reduction.h"

namespace lithe::test {

/// The pendulum's rod, one of examples/data/pendulum.
inline FiniteElementModel pendulum_model(const std::string& body) {
  const std::string folder = std::string(LITHE_EXAMPLE_DATA) + "/pendulum/" + body + "/";
  return read_matrix_market(folder + "K.mtx", folder + "M.mtx", folder + "nodes.csv", folder + "node_sets.csv",
                            folder + "elements.csv");
}

inline BodyFrame three_nodes(const FiniteElementModel& model, const std::string& set) {
  const auto& n = model.node_set(set);
  return ThreeNodeFrame{n.at(0), n.at(1), n.at(2)};
}

/// frameA, frameB, frameC, hinge, clamp, mean: the frames that the reference names.
inline BodyFrame frame_of(const FiniteElementModel& model, const std::string& name) {
  if (name == "mean axes") return MeanAxisFrame{};
  if (name == "hinge") return HingeFrame{model.node_set("hinge")};
  if (name == "clamp") return TangentFrame{model.node_set("root_face")};
  return three_nodes(model, name);
}

}  // namespace lithe::test
