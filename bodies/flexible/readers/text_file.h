#pragma once

#include <fstream>
#include <string>
#include <string_view>
#include <vector>

namespace lithe {

/// A text file read line by line that always knows where it stands, so that every complaint names file:line, what was
/// read and how to fix it. Numbers are read whole or refused: no "1.2x", no NaN, no overflow.
class TextFile {
 public:
  /// Throws FileError if there is no such file; `fix` says where it should come from.
  TextFile(std::string path, const std::string& fix);

  bool next();  // moves to the next line; false at the end
  std::string_view line() const { return line_; }
  const std::string& path() const { return path_; }
  int line_number() const { return number_; }
  std::string where() const;
  bool blank() const;                              // nothing but white space
  bool ended_in_mid_line() const { return cut_; }  // after next() returned false: the last line had no line end

  /// The line cut at white space, or at commas with the white space around them removed. Valid until next().
  const std::vector<std::string_view>& words();
  const std::vector<std::string_view>& fields();

  /// A whole token as a number; FileError otherwise. `what` names it: "column", "x coordinate".
  double number(std::string_view token, std::string_view what) const;
  int integer(std::string_view token, std::string_view what) const;

  [[noreturn]] void fail(const std::string& problem, const std::string& fix) const;

 private:
  std::string path_, line_;
  std::ifstream stream_;
  std::vector<std::string_view> tokens_;
  int number_ = 0;
  bool cut_ = false;
};

std::string_view trimmed(std::string_view text);
std::string lower_case(std::string_view text);

}  // namespace lithe
