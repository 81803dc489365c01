#include "bodies/flexible/readers/dof_table.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <unordered_map>
#include <unordered_set>

#include "bodies/flexible/readers/matrix_entries.h"
#include "engine/base/error.h"
#include "engine/base/log.h"

namespace lithe {
namespace {

using Triplets = std::vector<Eigen::Triplet<double>>;
constexpr const char* kFreeBody = "export the free body: no supports, constraint equations or rigid elements.";
constexpr int kNone = -1;
constexpr size_t kLargestBlock = 5000;  // rows condensed together, densely

std::string named(int node, int direction) {
  return "node " + std::to_string(node) + ", direction " + std::to_string(direction);
}

bool of_a_node(const DofRow& row) { return row.node > 0 && row.direction != 0; }

std::vector<char> rows_in_use(const SparseMatrix& A) {
  std::vector<char> used(static_cast<size_t>(A.cols()), 0);
  for (int j = 0; j < A.outerSize(); ++j)
    for (SparseMatrix::InnerIterator e(A, j); e; ++e)
      if (e.value() != 0) used[static_cast<size_t>(e.row())] = used[static_cast<size_t>(j)] = 1;
  return used;
}

/// Row of each direction of each node, 6 * index + direction - 1; kNone where there is none.
std::vector<int> row_slots(const std::vector<DofRow>& rows, const std::string& where,
                           const std::vector<int>& node_ids) {
  std::unordered_map<int, size_t> index;
  for (size_t i = 0; i < node_ids.size(); ++i) index.emplace(node_ids[i], i);
  std::vector<int> slots(6 * node_ids.size(), kNone);
  for (size_t k = 0; k < rows.size(); ++k) {
    const auto [node, direction] = rows[k];
    if (!of_a_node(rows[k])) continue;
    const std::string row = "row " + std::to_string(k + 1) + " belongs to " + named(node, direction);
    if (direction < 1 || direction > 6)
      throw FileError(row + ".", where, "directions are 1, 2, 3 (translations) and 4, 5, 6 (rotations).");
    const auto found = index.find(node);
    if (found == index.end())
      throw FileError(row + ", but no coordinates are given for this node.", where,
                      "take nodes and matrices from the same export.");
    int& slot = slots[6 * found->second + static_cast<size_t>(direction) - 1];
    if (slot != kNone)
      throw FileError(row + ", as does row " + std::to_string(slot + 1) + ".", where,
                      "each degree of freedom has one row; export the matrices again.");
    slot = static_cast<int>(k);
  }
  return slots;
}

void keep_nodes(FiniteElementModel& model, const std::vector<char>& kept) {
  std::vector<int> place(kept.size(), kNone), ids;
  for (size_t i = 0; i < kept.size(); ++i) {
    if (!kept[i]) continue;
    place[i] = static_cast<int>(ids.size());
    ids.push_back(model.node_ids[i]);
    model.nodes.col(place[i]) = Vector3(model.nodes.col(static_cast<Eigen::Index>(i)));
  }
  model.nodes.conservativeResize(3, static_cast<Eigen::Index>(ids.size()));
  model.node_ids = std::move(ids);
  const std::unordered_set<int> known(model.node_ids.begin(), model.node_ids.end());
  for (auto& [set, members] : model.node_sets) std::erase_if(members, [&](int id) { return !known.count(id); });
  for (ElementBlock& block : model.elements)
    for (auto& element : block.nodes)
      for (int& node : element) node = place[static_cast<size_t>(node)];
}

/// Which nodes the matrices move, all three translations each; FileError where only some of them.
std::vector<char> moved_nodes(const std::vector<int>& slots, const std::vector<char>& used, const std::string& where,
                              const FiniteElementModel& model) {
  std::vector<char> in_elements(model.node_ids.size(), 0), moved(model.node_ids.size(), 0);
  for (const ElementBlock& block : model.elements)
    for (const auto& element : block.nodes)
      for (int node : element) in_elements[static_cast<size_t>(node)] = 1;
  for (size_t i = 0; i < moved.size(); ++i) {
    const auto has = [&](size_t axis) { return slots[6 * i + axis] != kNone && used[size_t(slots[6 * i + axis])]; };
    const bool any = has(0) || has(1) || has(2) || has(3) || has(4) || has(5);
    if (!any && !in_elements[i]) continue;
    for (size_t axis = 0; axis < 3; ++axis)
      if (!has(axis))
        throw FileError("node " + std::to_string(model.node_ids[i]) + " has no row for direction " +
                            std::to_string(axis + 1) + ", or an empty one.",
                        where, std::string(kFreeBody) + " The file may also be cut.");
    moved[i] = 1;
  }
  return moved;
}

/// A row without its diagonal entry tells a cut file.
void require_diagonals(const FiniteElementModel& model, const std::string& where) {
  const VectorX k = model.stiffness.diagonal(), m = model.mass.diagonal();
  for (int dof = 0; dof < model.dof_count(); ++dof) {
    const bool translation = dof < 3 * model.node_count();
    if (k[dof] > 0 && (m[dof] > 0 || (!translation && m[dof] == 0))) continue;
    const int node = translation ? dof / 3 : model.rotations[size_t(dof - 3 * model.node_count())].node;
    const int direction = translation ? dof % 3 : 3 + model.rotations[size_t(dof - 3 * model.node_count())].axis;
    throw FileError(named(model.node_ids[size_t(node)], direction + 1) + " has no positive " +
                        (k[dof] > 0 ? "mass" : "stiffness") + " on the diagonal.",
                    where, "every node needs both; if the file is cut, export it again.");
  }
}

}  // namespace

std::vector<DofRow> rows_of(const LabelledMatrix& stiffness, const LabelledMatrix& mass) {
  std::vector<DofRow> rows;
  for (const LabelledMatrix* matrix : {&stiffness, &mass})
    for (const auto& e : matrix->entries) {
      rows.push_back(e.row);
      rows.push_back(e.column);
    }
  std::sort(rows.begin(), rows.end());
  rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
  return rows;
}

SparseMatrix assembled(const LabelledMatrix& matrix, const std::vector<DofRow>& rows) {
  const auto number = [&](const DofRow& row) {
    return static_cast<int>(std::lower_bound(rows.begin(), rows.end(), row) - rows.begin());
  };
  MatrixEntries entries(static_cast<int>(rows.size()));
  for (const auto& e : matrix.entries) entries.add(number(e.row), number(e.column), e.value);
  return matrix.general ? entries.general(matrix.path) : entries.one_triangle_or_both(matrix.path);
}

std::vector<DofRow> rows_by_label(std::vector<int> node_ids, int directions) {
  std::sort(node_ids.begin(), node_ids.end());
  std::vector<DofRow> rows;
  for (int id : node_ids)
    for (int direction = 1; direction <= directions; ++direction) rows.push_back({id, direction});
  return rows;
}

void place_matrices(const std::vector<DofRow>& rows, const SparseMatrix& stiffness, const SparseMatrix& mass,
                    const std::string& where, FiniteElementModel& model) {
  for (const SparseMatrix* A : {&stiffness, &mass})
    if (A->rows() != static_cast<Eigen::Index>(rows.size()))
      throw FileError(
          "a matrix of " + std::to_string(A->rows()) + " rows, of which " + std::to_string(rows.size()) + " are named.",
          where, "take both matrices and the list of their rows from the same export.");
  const std::vector<char> stiff = rows_in_use(stiffness), heavy = rows_in_use(mass);
  std::vector<char> used(rows.size());
  for (size_t k = 0; k < rows.size(); ++k) used[k] = stiff[k] || heavy[k];

  std::vector<int> slots = row_slots(rows, where, model.node_ids);
  const std::vector<char> moved = moved_nodes(slots, used, where, model);
  const auto idle = std::count(moved.begin(), moved.end(), char(0));
  if (idle > 0) {
    log::warn(where + ": " + std::to_string(idle) + " node(s) belong to no row and no element; left out.");
    keep_nodes(model, moved);
    size_t kept = 0;
    for (size_t k = 0; k < slots.size(); ++k)
      if (moved[k / 6]) slots[kept++] = slots[k];
    slots.resize(kept);
  }

  std::vector<int> place(rows.size(), kNone);
  for (size_t i = 0; i < model.node_ids.size(); ++i)
    for (size_t axis = 0; axis < 3; ++axis) place[size_t(slots[6 * i + axis])] = static_cast<int>(3 * i + axis);
  model.rotations.clear();
  for (size_t i = 0; i < model.node_ids.size(); ++i)
    for (size_t axis = 0; axis < 3; ++axis) {
      const int row = slots[6 * i + 3 + axis];
      if (row == kNone || !used[size_t(row)]) continue;
      place[size_t(row)] = model.dof_count();
      model.rotations.push_back({static_cast<int>(i), static_cast<int>(axis)});
    }
  const int dofs = model.dof_count();
  int size = dofs;
  for (size_t k = 0; k < rows.size(); ++k) {
    if (of_a_node(rows[k]) || !used[k]) continue;
    if (heavy[k])
      throw FileError("row " + std::to_string(k + 1) + " (" + named(rows[k].node, rows[k].direction) +
                          ") belongs to no node, but has mass.",
                      where, "export without scalar points, modal or fluid degrees of freedom.");
    place[k] = size++;
  }
  const auto dropped = std::count(place.begin(), place.end(), kNone);
  if (dropped > 0) log::info(where + ": " + std::to_string(dropped) + " empty row(s) left out.");
  if (size > dofs) log::info(where + ": " + std::to_string(size - dofs) + " row(s) of no node condensed out.");
  model.stiffness = condensed(placed(stiffness, place, size), dofs, where);
  model.mass = placed(mass, place, size).topLeftCorner(dofs, dofs);
  require_diagonals(model, where);
}

SparseMatrix in_model_order(const std::vector<DofRow>& rows, const SparseMatrix& matrix, const std::string& where,
                            const FiniteElementModel& model) {
  if (matrix.rows() != static_cast<Eigen::Index>(rows.size()))
    throw FileError("a matrix of " + std::to_string(matrix.rows()) + " rows, of which " + std::to_string(rows.size()) +
                        " are named.",
                    where, "take the matrix and the list of its rows from the same export.");
  const std::vector<int> slots = row_slots(rows, where, model.node_ids);
  const std::vector<char> used = rows_in_use(matrix);
  std::vector<int> place(rows.size(), kNone);
  for (int dof = 0; dof < model.dof_count(); ++dof) {
    const bool translation = dof < 3 * model.node_count();
    const RotationalDof turn =
        translation ? RotationalDof{dof / 3, dof % 3} : model.rotations[size_t(dof - 3 * model.node_count())];
    const int direction = turn.axis + (translation ? 0 : 3);
    const int row = slots[size_t(6 * turn.node + direction)];
    if (row == kNone)
      throw FileError(named(model.node_ids[size_t(turn.node)], direction + 1) + " has no row.", where,
                      "hold the body by springs instead of supports, which take their rows out of the matrix.");
    place[size_t(row)] = dof;
  }
  for (size_t k = 0; k < rows.size(); ++k)
    if (place[k] == kNone && used[k])
      throw FileError("row " + std::to_string(k + 1) + " (" + named(rows[k].node, rows[k].direction) +
                          ") is not a degree of freedom of the model.",
                      where, "export this matrix for the same mesh and elements as stiffness and mass.");
  return placed(matrix, place, model.dof_count());
}

SparseMatrix placed(const SparseMatrix& A, const std::vector<int>& place, int size) {
  Triplets entries;
  entries.reserve(static_cast<size_t>(A.nonZeros()));
  for (int j = 0; j < A.outerSize(); ++j)
    for (SparseMatrix::InnerIterator e(A, j); e; ++e) {
      const int row = place[static_cast<size_t>(e.row())], column = place[static_cast<size_t>(j)];
      if (row >= 0 && column >= 0) entries.emplace_back(row, column, e.value());
    }
  SparseMatrix B(size, size);
  B.setFromTriplets(entries.begin(), entries.end());
  return B;
}

/// Wᵀ W with W = L⁻¹ K_an is symmetric to the last bit.
SparseMatrix condensed(const SparseMatrix& K, int kept, const std::string& path) {
  const auto all = static_cast<int>(K.rows());
  SparseMatrix result = K.topLeftCorner(kept, kept);
  if (kept == all) return result;

  Triplets updates;
  std::vector<char> visited(static_cast<size_t>(all), 0);
  for (int seed = kept; seed < all; ++seed) {
    if (visited[static_cast<size_t>(seed)]) continue;
    std::vector<int> block{seed}, around;
    visited[static_cast<size_t>(seed)] = 1;
    for (size_t k = 0; k < block.size(); ++k)
      for (SparseMatrix::InnerIterator e(K, block[k]); e; ++e) {
        const int row = static_cast<int>(e.row());
        if (row < kept) {
          around.push_back(row);
        } else if (!visited[static_cast<size_t>(row)]) {
          visited[static_cast<size_t>(row)] = 1;
          block.push_back(row);
        }
      }
    if (block.size() + around.size() > 100 * kLargestBlock || block.size() > kLargestBlock)
      throw FileError(std::to_string(block.size()) + " rows of no node hang together.", path, kFreeBody);
    std::sort(around.begin(), around.end());
    around.erase(std::unique(around.begin(), around.end()), around.end());

    MatrixX K_aa = MatrixX::Zero(static_cast<Eigen::Index>(block.size()), static_cast<Eigen::Index>(block.size()));
    MatrixX K_an = MatrixX::Zero(K_aa.rows(), static_cast<Eigen::Index>(around.size()));
    std::unordered_map<int, Eigen::Index> row_of;
    for (size_t k = 0; k < block.size(); ++k) row_of[block[k]] = static_cast<Eigen::Index>(k);
    for (size_t k = 0; k < block.size(); ++k)
      for (SparseMatrix::InnerIterator e(K, block[k]); e; ++e) {
        const int row = static_cast<int>(e.row());
        const auto c = static_cast<Eigen::Index>(k);
        if (row >= kept)
          K_aa(row_of[row], c) = e.value();
        else
          K_an(c, std::lower_bound(around.begin(), around.end(), row) - around.begin()) = e.value();
      }
    const Eigen::LLT<MatrixX> factor(K_aa);
    if (factor.info() != Eigen::Success)
      throw FileError("the stiffness of appended rows is not positive definite (row " + std::to_string(seed + 1) +
                          " in the order of the model).",
                      path, "export the unloaded body; look for elements turned inside out.");
    const MatrixX W = factor.matrixL().solve(K_an);
    const MatrixX update = W.transpose() * W;
    for (Eigen::Index c = 0; c < update.cols(); ++c)
      for (Eigen::Index r = 0; r < update.rows(); ++r)
        updates.emplace_back(around[static_cast<size_t>(r)], around[static_cast<size_t>(c)], -update(r, c));
  }
  SparseMatrix correction(kept, kept);
  correction.setFromTriplets(updates.begin(), updates.end());
  result += correction;
  return result;
}

}  // namespace lithe
