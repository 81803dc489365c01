#include "bodies/flexible/readers/calculix.h"

#include <algorithm>
#include <set>
#include <unordered_map>
#include <unordered_set>

#include "bodies/flexible/readers/calculix_deck.h"
#include "bodies/flexible/readers/dof_table.h"
#include "bodies/flexible/readers/matrix_entries.h"
#include "bodies/flexible/readers/text_file.h"
#include "engine/base/error.h"
#include "engine/base/log.h"

namespace lithe {
namespace {

constexpr const char* kExport =
    "run *FREQUENCY, SOLVER=MATRIXSTORAGE on the free body and keep .inp, .sti, .mas, .dof.";

std::string without_extension(const std::string& job) {
  for (const char* extension : {".inp", ".sti", ".mas", ".dof"})
    if (job.size() > 4 && lower_case(job.substr(job.size() - 4)) == extension) return job.substr(0, job.size() - 4);
  return job;
}

/// One line of .dof: "54.3" is node 54, direction 3.
struct Row {
  int node, direction;
};

std::vector<Row> read_rows(const std::string& path) {
  TextFile file(path, kExport);
  std::vector<Row> rows;
  while (file.next()) {
    if (file.blank()) continue;
    const std::string_view token = trimmed(file.line());
    const size_t point = token.find('.');
    if (point == std::string_view::npos)
      file.fail("'" + std::string(token.substr(0, 40)) + "' is not node.direction.", kExport);
    const Row row{file.integer(token.substr(0, point), "node label"),
                  file.integer(token.substr(point + 1), "direction")};
    if (row.direction < 1 || row.direction > 3)
      file.fail("direction " + std::to_string(row.direction) + " of node " + std::to_string(row.node) + ".",
                "only translations 1, 2, 3 are known: export solids, without temperatures, beams or shells.");
    rows.push_back(row);
  }
  if (rows.empty()) file.fail("the file lists no row.", kExport);
  if (file.ended_in_mid_line()) file.fail("the last line has no end: the file is cut.", kExport);
  return rows;
}

SparseMatrix read_triangle(const std::string& path, int rows) {
  TextFile file(path, kExport);
  MatrixEntries entries(rows);
  while (file.next())
    if (!file.blank()) entries.add_line(file);
  if (file.ended_in_mid_line()) file.fail("the last line has no end: the file is cut.", kExport);
  SparseMatrix A = entries.symmetric(path);
  // CalculiX writes every diagonal entry, the last one at the end: a missing one tells a cut file.
  VectorX found = VectorX::Zero(rows);
  for (int j = 0; j < rows; ++j)
    for (SparseMatrix::InnerIterator e(A, j); e; ++e)
      if (e.row() == j) found[j] = 1;
  for (int j = 0; j < rows; ++j)
    if (found[j] == 0)
      file.fail("row " + std::to_string(j + 1) + " of " + std::to_string(rows) + " has no diagonal entry.",
                "the file is truncated, or not of the same export as .dof; write it again.");
  return A;
}

/// Where each matrix row goes: 3 * node + axis for nodes, 3 n, 3 n + 1, ... for appended rows.
struct Numbering {
  std::vector<int> place;
  int nodal = 0, appended = 0;
};

Numbering number_rows(const std::string& path, const std::vector<Row>& rows, const FiniteElementModel& model) {
  std::unordered_map<int, int> index;
  for (size_t i = 0; i < model.node_ids.size(); ++i) index.emplace(model.node_ids[i], static_cast<int>(i));
  Numbering numbering;
  numbering.nodal = 3 * model.node_count();
  std::vector<char> taken(static_cast<size_t>(numbering.nodal), 0);
  std::set<std::pair<int, int>> hidden;
  for (size_t k = 0; k < rows.size(); ++k) {
    const Row& row = rows[k];
    const auto found = index.find(row.node);
    const auto twice = [&] {
      throw FileError(
          "node " + std::to_string(row.node) + ", direction " + std::to_string(row.direction) + " has two rows.",
          path + ":" + std::to_string(k + 1), kExport);
    };
    if (found == index.end()) {
      if (!hidden.emplace(row.node, row.direction).second) twice();
      numbering.place.push_back(numbering.nodal + numbering.appended++);
      continue;
    }
    const int dof = 3 * found->second + row.direction - 1;
    if (taken[static_cast<size_t>(dof)]++) twice();
    numbering.place.push_back(dof);
  }
  for (size_t dof = 0; dof < taken.size(); ++dof)
    if (!taken[dof])
      throw FileError("node " + std::to_string(model.node_ids[dof / 3]) + " has no row for direction " +
                          std::to_string(dof % 3 + 1) + ".",
                      path,
                      "export the free body: no *BOUNDARY, *EQUATION, *TIE, *COUPLING or *RIGID BODY in the deck; the "
                      "file may also be cut.");
  return numbering;
}

/// Nodes, sets and elements of the deck; nodes that belong to no element and no row are left out.
FiniteElementModel mesh_of(const CalculixDeck& deck, const std::vector<Row>& rows, const std::string& job) {
  std::unordered_set<int> in_use;
  for (const Row& row : rows) in_use.insert(row.node);
  for (const ElementBlock& block : deck.elements)
    for (const auto& element : block.nodes) in_use.insert(element.begin(), element.end());

  FiniteElementModel model;
  model.name = job;
  std::vector<Vector3> positions;
  std::unordered_map<int, int> index;
  for (size_t i = 0; i < deck.node_ids.size(); ++i) {
    if (!in_use.count(deck.node_ids[i])) continue;
    index.emplace(deck.node_ids[i], static_cast<int>(model.node_ids.size()));
    model.node_ids.push_back(deck.node_ids[i]);
    positions.push_back(deck.positions[i]);
  }
  const size_t dropped = deck.node_ids.size() - model.node_ids.size();
  if (dropped > 0)
    log::warn(job + ".inp: " + std::to_string(dropped) + " node(s) belong to no element and no row; left out.");
  model.nodes.resize(3, static_cast<Eigen::Index>(positions.size()));
  for (size_t i = 0; i < positions.size(); ++i) model.nodes.col(static_cast<Eigen::Index>(i)) = positions[i];
  for (const auto& [set, members] : deck.node_sets) {
    auto& kept = model.node_sets[set];
    for (int id : members)
      if (index.count(id)) kept.push_back(id);
  }
  model.elements = deck.elements;
  for (ElementBlock& block : model.elements)
    for (auto& element : block.nodes)
      for (int& node : element) node = index.at(node);
  return model;
}

}  // namespace

FiniteElementModel read_calculix(const std::string& job_or_file) {
  const std::string job = without_extension(job_or_file);
  const CalculixDeck deck = read_calculix_deck(job + ".inp");
  const std::vector<Row> rows = read_rows(job + ".dof");
  FiniteElementModel model = mesh_of(deck, rows, job);

  const Numbering numbering = number_rows(job + ".dof", rows, model);
  if (numbering.appended != 9 * deck.incompatible_elements)
    throw FileError(
        std::to_string(numbering.appended) + " rows belong to nodes that no *NODE defines, but " +
            std::to_string(deck.incompatible_elements) + " C3D8I elements account for " +
            std::to_string(9 * deck.incompatible_elements) + ".",
        job + ".dof",
        "take deck and matrices from the same run; beams and shells, which CalculiX expands, are not read.");

  const auto size = static_cast<int>(rows.size());
  const SparseMatrix K = placed(read_triangle(job + ".sti", size), numbering.place, size);
  const SparseMatrix M = placed(read_triangle(job + ".mas", size), numbering.place, size);
  model.stiffness = condensed(K, numbering.nodal, job + ".sti");
  model.mass = M.topLeftCorner(numbering.nodal, numbering.nodal);
  return model;
}

}  // namespace lithe
