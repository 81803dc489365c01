#include "bodies/flexible/readers/sid_table.h"

#include <algorithm>
#include <cmath>

namespace lithe {
namespace {

constexpr const char* kWriteAgain = "write the SID file again; it may be cut or edited.";

std::string single_blanks(std::string_view text) {
  std::string result;
  for (char c : lower_case(trimmed(text)))
    if (c != '\t' && !(c == ' ' && (result.empty() || result.back() == ' '))) result += c;
  if (!result.empty() && result.back() == ' ') result.pop_back();
  return result;
}

}  // namespace

SidFile::SidFile(const std::string& path) : text_(path, "give a file of Standard Input Data (.SID_FEM).") {}

void SidFile::fail(const std::string& problem) const { text_.fail(problem, kWriteAgain); }

double SidFile::number(const std::string& token, std::string_view what) const {
  std::string digits = token;
  std::replace_if(
      digits.begin(), digits.end(), [](char c) { return c == 'D' || c == 'd'; }, 'E');
  return text_.number(digits, what);
}

const SidLine& SidFile::next() {
  do {
    if (!text_.next()) fail("the file ends before 'end part'.");
  } while (text_.blank());
  const std::string_view line = text_.line();
  const size_t equal = std::min(line.find('='), line.size());
  line_.value = equal < line.size() ? std::string(trimmed(line.substr(equal + 1))) : "";
  line_.indices.clear();
  std::string_view left = line.substr(0, equal);
  if (const size_t open = left.find('('); open != std::string_view::npos && equal < line.size()) {
    const size_t close = left.find(')', open);
    if (close == std::string_view::npos || !trimmed(left.substr(close + 1)).empty())
      fail("an index without its closing bracket.");
    std::string_view inside = left.substr(open + 1, close - open - 1);
    for (size_t comma = 0; comma != std::string_view::npos && line_.indices.size() < 4;) {
      comma = inside.find(',');
      line_.indices.push_back(text_.integer(trimmed(inside.substr(0, comma)), "index"));
      if (comma != std::string_view::npos) inside.remove_prefix(comma + 1);
    }
    left = left.substr(0, open);
  }
  line_.key = single_blanks(left);
  return line_;
}

int SidFile::integer_of(const std::string& key, int lowest, int highest) {
  next();
  if (line_.key != key || line_.value.empty())
    fail("'" + line_.key.substr(0, 40) + "' where '" + key + " = ' should stand.");
  const int value = text_.integer(line_.value, key);
  if (value < lowest || value > highest)
    fail(key + " is " + std::to_string(value) + ", it lies between " + std::to_string(lowest) + " and " +
         std::to_string(highest) + ".");
  return value;
}

void SidFile::add_entry(SidTable& table, const std::string& name, int order, int modes) {
  const bool zeroth = line_.key == "m0";
  if (!zeroth && line_.key != "m1")
    fail("'" + line_.key.substr(0, 40) + "' in table " + name + ", where m0, m1 or 'end " + name + "' should stand.");
  if (!zeroth && order == 0) fail("an entry m1 in table " + name + " of order 0.");
  const auto& index = line_.indices;
  if (index.size() != (zeroth ? 2u : 3u))
    fail(line_.key + " with " + std::to_string(index.size()) + " indices in table " + name + ".");
  const int row = index[0], mode = zeroth ? 1 : index[1], column = index.back();
  if (row < 1 || row > table.m0.rows() || column < 1 || column > table.m0.cols() || mode < 1 ||
      (!zeroth && mode > modes))
    fail("an entry outside table " + name + " of " + std::to_string(table.m0.rows()) + " x " +
         std::to_string(table.m0.cols()) + " and " + std::to_string(modes) + " modes.");
  const double value = number(line_.value, line_.key);
  double& entry = (zeroth ? table.m0 : table.m1[static_cast<size_t>(mode - 1)])(row - 1, column - 1);
  if (!std::isnan(entry)) fail("an entry of table " + name + " is given twice.");
  if (zeroth && table.structure == 1 && row != column && value != 0) fail("table " + name + " should be diagonal.");
  if (zeroth && (table.structure == 0 || table.structure == 4) && value != (table.structure == 4 && row == column))
    fail("table " + name + " has structure " + std::to_string(table.structure) + ", so it has no such entry.");
  entry = value;
}

SidTable SidFile::table(const std::string& name, int modes, const std::vector<SidShape>& shapes, int highest_order) {
  const std::string key = lower_case(name);
  if (line_.key != key) fail("'" + line_.key.substr(0, 40) + "' where table '" + name + "' should stand.");
  SidTable table;
  table.line = text_.line_number();
  const int order = integer_of("order", 0, highest_order);
  const int rows = integer_of("nrow", 1, 1 << 20), columns = integer_of("ncol", 1, 1 << 20);
  const auto fits = [&](const SidShape& s) { return s.rows == rows && s.columns == columns; };
  if (std::none_of(shapes.begin(), shapes.end(), fits))
    fail("table " + name + " is " + std::to_string(rows) + " x " + std::to_string(columns) + ", not " +
         std::to_string(shapes[0].rows) + " x " + std::to_string(shapes[0].columns) + ".");
  const int counted = integer_of("nq", 0, 1 << 20);
  if (counted != modes && counted != 0)
    fail("table " + name + " counts " + std::to_string(counted) + " modes of " + std::to_string(modes) + ".");
  integer_of("nqn", 0, 1 << 20);
  table.structure = integer_of("structure", 0, 4);

  // NaN marks what no line has given yet.
  table.m0.setConstant(rows, columns, std::nan(""));
  if (order == 1) table.m1.assign(static_cast<size_t>(modes), table.m0);
  const std::string end = "end " + key;
  while (next().key != end) add_entry(table, name, order, modes);

  // One triangle of a symmetric table is enough; what is not given is zero.
  if (table.structure == 2 && rows == columns)
    for (int i = 0; i < rows; ++i)
      for (int j = 0; j < rows; ++j)
        if (std::isnan(table.m0(i, j))) table.m0(i, j) = table.m0(j, i);
  const auto settled = [](const MatrixX& a) -> MatrixX { return a.array().isNaN().select(0, a); };
  table.m0 = settled(table.m0);
  for (MatrixX& a : table.m1) a = settled(a);
  if (table.structure == 4) {
    if (rows != columns) fail("table " + name + " cannot be a unit matrix: it is not square.");
    table.m0.setIdentity();
  }
  if (table.structure == 2 && rows == columns &&
      (table.m0 - table.m0.transpose()).cwiseAbs().maxCoeff() > 1e-6 * table.m0.cwiseAbs().maxCoeff())
    fail("table " + name + " should be symmetric and is not.");
  return table;
}

}  // namespace lithe
