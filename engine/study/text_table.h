#pragma once

#include <algorithm>
#include <string>
#include <vector>

namespace lithe {

/// Letters of a UTF-8 text, as columns of a terminal count them.
inline std::size_t letter_count(const std::string& text) {
  return std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) != 0x80; });
}

/// The text, or its beginning and "…" where it has more letters than `most`.
inline std::string shortened(const std::string& text, std::size_t most) {
  if (letter_count(text) <= most) return text;
  std::size_t end = 0;
  for (std::size_t letters = 0; letters + 1 < most; ++letters)
    for (++end; end < text.size() && (text[end] & 0xC0) == 0x80;) ++end;  // a letter with all its bytes
  return text.substr(0, end) + "…";
}

/// A table of texts for a fixed-width font, columns aligned; the first and the last to the left, the others to the
/// right.
class TextTable {
 public:
  void add(std::vector<std::string> row) { rows_.push_back(std::move(row)); }
  std::string text() const {
    std::vector<std::size_t> widths;
    for (const auto& row : rows_) {
      widths.resize(std::max(widths.size(), row.size()));
      for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], letter_count(row[i]));
    }
    std::string out;
    for (const auto& row : rows_) {
      std::string line;
      for (std::size_t i = 0; i < row.size(); ++i) {
        const std::string blanks(widths[i] - letter_count(row[i]), ' ');
        const bool left = i == 0 || i + 1 == widths.size();
        line += (i == 0 ? "" : "  ") + (left ? row[i] + blanks : blanks + row[i]);
      }
      out += line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
    }
    return out;
  }

 private:
  std::vector<std::vector<std::string>> rows_;
};

}  // namespace lithe
