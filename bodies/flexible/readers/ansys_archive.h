#pragma once

#include <string>

#include "bodies/flexible/finite_element_model.h"

namespace lithe {

/// Nodes, node components and solids of an ANSYS archive (CDWRITE: NBLOCK, CMBLOCK, ET, EBLOCK), or the nodes alone of
/// the tables that NWRITE and NLIST print. Elements that are no solids are left out with a warning.
/// Throws FileError naming file:line; nodes with turned axes are refused.
void read_ansys_archive(const std::string& path, FiniteElementModel& model);

}  // namespace lithe
