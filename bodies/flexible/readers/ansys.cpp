#include "bodies/flexible/readers/ansys.h"

#include <algorithm>
#include <array>
#include <vector>

#include "bodies/flexible/readers/ansys_archive.h"
#include "bodies/flexible/readers/dof_table.h"
#include "bodies/flexible/readers/fixed_columns.h"
#include "bodies/flexible/readers/harwell_boeing.h"
#include "bodies/flexible/readers/matrix_entries.h"
#include "bodies/flexible/readers/matrix_market.h"
#include "bodies/flexible/readers/text_file.h"
#include "engine/base/error.h"

namespace lithe {
namespace {

constexpr const char* kMapping = "write the mapping with the matrix: HBMAT,name,ext,,ASCII,STIFF,NO,YES.";

bool whole_number(std::string_view word) {
  return !word.empty() && word.find_first_not_of("0123456789") == std::string_view::npos;
}

/// 1-6, or 0 for what belongs to no direction.
int direction_of(const TextFile& file, std::string_view label) {
  static constexpr std::array<std::string_view, 6> kLabels = {"ux", "uy", "uz", "rotx", "roty", "rotz"};
  const std::string name = lower_case(label);
  const auto found = std::find(kLabels.begin(), kLabels.end(), name);
  if (found != kLabels.end()) return static_cast<int>(found - kLabels.begin()) + 1;
  if (name == "pres" || name == "hdsp") return 0;  // of mixed u-P elements
  file.fail(
      "unknown degree of freedom '" + std::string(label.substr(0, 20)) + "'.",
      "known are UX, UY, UZ, ROTX, ROTY, ROTZ, PRES and HDSP: export a structural model of solids, shells, beams.");
}

std::vector<DofRow> read_row_list(TextFile& file) {
  std::vector<DofRow> rows;
  do {
    const auto& words = file.words();
    if (words.empty() || (rows.empty() && !whole_number(words[0]))) continue;  // headings
    if (words.size() != 3) file.fail("a line of " + std::to_string(words.size()) + " words.", kMapping);
    const int row = file.integer(words[0], "row number"), node = file.integer(words[1], "node label");
    if (row != static_cast<int>(rows.size()) + 1)
      file.fail("row " + std::to_string(row) + " follows row " + std::to_string(rows.size()) + ".", kMapping);
    rows.push_back({node, direction_of(file, words[2])});
  } while (file.next());
  return rows;
}

/// A dense Matrix Market array of integers: node, or node and direction, column by column.
std::vector<DofRow> read_row_vectors(TextFile& file, int matrix_rows) {
  const std::string header = lower_case(file.line());
  if (header.find("array") == std::string::npos)
    file.fail("the mapping is not an array.", "export the vector by *VEC,name,EXPORT,MMF,file.");
  while (file.next() && (file.blank() || file.line()[0] == '%')) continue;
  const auto& sizes = file.words();
  if (sizes.size() != 2) file.fail("the line of sizes does not have two numbers.", kMapping);
  const int length = file.integer(sizes[0], "number of rows"), columns = file.integer(sizes[1], "number of columns");
  if (length < 1 || (columns != 1 && columns != 2) ||
      (columns == 2 ? length != matrix_rows : matrix_rows % length != 0))
    file.fail("a mapping of " + std::to_string(length) + " x " + std::to_string(columns) + " for a matrix of " +
                  std::to_string(matrix_rows) + " rows.",
              "give one line a row (node, direction), or one line a node, each with the same number of rows.");
  const int directions = columns == 1 ? matrix_rows / length : 1;
  if (columns == 1 && directions != 3 && directions != 6)
    file.fail(std::to_string(directions) + " rows a node.", "nodes have three or six rows: UX, UY, UZ, ROTX ...");

  std::vector<int> values;
  while (file.next()) {
    if (file.blank()) continue;
    const double value = fortran_number(file, trimmed(file.line()), "mapping entry");
    if (value != static_cast<int>(std::clamp(value, -1.0, 2147483647.0))) file.fail("no whole number.", kMapping);
    values.push_back(static_cast<int>(value));
  }
  if (values.size() != static_cast<size_t>(length) * static_cast<size_t>(columns))
    file.fail(std::to_string(values.size()) + " entries for an array of " + std::to_string(length) + " x " +
                  std::to_string(columns) + ".",
              "the file is cut; export it again.");
  std::vector<DofRow> rows;
  for (int k = 0; k < length; ++k)
    for (int d = 1; d <= directions; ++d)
      rows.push_back({values[size_t(k)], columns == 2 ? values[size_t(length + k)] : d});
  return rows;
}

std::vector<DofRow> read_rows(const std::string& path, int matrix_rows) {
  TextFile file(path, kMapping);
  if (!file.next()) file.fail("the file is empty.", kMapping);
  const bool vectors = file.line().rfind("%%", 0) == 0;
  std::vector<DofRow> rows = vectors ? read_row_vectors(file, matrix_rows) : read_row_list(file);
  if (file.ended_in_mid_line()) file.fail("the last line has no end: the file is cut.", kMapping);
  if (static_cast<int>(rows.size()) != matrix_rows)
    file.fail(std::to_string(rows.size()) + " rows are named, the matrix has " + std::to_string(matrix_rows) + ".",
              "take mapping and matrix from the same export.");
  return rows;
}

/// Matrix Market array (*DMAT, EXPORT, MMF), whose header has been read: column by column, of a symmetric one from the
/// diagonal on. Zeros are not stored.
SparseMatrix read_dense_matrix(TextFile& file) {
  const std::string header = lower_case(file.line());
  const bool symmetric = header.find(" real symmetric") != std::string::npos;
  if (!symmetric && header.find(" real general") == std::string::npos)
    file.fail("the header is '" + header.substr(0, 80) + "'.", "export a real matrix, symmetric or general.");
  while (file.next() && (file.blank() || file.line()[0] == '%')) continue;
  const auto& sizes = file.words();
  if (sizes.size() != 2) file.fail("the line of sizes does not have two numbers.", "export the matrix again.");
  const int rows = file.integer(sizes[0], "number of rows");
  if (rows < 1 || rows != file.integer(sizes[1], "number of columns"))
    file.fail("the matrix is not square.", "K and M are square.");
  MatrixEntries entries(rows);
  for (int j = 0; j < rows; ++j)
    for (int i = symmetric ? j : 0; i < rows; ++i) {
      do {
        if (!file.next()) file.fail("the file ends in column " + std::to_string(j + 1) + ".", "it is cut.");
      } while (file.blank());
      const double value = fortran_number(file, trimmed(file.line()), "matrix entry");
      if (value != 0) entries.add(i, j, value);
    }
  while (file.next())
    if (!file.blank()) file.fail("the file goes on after the last entry.", "export the matrix again.");
  return symmetric ? entries.symmetric(file.path()) : entries.general(file.path());
}

SparseMatrix read_matrix(const std::string& path) {
  TextFile file(path, "give the matrix that HBMAT or *SMAT,name,EXPORT,MMF wrote.");
  if (!file.next()) file.fail("the file is empty.", "export the matrix again.");
  if (file.line().rfind("%%MatrixMarket", 0) != 0) return read_harwell_boeing(path);
  const bool dense = lower_case(file.line()).find(" array ") != std::string::npos;
  return dense ? read_dense_matrix(file) : read_matrix_market_file(path);
}

}  // namespace

FiniteElementModel read_ansys(const AnsysFiles& files) {
  FiniteElementModel model;
  model.name = files.stiffness;
  read_ansys_archive(files.nodes, model);
  const SparseMatrix K = read_matrix(files.stiffness), M = read_matrix(files.mass);
  if (M.rows() != K.rows())
    throw FileError("the mass matrix has " + std::to_string(M.rows()) + " rows, the stiffness matrix " +
                        std::to_string(K.rows()) + ".",
                    files.mass, "take both from the same .full file.");
  place_matrices(read_rows(files.mapping, static_cast<int>(K.rows())), K, M, files.mapping, model);
  return model;
}

SparseMatrix read_stress_stiffness_ansys(const std::string& matrix, const std::string& mapping,
                                         const FiniteElementModel& model) {
  const SparseMatrix K = read_matrix(matrix);
  return in_model_order(read_rows(mapping, static_cast<int>(K.rows())), K, mapping, model);
}

}  // namespace lithe
