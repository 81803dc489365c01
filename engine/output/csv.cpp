#include "engine/output/csv.h"

#include <fstream>
#include <string_view>

#include "engine/base/number_text.h"
#include "engine/output/partial_file.h"

namespace lithe {

namespace {

std::string quoted_if_needed(const std::string& name) {
  if (name.find_first_of(",\"") == std::string::npos) return name;
  std::string quoted = "\"";
  for (const char c : name) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + '"';
}

// Splits a line at its commas; a comma or a doubled quote inside quotes belongs to the text.
std::vector<std::string> split(std::string_view line) {
  std::vector<std::string> cells(1);
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i] == '"' && quoted && i + 1 < line.size() && line[i + 1] == '"')
      cells.back() += line[++i];
    else if (line[i] == '"')
      quoted = !quoted;
    else if (line[i] == ',' && !quoted)
      cells.emplace_back();
    else
      cells.back() += line[i];
  }
  return cells;
}

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\r");
  return first == std::string_view::npos ? "" : text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

double parse_number(std::string_view text, const std::string& where, const std::string& column) {
  const std::string_view number = trimmed(text);
  double value = 0;
  const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), value);
  if (error != std::errc{} || end != number.data() + number.size())
    throw FileError("'" + std::string(number) + "' in column '" + column + "' is not a number a double can hold.",
                    where, "write numbers like -1.5e-3, with a decimal point.");
  return value;
}

}  // namespace

void write_csv(const Table& table, const std::string& path) try {
  if (table.columns.empty())
    throw SceneError("a table without columns cannot be written.", path, "name its columns before adding rows.");
  std::string line;
  for (const auto& name : table.columns) {
    if (name.find_first_of("\r\n") != std::string::npos)
      throw SceneError("a column name holds a line break: '" + name + "'.", path, "write the name on one line.");
    if (&name != &table.columns.front()) line += ',';
    line += quoted_if_needed(name);
  }

  PartialFile file(path);
  file.stream() << line << '\n';
  const std::size_t rows = static_cast<std::size_t>(table.row_count()), width = table.columns.size();
  for (std::size_t row = 0; row < rows; ++row) {
    line.clear();
    for (std::size_t column = 0; column < width; ++column) {
      if (column > 0) line += ',';
      append_number(line, table.values[row * width + column]);
    }
    file.stream() << line << '\n';
  }
  file.commit();
} catch (...) {
  rethrow_as_error("writing the file", path, "see what it says; an older file of that name is unharmed");
}

Table read_csv(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw FileError("cannot open the CSV file.", path, "check the path and the right to read it.");
  return read_csv(file, path);
}

Table read_csv(std::istream& file, const std::string& path) try {
  std::string line;
  if (!std::getline(file, line) || trimmed(line).empty())
    throw FileError("the CSV file has no header line.", path + ":1", "its first line must name the columns.");
  Table table;
  for (const auto& name : split(line)) table.columns.emplace_back(trimmed(name));

  for (int number = 2; std::getline(file, line); ++number) {
    if (trimmed(line).empty()) continue;
    const std::string where = path + ":" + std::to_string(number);
    const auto cells = split(line);
    if (cells.size() != table.columns.size())
      throw FileError("the row has " + std::to_string(cells.size()) + " values, the header names " +
                          std::to_string(table.columns.size()) + " columns.",
                      where, "complete the row, or remove it if the file was cut short.");
    for (std::size_t i = 0; i < cells.size(); ++i)
      table.values.push_back(parse_number(cells[i], where, table.columns[i]));
  }
  return table;
} catch (...) {
  rethrow_as_error("reading the file", path, "see what it says");
}

}  // namespace lithe
