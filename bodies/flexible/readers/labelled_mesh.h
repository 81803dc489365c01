#pragma once

#include <string>
#include <vector>

#include "bodies/flexible/finite_element_model.h"

namespace lithe {

/// A model without matrices of nodes with labels, at `positions` (m), and of elements by labels, which become indices.
FiniteElementModel labelled_mesh(const std::string& path, const std::vector<int>& labels,
                                 const std::vector<Vector3>& positions, const std::vector<ElementBlock>& elements);

}  // namespace lithe
