#pragma once

#include <string>

#include "bodies/flexible/finite_element_model.h"

namespace lithe {

/// Mode shapes that a finite-element run has left beside its matrices.
struct ImportedModes {
  VectorX frequencies;  // Hz, as the file tells them; may be rounded
  MatrixX shapes;       // dofs x modes, in the model's order; rotations, which the file does not have, are zero
};

/// The DISP blocks of the modes in an ASCII .frd file of CalculiX (results of *FREQUENCY with *NODE FILE, U): six-digit
/// figures in fixed columns that may touch each other, node numbers of five or ten columns. Nodes that the model does
/// not have are skipped (midside nodes of C3D8I's expansion, say); blocks that are no modes too. No mode: no column.
/// FileError naming file:line: a node of the model without a figure, a mode cut short, a binary file.
ImportedModes read_calculix_modes(const std::string& frd, const FiniteElementModel& model);

}  // namespace lithe
