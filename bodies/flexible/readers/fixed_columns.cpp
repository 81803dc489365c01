#include "bodies/flexible/readers/fixed_columns.h"

#include <cctype>

namespace lithe {
namespace {

bool digit(char c) { return c >= '0' && c <= '9'; }

/// Digits at `at`, which moves behind them; 0 if there are none, and for more than any line holds.
int count_at(std::string_view text, size_t& at) {
  int count = 0;
  for (; at < text.size() && digit(text[at]); ++at)
    if (count < 100000) count = 10 * count + (text[at] - '0');
  return count < 100000 ? count : 0;
}

}  // namespace

ColumnFormat column_format(const TextFile& file, std::string_view text) {
  std::string format;
  for (char c : text)
    if (c != ' ' && c != '(' && c != ')') format += static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  size_t at = 0;
  int count = count_at(format, at);
  if (at < format.size() && format[at] == 'P') {  // a scale factor, which changes nothing in numbers with exponents
    at += at + 1 < format.size() && format[at + 1] == ',' ? 2 : 1;
    count = count_at(format, at);
  }
  ColumnFormat columns{count > 0 ? count : 1, 0};
  const bool known = at < format.size() && std::string("IEDFG").find(format[at]) != std::string::npos;
  if (known) columns.width = count_at(format, ++at);
  if (columns.width < 1 || columns.width > 100 || columns.per_line > 1000)
    file.fail("the format of columns is '" + std::string(text.substr(0, 40)) + "'.",
              "formats are such as (10I8) or (1P,3E26.18); export the file again, as text.");
  return columns;
}

double fortran_number(const TextFile& file, std::string_view token, std::string_view what) {
  std::string text(token.substr(0, 60));
  for (size_t k = 1; k < text.size(); ++k) {
    if (text[k] == 'D' || text[k] == 'd') text[k] = 'E';
    if ((text[k] == '+' || text[k] == '-') && (digit(text[k - 1]) || text[k - 1] == '.')) text.insert(k++, "E");
  }
  return file.number(text, what);
}

std::string_view column_of(std::string_view line, size_t start, size_t width) {
  return start < line.size() ? trimmed(line.substr(start, width)) : std::string_view();
}

std::string_view ColumnReader::next(std::string_view what) {
  if (at_ == format_.per_line) {
    if (!file_.next())
      file_.fail("the file ends where a " + std::string(what) + " should stand.", "it is cut; export it again.");
    at_ = 0;
  }
  const auto width = static_cast<size_t>(format_.width);
  const std::string_view token = column_of(file_.line(), static_cast<size_t>(at_++) * width, width);
  if (token.empty())
    file_.fail("column " + std::to_string(at_) + " is empty, where a " + std::string(what) + " should stand.",
               "columns are " + std::to_string(width) + " characters wide; the file may be cut: export it again.");
  return token;
}

}  // namespace lithe
