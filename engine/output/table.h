#pragma once

#include <initializer_list>
#include <source_location>
#include <span>
#include <string>
#include <vector>

#include "engine/base/error.h"

namespace lithe {

/// Named columns of numbers, one row a sample: what recorders fill, and what csv, binary and chart files hold.
struct Table {
  std::vector<std::string> columns = {};
  std::vector<double> values = {};  // row-major: value (row, column) at row * columns.size() + column

  /// Appends one row; throws SceneError unless it holds one value a column.
  void add_row(std::span<const double> row, std::source_location where = std::source_location::current());
  void add_row(std::initializer_list<double> row, std::source_location where = std::source_location::current()) {
    add_row(std::span<const double>(row.begin(), row.size()), where);
  }

  /// Number of rows; throws SceneError if `values` was filled by hand and its last row is incomplete.
  int row_count() const;
  /// All values of a column, top to bottom; throws SceneError listing the known columns.
  std::vector<double> column(const Located& name) const;
  /// One value; throws SceneError outside the table.
  double at(int row, int column, std::source_location where = std::source_location::current()) const;
};

}  // namespace lithe
