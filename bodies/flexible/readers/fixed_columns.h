#pragma once

#include <string_view>

#include "bodies/flexible/readers/text_file.h"

namespace lithe {

/// Numbers in columns of fixed width, as Fortran writes them: (10I8), (1P,3E26.18), (3D25.16).
struct ColumnFormat {
  int per_line = 1;
  int width = 0;
};
/// From the Fortran format, with or without parentheses and scale factor. FileError if it is none of the above.
ColumnFormat column_format(const TextFile& file, std::string_view text);

/// A number that may have a D for its E, or an exponent without either, as in 1.5D-3 and 1.5-3.
double fortran_number(const TextFile& file, std::string_view token, std::string_view what);

/// `width` characters of the line from `start` on, without blanks around them; what lies beyond the line is empty.
std::string_view column_of(std::string_view line, size_t start, size_t width);

/// Reads one number after the other; the first starts a new line. FileError at the end of the file or an empty column.
class ColumnReader {
 public:
  ColumnReader(TextFile& file, ColumnFormat format) : file_(file), format_(format), at_(format.per_line) {}
  int integer(std::string_view what) { return file_.integer(next(what), what); }
  double number(std::string_view what) { return fortran_number(file_, next(what), what); }

 private:
  std::string_view next(std::string_view what);

  TextFile& file_;
  ColumnFormat format_;
  int at_;  // column that is next, format_.per_line: on the next line
};

}  // namespace lithe
