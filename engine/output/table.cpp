#include "engine/output/table.h"

#include <algorithm>

namespace lithe {

namespace {

std::string list_of(const std::vector<std::string>& names) {
  std::string list;
  for (const auto& name : names) list += (list.empty() ? "" : ", ") + name;
  return list.empty() ? "none" : list;
}

}  // namespace

void Table::add_row(std::span<const double> row, std::source_location where) {
  if (row.size() != columns.size())
    throw SceneError("a row of " + std::to_string(row.size()) + " values does not fit " +
                         std::to_string(columns.size()) + " columns.",
                     to_string(where), "give one value for each of: " + list_of(columns) + ".");
  values.insert(values.end(), row.begin(), row.end());
}

int Table::row_count() const {
  if (columns.empty() && values.empty()) return 0;
  if (columns.empty() || values.size() % columns.size() != 0)
    throw SceneError("the table's " + std::to_string(values.size()) + " values do not fill whole rows of " +
                         std::to_string(columns.size()) + " columns.",
                     "table with columns " + list_of(columns), "fill tables through add_row().");
  return static_cast<int>(values.size() / columns.size());
}

std::vector<double> Table::column(const Located& name) const {
  const auto found = std::find(columns.begin(), columns.end(), name.text);
  if (found == columns.end())
    throw SceneError("the table has no column '" + name.text + "'.", to_string(name.where),
                     "known are " + list_of(columns) + ".");
  const auto offset = static_cast<std::size_t>(found - columns.begin());
  std::vector<double> result(static_cast<std::size_t>(row_count()));
  for (std::size_t row = 0; row < result.size(); ++row) result[row] = values[row * columns.size() + offset];
  return result;
}

double Table::at(int row, int column, std::source_location where) const {
  const int rows = row_count(), width = static_cast<int>(columns.size());
  if (row < 0 || row >= rows || column < 0 || column >= width)
    throw SceneError(
        "the table has no value at row " + std::to_string(row) + ", column " + std::to_string(column) + ".",
        to_string(where),
        "it has " + std::to_string(rows) + " rows and " + std::to_string(width) + " columns, from 0.");
  return values[static_cast<std::size_t>(row) * columns.size() + static_cast<std::size_t>(column)];
}

}  // namespace lithe
