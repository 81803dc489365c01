#pragma once

#include <string>
#include <vector>

#include "bodies/flexible/readers/text_file.h"
#include "engine/base/math.h"

namespace lithe {

/// A line of Standard Input Data: "m1( 3, 1, 1) = 4.98D-01" is key "m1", indices {3, 1, 1} and value "4.98D-01".
struct SidLine {
  std::string key;  // lower case, single blanks
  std::vector<int> indices;
  std::string value;
};

/// One Taylor table, whole: m0 dense, m1 a matrix a mode (none when the order is 0).
struct SidTable {
  int line = 0;  // where it begins
  int structure = 0;
  MatrixX m0;
  std::vector<MatrixX> m1;
  MatrixX first(int mode) const {
    return m1.empty() ? MatrixX::Zero(m0.rows(), m0.cols()) : m1[static_cast<size_t>(mode)];
  }
};

/// The shapes a table may have.
struct SidShape {
  int rows, columns;
};

/// Standard Input Data read line by line.
class SidFile {
 public:
  explicit SidFile(const std::string& path);

  /// The next line that is not blank; FileError at the end of the file.
  const SidLine& next();
  const SidLine& line() const { return line_; }
  TextFile& text() { return text_; }
  double number(const std::string& token, std::string_view what) const;  // FORTRAN's D exponents, too
  /// "key = value" with a whole number, the next line.
  int integer_of(const std::string& key, int lowest, int highest);
  /// The table `name`, whose first line was just read, to its "end name".
  SidTable table(const std::string& name, int modes, const std::vector<SidShape>& shapes, int highest_order = 1);
  [[noreturn]] void fail(const std::string& problem) const;

 private:
  void add_entry(SidTable& table, const std::string& name, int order, int modes);

  TextFile text_;
  SidLine line_;
};

}  // namespace lithe
