#pragma once

#include <compare>
#include <string>
#include <vector>

#include "bodies/flexible/finite_element_model.h"

namespace lithe {

/// What a row of a matrix stands for, as an FE code names it: a node's translation (1, 2, 3) or rotation (4, 5, 6).
/// Scalar points, hybrid pressures, internal degrees of freedom belong to no node: direction 0, or a label below 1.
struct DofRow {
  int node = 0;
  int direction = 0;
  auto operator<=>(const DofRow&) const = default;
};

/// A matrix listed by name of row and column (DMIG, Abaqus matrix input).
struct LabelledMatrix {
  struct Entry {
    DofRow row, column;
    double value;
  };
  std::string path;
  bool general = false;  // both triangles are listed; otherwise found from the entries
  std::vector<Entry> entries;
};

/// All rows that the two matrices mention, ascending.
std::vector<DofRow> rows_of(const LabelledMatrix& stiffness, const LabelledMatrix& mass);
/// The matrix by these rows, both triangles. FileError for entries given twice or a matrix that is not symmetric.
SparseMatrix assembled(const LabelledMatrix& matrix, const std::vector<DofRow>& rows);
/// Rows of the nodes in ascending order of labels, `directions` (3 or 6) each.
std::vector<DofRow> rows_by_label(std::vector<int> node_ids, int directions);

/// Gives a model of nodes (and perhaps sets and elements) its matrices, whose rows are named; `where` is the file that
/// named them.
/// Rows in which nothing is written are left out with a line in the log (rotations of solids in a set of six each), as
/// are nodes that no row and no element uses. Rotations become model.rotations, after the translations, node by node.
/// Rows of no node are condensed out of K, exactly, if they carry no mass.
/// FileError if a node lacks translations (it is supported), has stiffness but no mass, or is not in the model, if a
/// row is named twice, or a row of no node has mass.
void place_matrices(const std::vector<DofRow>& rows, const SparseMatrix& stiffness, const SparseMatrix& mass,
                    const std::string& where, FiniteElementModel& model);

/// One more matrix in the order of a model that is complete. FileError if it lacks a degree of freedom of the model, or
/// has more.
SparseMatrix in_model_order(const std::vector<DofRow>& rows, const SparseMatrix& matrix, const std::string& where,
                            const FiniteElementModel& model);

/// K_nn - K_na K_aa⁻¹ K_an: the rows from `kept` on are condensed out. K_aa should fall into small blocks (one an
/// element), each condensed by itself. FileError naming `path` if K_aa is not positive definite.
SparseMatrix condensed(const SparseMatrix& K, int kept, const std::string& path);
/// Row and column k of A go to place[k] of a matrix of `size` rows; those at a negative place are left out.
SparseMatrix placed(const SparseMatrix& A, const std::vector<int>& place, int size);

}  // namespace lithe
