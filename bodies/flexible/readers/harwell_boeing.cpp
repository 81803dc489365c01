#include "bodies/flexible/readers/harwell_boeing.h"

#include <algorithm>
#include <vector>

#include "bodies/flexible/readers/fixed_columns.h"
#include "bodies/flexible/readers/matrix_entries.h"
#include "bodies/flexible/readers/text_file.h"

namespace lithe {
namespace {

constexpr const char* kHarwellBoeingExport = "export the matrix again: HBMAT,name,ext,,ASCII,STIFF,NO,YES.";

void next_line(TextFile& file, const char* what) {
  if (!file.next()) file.fail("the " + std::string(what) + " is missing: the file is cut.", kHarwellBoeingExport);
}

/// The formats of a line, each in its parentheses (blanks and further parentheses may be inside).
std::vector<std::string> formats_of(std::string_view line) {
  std::vector<std::string> formats;
  int depth = 0;
  for (char c : line) {
    if (c == '(' && depth++ == 0) formats.emplace_back();
    if (depth > 0) formats.back() += c;
    if (c == ')' && depth > 0) --depth;
  }
  return formats;
}

}  // namespace

SparseMatrix read_harwell_boeing(const std::string& path) {
  TextFile file(path, kHarwellBoeingExport);
  next_line(file, "title");
  next_line(file, "line of line counts");
  const auto counts = file.words();
  if (counts.size() < 4)
    file.fail("the second line does not have the four or five numbers of lines.", kHarwellBoeingExport);
  for (const auto& count : counts) file.integer(count, "number of lines");
  const bool right_hand_sides = counts.size() > 4 && file.integer(counts[4], "number of lines") > 0;

  next_line(file, "line of type and sizes");
  const auto& sizes = file.words();
  if (sizes.size() < 4)
    file.fail("the third line does not have type, rows, columns and entries.", kHarwellBoeingExport);
  const std::string type = lower_case(sizes[0]);
  if (type != "rsa" && type != "rua")
    file.fail("the matrix is of type '" + std::string(sizes[0].substr(0, 20)) + "'.",
              "stiffness and mass are real, square and assembled: RSA or RUA.");
  const int rows = file.integer(sizes[1], "number of rows"), columns = file.integer(sizes[2], "number of columns");
  const int count = file.integer(sizes[3], "number of entries");
  if (rows != columns || rows < 1 || count < 1)
    file.fail("a matrix of " + std::to_string(rows) + " x " + std::to_string(columns) + " with " +
                  std::to_string(count) + " entries.",
              "K and M are square.");

  next_line(file, "line of formats");
  const auto formats = formats_of(file.line());
  if (formats.size() < 3)
    file.fail("the fourth line does not have the formats of pointers, rows and values.", kHarwellBoeingExport);
  const ColumnFormat pointer_format = column_format(file, formats[0]), row_format = column_format(file, formats[1]);
  const ColumnFormat value_format = column_format(file, formats[2]);
  if (right_hand_sides) next_line(file, "line of right-hand sides");

  // Nothing is reserved by the header: what is stored has been read.
  std::vector<int> pointers, row_numbers;
  ColumnReader pointer_reader(file, pointer_format);
  for (int j = 0; j <= columns; ++j) {
    pointers.push_back(pointer_reader.integer("column pointer"));
    if (j == 0 ? pointers[0] != 1 : pointers.back() < pointers[size_t(j) - 1])
      file.fail("column pointer " + std::to_string(pointers.back()) + " of column " + std::to_string(j + 1) + ".",
                "pointers begin with 1 and do not fall; export the matrix again.");
  }
  if (pointers.back() - 1 != count)
    file.fail("the columns have " + std::to_string(pointers.back() - 1) + " entries, the header says " +
                  std::to_string(count) + ".",
              kHarwellBoeingExport);
  ColumnReader row_reader(file, row_format);
  for (int j = 0; j < columns; ++j)
    for (int k = pointers[size_t(j)], last = 0; k < pointers[size_t(j) + 1]; ++k) {
      const int row = row_reader.integer("row number");
      if (row <= last || row > rows)
        file.fail("row " + std::to_string(row) + " after row " + std::to_string(last) + " in column " +
                      std::to_string(j + 1) + " of " + std::to_string(columns) + ".",
                  "the rows of a column ascend, each once; export the matrix again.");
      row_numbers.push_back(last = row);
    }
  MatrixEntries entries(rows);
  ColumnReader value_reader(file, value_format);
  for (int j = 0; j < columns; ++j)
    for (int k = pointers[size_t(j)]; k < pointers[size_t(j) + 1]; ++k)
      entries.add(row_numbers[size_t(k) - 1] - 1, j, value_reader.number("matrix entry"));
  while (!right_hand_sides && file.next())
    if (!file.blank()) file.fail("the file goes on after the last entry.", kHarwellBoeingExport);
  return type == "rsa" ? entries.symmetric(path) : entries.general(path);
}

}  // namespace lithe
