#pragma once

#include <string>

#include "bodies/flexible/finite_element_model.h"

namespace lithe {

/// A finite-element model from plain tables, code-independent:
///   stiffness_mtx, mass_mtx  Matrix Market, coordinate real, symmetric or general; row 3 (i - 1) + axis + 1 for the
///                            i-th line of nodes.csv; N/m and kg; no support applied
///   nodes_csv                node,x,y,z          (label, metres)
///   node_sets_csv            set,position,node[,x,y,z]  in order of position; coordinates are compared if given
///   elements_csv             element,n1,...,n8 or n4, n6, n10, n15, n20: one type a file, CalculiX/Abaqus node order
/// Names of sets are stored in lower case. Throws FileError naming file:line for whatever does not fit.
FiniteElementModel read_matrix_market(const std::string& stiffness_mtx, const std::string& mass_mtx,
                                      const std::string& nodes_csv, const std::string& node_sets_csv = "",
                                      const std::string& elements_csv = "");

/// One Matrix Market file, both triangles filled.
SparseMatrix read_matrix_market_file(const std::string& path);

}  // namespace lithe
