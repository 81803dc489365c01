#pragma once

#include <string>

#include "bodies/flexible/finite_element_model.h"

namespace lithe {

/// The files that Abaqus writes for `*MATRIX GENERATE, STIFFNESS, MASS` and `*MATRIX OUTPUT, STIFFNESS, MASS` of a free
/// body. The format of each .mtx, and whether it has one triangle or both, are recognised from its content:
///   FORMAT=MATRIX INPUT, LABELS   node, direction, node, direction, value; by commas or blanks
///   FORMAT=COORDINATE             row column value; rows are named by comment lines `** row, node, direction`, if
///                                 any; else they are the nodes of the deck by ascending label, 3 or 6 rows each
struct AbaqusFiles {
  std::string deck;             // .inp: *NODE, *ELEMENT, *NSET, as read_calculix_deck() reads them
  std::string stiffness, mass;  // job_STIF1.mtx, job_MASS1.mtx
};

/// Labels below 1 are Abaqus' internal nodes. Throws FileError naming file:line: a boundary condition (1e36 on the
/// diagonal), what the deck's reader and place_matrices() refuse.
FiniteElementModel read_abaqus(const AbaqusFiles& files);

}  // namespace lithe
