#pragma once

#include <map>
#include <string>

#include "bodies/flexible/finite_element_model.h"

namespace lithe {

/// The volume mesh of a gmsh file (MSH 2.2 or 4.1, ASCII): tetrahedra and hexahedra of 4, 10, 8 and 20 nodes, in the
/// node order of CalculiX. Nodes of a physical group (point, line, surface or volume) become a node set under its name
/// in lower case; nameless ones are "surface_3". Nodes that no volume uses are left out, with a line in the log. One
/// block of elements for each type and physical volume, with the material of its name (or of ""); 8-node bricks become
/// C3D8I. K and M stay empty: assemble_matrices() fills them.
/// Throws FileError naming file:line: binary files, other volume elements, partial or cut files, a volume without
/// material.
FiniteElementModel read_gmsh(const std::string& path, const std::map<std::string, Material>& materials);
FiniteElementModel read_gmsh(const std::string& path, const Material& material);

}  // namespace lithe
