#pragma once

#include <map>
#include <string>
#include <vector>

#include "bodies/flexible/finite_element_model.h"

namespace lithe {

/// What Lithe needs of a CalculiX input deck (.inp): *NODE, *ELEMENT, *NSET (GENERATE, sets within sets) and *INCLUDE.
/// Everything else is skipped, except what turns the axes of degrees of freedom (*TRANSFORM), which is refused.
/// Keywords and set names are compared without regard to case; names are stored in lower case.
struct CalculixDeck {
  std::vector<int> node_ids;                          // in order of appearance
  std::vector<Vector3> positions;                     // metres
  std::map<std::string, std::vector<int>> node_sets;  // labels, in order of appearance, each once
  std::vector<ElementBlock> elements;                 // by node LABEL, one block a type
  int incompatible_elements = 0;                      // C3D8I: nine hidden degrees of freedom each
};

/// Throws FileError naming file:line.
CalculixDeck read_calculix_deck(const std::string& path);

}  // namespace lithe
