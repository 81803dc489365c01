#pragma once

#include <string>

#include "bodies/flexible/finite_element_model.h"

namespace lithe {

/// One assembled real square matrix in Harwell-Boeing format (Duff, Grimes & Lewis, Users' Guide for the
/// Harwell-Boeing Sparse Matrix Collection, 1992), as ANSYS' HBMAT writes it in text form: types RSA (one triangle) and
/// RUA (both, and symmetric in value). Right-hand sides are skipped. Both triangles are returned.
/// Throws FileError naming file:line.
SparseMatrix read_harwell_boeing(const std::string& path);

}  // namespace lithe
