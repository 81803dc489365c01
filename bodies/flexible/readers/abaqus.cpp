#include "bodies/flexible/readers/abaqus.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "bodies/flexible/readers/calculix_deck.h"
#include "bodies/flexible/readers/dof_table.h"
#include "bodies/flexible/readers/labelled_mesh.h"
#include "bodies/flexible/readers/text_file.h"

namespace lithe {
namespace {

constexpr const char* kAbaqusExport =
    "run *MATRIX GENERATE and *MATRIX OUTPUT, STIFFNESS, MASS again, on the free body.";
constexpr double kBoundaryCondition = 1e35;  // Abaqus puts 1e36 on the diagonal of a supported row

/// By commas, which need not have blanks around them, or by blanks.
std::vector<std::string_view> tokens_of(TextFile& file) {
  if (file.line().find(',') == std::string_view::npos) return file.words();
  auto fields = file.fields();
  if (fields.back().empty()) fields.pop_back();
  return fields;
}

class MatrixReader {
 public:
  MatrixReader(const std::string& path, const std::vector<int>& node_ids)
      : file_(path, kAbaqusExport), node_ids_(node_ids) {}

  LabelledMatrix read() {
    matrix_.path = file_.path();
    while (file_.next()) {
      const std::string_view line = trimmed(file_.line());
      if (line.empty()) continue;
      if (line.substr(0, 2) == "**" || line[0] == '%')
        add_comment();
      else if (line[0] == '*')
        add_keyword(lower_case(line));
      else
        add_entry();
    }
    if (file_.ended_in_mid_line()) file_.fail("the last line has no end: the file is cut.", kAbaqusExport);
    if (matrix_.entries.empty()) file_.fail("the file lists no entry.", kAbaqusExport);
    if (columns_ == 3) name_rows();
    return std::move(matrix_);
  }

 private:
  /// A comment of three whole numbers names a row; all others are words.
  void add_comment() {
    const auto tokens = tokens_of(file_);
    std::vector<std::string_view> numbers;
    for (std::string_view token : tokens) {
      const size_t start = std::min(token.find_first_not_of("*% \t"), token.size());
      if (start == token.size()) continue;
      token.remove_prefix(start);
      if (token.find_first_not_of("+-0123456789") != std::string_view::npos) return;
      numbers.push_back(token);
    }
    if (numbers.size() != 3) return;
    const int row = file_.integer(numbers[0], "row");
    if (row != static_cast<int>(rows_.size()) + 1)
      file_.fail("row " + std::to_string(row) + " is named after row " + std::to_string(rows_.size()) + ".",
                 kAbaqusExport);
    rows_.push_back({file_.integer(numbers[1], "node label"), file_.integer(numbers[2], "direction")});
  }

  void add_keyword(const std::string& line) {
    if (line.rfind("*matrix", 0) != 0 || !matrix_.entries.empty())
      file_.fail("'" + line.substr(0, 40) + "' in a file of one matrix.", "give the .mtx of one assembled matrix.");
    if (line.find("unsymmetric") != std::string::npos) matrix_.general = true;
  }

  void add_entry() {
    const auto tokens = tokens_of(file_);
    if (columns_ == 0 && (tokens.size() == 3 || tokens.size() == 5)) columns_ = tokens.size();
    if (tokens.size() != columns_)
      file_.fail("a line of " + std::to_string(tokens.size()) + " numbers.",
                 "lines are node, direction, node, direction, value, or row, column, value; the file may be cut.");
    const double value = file_.number(tokens.back(), "matrix entry");
    if (std::abs(value) >= kBoundaryCondition)
      file_.fail("an entry of " + std::string(tokens.back()) + " marks a boundary condition.",
                 "export the free body, without *BOUNDARY.");
    if (columns_ == 5) {
      matrix_.entries.push_back({label(tokens[0], tokens[1]), label(tokens[2], tokens[3]), value});
      return;
    }
    // Numbers for the time being; name_rows() puts the labels in their place.
    const int row = file_.integer(tokens[0], "row"), column = file_.integer(tokens[1], "column");
    const size_t most = rows_.empty() ? 6 * node_ids_.size() : rows_.size();
    for (int number : {row, column}) {
      if (number < 1 || static_cast<size_t>(number) > most)
        file_.fail("row or column " + std::to_string(number) + ", where at most " + std::to_string(most) + " can be.",
                   "rows count from 1; take deck and matrices from the same run.");
      size_ = std::max(size_, number);
    }
    matrix_.entries.push_back({{row, 0}, {column, 0}, value});
  }

  DofRow label(std::string_view node, std::string_view direction) const {
    return {file_.integer(node, "node label"), file_.integer(direction, "direction")};
  }

  void name_rows() {
    const int nodes = static_cast<int>(node_ids_.size());
    if (rows_.empty()) {
      if (size_ != 3 * nodes && size_ != 6 * nodes)
        file_.fail("a matrix of " + std::to_string(size_) + " rows for " + std::to_string(nodes) + " nodes.",
                   "free nodes have three or six rows each. Write FORMAT=MATRIX INPUT, which names them; the file may "
                   "also be cut.");
      rows_ = rows_by_label(node_ids_, size_ / nodes);
    } else if (static_cast<size_t>(size_) != rows_.size()) {
      file_.fail(
          "a matrix of " + std::to_string(size_) + " rows, of which " + std::to_string(rows_.size()) + " are named.",
          "the file is cut; export it again.");
    }
    for (auto& e : matrix_.entries) {
      e.row = rows_[static_cast<size_t>(e.row.node) - 1];
      e.column = rows_[static_cast<size_t>(e.column.node) - 1];
    }
  }

  TextFile file_;
  const std::vector<int>& node_ids_;
  LabelledMatrix matrix_;
  std::vector<DofRow> rows_;  // named by comments
  size_t columns_ = 0;        // 3 or 5, by the first entry
  int size_ = 0;
};

}  // namespace

FiniteElementModel read_abaqus(const AbaqusFiles& files) {
  const CalculixDeck deck = read_calculix_deck(files.deck);
  FiniteElementModel model = labelled_mesh(files.deck, deck.node_ids, deck.positions, deck.elements);
  model.node_sets = deck.node_sets;
  const LabelledMatrix K = MatrixReader(files.stiffness, model.node_ids).read();
  const LabelledMatrix M = MatrixReader(files.mass, model.node_ids).read();
  const std::vector<DofRow> rows = rows_of(K, M);
  place_matrices(rows, assembled(K, rows), assembled(M, rows), files.stiffness, model);
  return model;
}

}  // namespace lithe
