#pragma once

#include <string>

#include "bodies/flexible/finite_element_model.h"

namespace lithe {

/// What ANSYS writes of a free body. Matrices are in Harwell-Boeing text (/AUX2, HBMAT) or Matrix Market text (*SMAT or
/// *DMAT, EXPORT, MMF); the first line shows which.
struct AnsysFiles {
  std::string stiffness, mass;
  /// Node and label of each row: the .mapping of HBMAT (`row node UX`), or in Matrix Market an integer array of two
  /// columns (node, 1-6) with one line a row, or of one column: the nodes, in the order of rows, of which each has the
  /// same number of rows, three or six (the vector BACK of a .full file).
  std::string mapping;
  std::string nodes;  // an archive (CDWRITE), with components and solids; or the tables of NWRITE or NLIST
};

/// Node components become node sets. Throws FileError naming file:line: rotated nodes, labels that are no
/// displacements, what place_matrices() refuses.
FiniteElementModel read_ansys(const AnsysFiles& files);

/// A further matrix of the same body in the model's order of degrees of freedom: the stress stiffness that HBMAT writes
/// as MASS from the .full file of a buckling analysis. `mapping` is its own.
SparseMatrix read_stress_stiffness_ansys(const std::string& matrix, const std::string& mapping,
                                         const FiniteElementModel& model);

}  // namespace lithe
