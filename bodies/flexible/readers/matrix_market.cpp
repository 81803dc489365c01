#include "bodies/flexible/readers/matrix_market.h"

#include <cmath>
#include <unordered_map>

#include "bodies/flexible/readers/matrix_entries.h"
#include "bodies/flexible/readers/text_file.h"
#include "engine/base/error.h"

namespace lithe {
namespace {

/// The header's first columns; the file must begin with them.
void require_header(TextFile& file, std::string_view expected) {
  if (!file.next()) file.fail("the file is empty.", "its first line must be " + std::string(expected) + ",...");
  if (lower_case(file.line()).rfind(expected, 0) != 0)
    file.fail("the header is '" + std::string(file.line().substr(0, 60)) + "'.",
              "its first line must begin with " + std::string(expected) + ".");
}

struct NodeIndex {
  std::unordered_map<int, int> index;
  int at(const TextFile& file, int id) const {
    const auto found = index.find(id);
    if (found == index.end())
      file.fail("node " + std::to_string(id) + " is not in the list of nodes.",
                "add it to nodes.csv or remove it here.");
    return found->second;
  }
};

NodeIndex read_nodes(const std::string& path, FiniteElementModel& model) {
  TextFile file(path, "give the table of nodes: node,x,y,z.");
  require_header(file, "node,x,y,z");
  NodeIndex nodes;
  std::vector<double> positions;
  while (file.next()) {
    if (file.blank()) continue;
    const auto& fields = file.fields();
    if (fields.size() != 4)
      file.fail(std::to_string(fields.size()) + " columns instead of 4.", "write node,x,y,z; the file may be cut.");
    const int id = file.integer(fields[0], "node label");
    if (!nodes.index.emplace(id, static_cast<int>(model.node_ids.size())).second)
      file.fail("node " + std::to_string(id) + " is given twice.", "number each node once.");
    model.node_ids.push_back(id);
    for (size_t k = 1; k < 4; ++k) positions.push_back(file.number(fields[k], "node coordinate"));
  }
  if (model.node_ids.empty()) file.fail("the file lists no node.", "write one line node,x,y,z for each node.");
  model.nodes = Eigen::Map<const Matrix3X>(positions.data(), 3, static_cast<Eigen::Index>(positions.size() / 3));
  return nodes;
}

void read_node_sets(const std::string& path, const NodeIndex& nodes, FiniteElementModel& model) {
  TextFile file(path, "give the table of node sets, or leave its name out.");
  require_header(file, "set,position,node");
  const double size = (model.nodes.colwise() - model.nodes.col(0)).colwise().norm().maxCoeff();
  while (file.next()) {
    if (file.blank()) continue;
    const auto& fields = file.fields();
    if (fields.size() != 3 && fields.size() != 6)
      file.fail(std::to_string(fields.size()) + " columns instead of 3 or 6.", "write set,position,node[,x,y,z].");
    if (fields[0].empty()) file.fail("a set without a name.", "write set,position,node.");
    auto& members = model.node_sets[lower_case(fields[0])];
    const int position = file.integer(fields[1], "position"), id = file.integer(fields[2], "node label");
    if (position != static_cast<int>(members.size()) + 1)
      file.fail("position " + std::to_string(position) + " of set '" + std::string(fields[0]) + "' follows position " +
                    std::to_string(members.size()) + ".",
                "list the nodes of a set in order, counted from 1.");
    const int index = nodes.at(file, id);
    // Coordinates that disagree mean that the nodes were renumbered between the two files.
    for (size_t k = 3; k < fields.size(); ++k)
      if (std::abs(file.number(fields[k], "node coordinate") - model.nodes(static_cast<Eigen::Index>(k) - 3, index)) >
          1e-9 * size)
        file.fail("node " + std::to_string(id) + " stands elsewhere in the list of nodes.",
                  "take nodes and sets from the same export.");
    members.push_back(id);
  }
}

void read_elements(const std::string& path, const NodeIndex& nodes, FiniteElementModel& model) {
  TextFile file(path, "give the table of elements, or leave its name out.");
  require_header(file, "element,n1");
  ElementBlock block;
  while (file.next()) {
    if (file.blank()) continue;
    const auto& fields = file.fields();
    const size_t count = fields.size() - 1;
    if (count != 4 && count != 6 && count != 8 && count != 10 && count != 15 && count != 20)
      file.fail("an element of " + std::to_string(count) + " nodes.", "solids have 4, 6, 8, 10, 15 or 20 nodes.");
    const std::string type = "C3D" + std::to_string(count);
    if (!block.type.empty() && block.type != type)
      file.fail("an element of type " + type + " among " + block.type + ".", "give one type of elements a file.");
    block.type = type;
    file.integer(fields[0], "element label");
    std::vector<int> element;
    for (size_t k = 1; k <= count; ++k) element.push_back(nodes.at(file, file.integer(fields[k], "node label")));
    block.nodes.push_back(std::move(element));
  }
  if (block.nodes.empty()) file.fail("the file lists no element.", "leave its name out if there are none.");
  model.elements.push_back(std::move(block));
}

SparseMatrix read_matrix_of(const std::string& path, const FiniteElementModel& model, const std::string& nodes_csv) {
  SparseMatrix A = read_matrix_market_file(path);
  if (A.rows() != 3 * model.node_count())
    throw FileError("a matrix of " + std::to_string(A.rows()) + " rows, but " + std::to_string(model.node_count()) +
                        " nodes have " + std::to_string(3 * model.node_count()) + " degrees of freedom.",
                    path, "take matrix and nodes (" + nodes_csv + ") from the same export, without supports.");
  return A;
}

}  // namespace

SparseMatrix read_matrix_market_file(const std::string& path) {
  TextFile file(path, "give a Matrix Market file.");
  if (!file.next()) file.fail("the file is empty.", "export the matrix again.");
  const auto& header = file.words();
  std::string kind;
  for (const auto& word : header) kind += (kind.empty() ? "" : " ") + lower_case(word);
  const bool symmetric = kind == "%%matrixmarket matrix coordinate real symmetric";
  if (!symmetric && kind != "%%matrixmarket matrix coordinate real general")
    file.fail("the header is '" + std::string(file.line().substr(0, 80)) + "'.",
              "the first line must be '%%MatrixMarket matrix coordinate real symmetric' (or general).");

  bool found = false;
  while (!found && file.next()) found = !file.blank() && file.line()[0] != '%';
  if (!found) file.fail("the line of sizes is missing.", "export the matrix again; the file is cut.");
  const auto& sizes = file.words();
  if (sizes.size() != 3) file.fail("the line of sizes does not have three numbers.", "write rows, columns, entries.");
  const int rows = file.integer(sizes[0], "number of rows"), columns = file.integer(sizes[1], "number of columns");
  const int count = file.integer(sizes[2], "number of entries");
  if (rows != columns || rows < 1 || count < 0)
    file.fail("a matrix of " + std::to_string(rows) + " x " + std::to_string(columns) + ".", "K and M are square.");
  if (rows > count)
    file.fail(std::to_string(count) + " entries for " + std::to_string(rows) + " rows: some row is empty.",
              "every degree of freedom needs stiffness and mass; export the matrix again.");

  MatrixEntries entries(rows);
  while (file.next()) {
    if (file.blank()) continue;
    if (entries.count() == count)
      file.fail("more entries than the " + std::to_string(count) + " announced.", "export the matrix again.");
    entries.add_line(file);
  }
  if (entries.count() < count)
    file.fail("the file ends after " + std::to_string(entries.count()) + " of " + std::to_string(count) + " entries.",
              "export or copy it again: it is truncated.");
  return symmetric ? entries.symmetric(path) : entries.general(path);
}

FiniteElementModel read_matrix_market(const std::string& stiffness_mtx, const std::string& mass_mtx,
                                      const std::string& nodes_csv, const std::string& node_sets_csv,
                                      const std::string& elements_csv) {
  FiniteElementModel model;
  model.name = stiffness_mtx;
  const NodeIndex nodes = read_nodes(nodes_csv, model);
  if (!node_sets_csv.empty()) read_node_sets(node_sets_csv, nodes, model);
  if (!elements_csv.empty()) read_elements(elements_csv, nodes, model);
  model.stiffness = read_matrix_of(stiffness_mtx, model, nodes_csv);
  model.mass = read_matrix_of(mass_mtx, model, nodes_csv);
  return model;
}

}  // namespace lithe
