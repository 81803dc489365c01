#pragma once

#include <istream>
#include <string>

#include "engine/output/table.h"

namespace lithe {

/// Comma-separated values: a header line of column names (quoted where they hold a comma or a quote), then one line a
/// row. Numbers are the shortest text that reads back as the same double. Parent folders are created; the file appears
/// under its name only when complete. Throws FileError if it cannot be written, SceneError for a table without columns
/// or a column name with a line break.
void write_csv(const Table& table, const std::string& path);

/// Reads what write_csv() writes, and similar files: blanks around names and numbers, Windows line ends and empty lines
/// are accepted. Throws FileError with file:line for a row of the wrong length or a text that is not finite.
Table read_csv(const std::string& path);
/// The same from text; `path` is for messages.
Table read_csv(std::istream& text, const std::string& path);

}  // namespace lithe
