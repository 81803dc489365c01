#pragma once

#include <map>
#include <string>
#include <vector>

#include "bodies/flexible/elements/solid_element.h"

namespace lithe {

/// Parts of a CalculiX input deck (.inp) that are read: *NODE, *ELEMENT, *NSET, *ELSET (GENERATE, sets within sets),
/// *SOLID SECTION with *MATERIAL, *ELASTIC, *DENSITY, and *INCLUDE. Everything else is skipped, except what turns the
/// axes of degrees of freedom (*TRANSFORM), which is refused. Keywords and set names are compared without regard to
/// case; names are stored in lower case.
struct CalculixDeck {
  std::vector<int> node_ids;                          // in order of appearance
  std::vector<Vector3> positions;                     // metres
  std::map<std::string, std::vector<int>> node_sets;  // labels, in order of appearance, each once
  std::vector<ElementBlock> elements;  // by node LABEL, one block a type and material; not isotropic, depending on
                                       // temperature or without section: E = 0
  int incompatible_elements = 0;       // C3D8I: nine hidden degrees of freedom each
};

/// Throws FileError naming file:line.
CalculixDeck read_calculix_deck(const std::string& path);

/// A model from the deck alone: K and M of the free body assembled from its solids and their materials; no matrices
/// need be exported. Nodes that no element uses are left out. Throws FileError like read_calculix_deck(), SceneError
/// for an element type or material that assemble_matrices() does not know.
FiniteElementModel read_calculix_mesh(const std::string& deck, MassIntegration mass = MassIntegration::exact);

/// Writes the mesh of a model as a deck: nodes, elements with their materials, node sets; lengths in 17 digits, so that
/// read_calculix_mesh() finds the same K and M to the last bit. For a code that is to check a part, and for the plug-in
/// `inertial_body` (C3D8 and C3D8I). Steps and supports are yours: a deck of your own takes this one in by
/// *INCLUDE, INPUT=path. Throws SceneError for a model without elements, of other elements than those of
/// solid_element.h, without material, or with a set name that no deck can hold; FileError where it cannot be written.
void write_calculix_deck(const std::string& path, const FiniteElementModel& model);

}  // namespace lithe
