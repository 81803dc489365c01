#pragma once

#include <string>
#include <vector>

#include "bodies/flexible/finite_element_model.h"
#include "bodies/flexible/readers/dof_table.h"

namespace lithe {

/// A real square matrix of DMIG entries.
struct NastranMatrix {
  std::string name;
  LabelledMatrix matrix;
};

/// Parts of Nastran bulk data (.bdf, .dat, .pch) that are read: GRID, solids (CHEXA, CPENTA, CTETRA) and DMIG, in
/// fields of 8 or 16 characters or by commas, with continuations. Everything else is skipped, except what turns the
/// axes of nodes or reads other files, which is refused.
struct NastranDeck {
  std::vector<int> node_ids;           // in order of appearance
  std::vector<Vector3> positions;      // metres
  std::vector<ElementBlock> elements;  // by node LABEL, in CalculiX/Abaqus node order, one block a type
  std::vector<NastranMatrix> matrices;
};

/// Adds the entries of a file to a deck. Throws FileError naming file:line. Complex and rectangular DMIG are skipped.
void read_nastran_deck(const std::string& path, NastranDeck& deck);

}  // namespace lithe
