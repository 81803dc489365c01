#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "engine/output/table.h"

namespace lithe {

class Hdf5Series;

/// A table that is written row by row during a run, so that a killed run leaves its rows on disk. As .csv each row
/// is one write() of its line; as .h5 the rows are flushed one by one (hdf5_series.h), and the file is that of
/// write_hdf5(). Throws FileError if the file cannot be written or read.
class TableStream {
 public:
  /// Throws SceneError for another ending. Nothing is written yet.
  explicit TableStream(std::string path);
  ~TableStream();
  TableStream(const TableStream&) = delete;
  TableStream& operator=(const TableStream&) = delete;

  const std::string& path() const { return path_; }
  /// The first row begins the file and replaces one of that name.
  void append(const std::vector<std::string>& columns, std::span<const double> row);
  /// Begins the file with these rows and replaces one of that name.
  void begin(const Table& rows);
  /// Truncates a file of these columns to its first rows, to continue after them; returns them. Throws FileError for a
  /// file with fewer.
  Table go_on(const std::vector<std::string>& columns, int rows);

 private:
  [[noreturn]] void fail() const;
  void write(const std::string& text);

  std::string path_;
  int file_ = -1;  // .csv
  bool is_text_, begun_ = false;
  std::unique_ptr<Hdf5Series> series_;  // .h5
};

}  // namespace lithe
