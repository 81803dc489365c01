#include "bodies/flexible/readers/nastran.h"

#include <algorithm>

#include "bodies/flexible/readers/dof_table.h"
#include "bodies/flexible/readers/labelled_mesh.h"
#include "bodies/flexible/readers/nastran_deck.h"
#include "bodies/flexible/readers/nastran_op4.h"
#include "bodies/flexible/readers/text_file.h"
#include "engine/base/error.h"

namespace lithe {
namespace {

/// A matrix with or without names of its rows.
struct Found {
  std::string name, path;
  const LabelledMatrix* labelled = nullptr;
  const SparseMatrix* plain = nullptr;
};

const Found& chosen(const std::vector<Found>& all, const std::string& asked, const std::vector<const char*>& usual,
                    const std::string& path) {
  const auto named = [&](const std::string& name) {
    return std::find_if(all.begin(), all.end(), [&](const Found& found) { return found.name == name; });
  };
  auto found = all.end();
  if (!asked.empty()) {
    found = named(lower_case(asked));
  } else {
    for (size_t k = 0; k < usual.size() && found == all.end(); ++k) found = named(usual[k]);
    if (found == all.end())
      found = std::find_if(all.begin(), all.end(), [&](const Found& any) { return any.name[0] == usual[0][0]; });
  }
  if (found != all.end()) return *found;
  std::string known;
  for (const Found& any : all) known += (known.empty() ? "" : ", ") + any.name;
  throw FileError("there is no real square matrix " + (asked.empty() ? usual[0] : "'" + asked + "'") + ".", path,
                  known.empty() ? "give DMIG entries or a file of OUTPUT4." : "found are " + known + "; name one.");
}

std::vector<DofRow> read_row_list(const std::string& path) {
  constexpr const char* kFix = "write one line a row: node and direction (1-6; 0 for scalar points).";
  TextFile file(path, kFix);
  std::vector<DofRow> rows;
  while (file.next()) {
    if (file.blank()) continue;
    const auto& words = file.words();
    if (words.size() != 2) file.fail("a line of " + std::to_string(words.size()) + " words.", kFix);
    rows.push_back({file.integer(words[0], "node label"), file.integer(words[1], "direction")});
    if (rows.back().node < 1 || rows.back().direction < 0 || rows.back().direction > 6)
      file.fail(
          "node " + std::to_string(rows.back().node) + ", direction " + std::to_string(rows.back().direction) + ".",
          kFix);
  }
  if (file.ended_in_mid_line()) file.fail("the last line has no end: the file is cut.", kFix);
  return rows;
}

std::vector<DofRow> rows_of_output4(const NastranFiles& files, const Found& K, const FiniteElementModel& model) {
  if (!files.rows.empty()) return read_row_list(files.rows);
  const auto rows = static_cast<int>(K.plain->rows());
  const int nodes = model.node_count();
  if (rows != 3 * nodes && rows != 6 * nodes)
    throw FileError(
        "matrix " + K.name + " has " + std::to_string(rows) + " rows for " + std::to_string(nodes) + " nodes.", K.path,
        "free nodes have three or six rows each; for others, give the list of rows, or write DMIG, which "
        "names them.");
  return rows_by_label(model.node_ids, rows / nodes);
}

}  // namespace

FiniteElementModel read_nastran(const NastranFiles& files) {
  NastranDeck deck;
  read_nastran_deck(files.deck, deck);
  std::vector<std::pair<std::string, std::vector<Op4Matrix>>> plain;
  for (const std::string& path : files.matrices) {
    if (is_op4(path))
      plain.emplace_back(path, read_op4(path));
    else
      read_nastran_deck(path, deck);
  }
  if (deck.node_ids.empty())
    throw FileError("no GRID entry.", files.deck, "give the bulk data with the nodes of the body.");
  std::vector<Found> all;
  for (const NastranMatrix& matrix : deck.matrices)
    if (!matrix.matrix.entries.empty()) all.push_back({matrix.name, matrix.matrix.path, &matrix.matrix, nullptr});
  for (const auto& [path, matrices] : plain)
    for (const Op4Matrix& matrix : matrices)
      if (!matrix.name.empty()) all.push_back({matrix.name, path, nullptr, &matrix.matrix});

  const std::string where = files.matrices.empty() ? files.deck : files.matrices[0];
  const Found& K = chosen(all, files.stiffness, {"kaax", "kgg", "k2gg", "kaa", "kxx"}, where);
  const Found& M = chosen(all, files.mass, {"maax", "mgg", "m2gg", "maa", "mxx"}, where);
  if ((K.labelled == nullptr) != (M.labelled == nullptr))
    throw FileError("matrix " + K.name + " is of another format than " + M.name + ".", M.path,
                    "write both as DMIG, or both by OUTPUT4.");
  FiniteElementModel model = labelled_mesh(files.deck, deck.node_ids, deck.positions, deck.elements);
  if (K.labelled != nullptr) {
    const std::vector<DofRow> rows = rows_of(*K.labelled, *M.labelled);
    place_matrices(rows, assembled(*K.labelled, rows), assembled(*M.labelled, rows), K.path, model);
  } else {
    place_matrices(rows_of_output4(files, K, model), *K.plain, *M.plain, K.path, model);
  }
  return model;
}

}  // namespace lithe
