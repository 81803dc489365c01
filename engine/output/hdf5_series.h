#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "engine/base/math.h"

namespace lithe {

/// An HDF5 file that grows row by row while a simulation runs. First what stays the same, and the names and widths of
/// the growing data sets (times x width) and their first rows; then begin(), which gives the file its name; then more
/// rows. After flush() the rows appended so far are in the file, and it can be opened at any moment since begin(): by
/// readers beside the run, and after a run that was killed, even in the middle of a row (HDF5's protocol for one writer
/// and many readers, SWMR). A file whose run was killed opens with Hdf5Reader and other readers in SWMR mode, with all
/// programs after `h5clear -s FILE`. Data sets may then differ by the row that was being written: append last, after a
/// flush(), the one that counts. Rows have no checksum, since a chunk cut by a kill would then lose its older rows too.
/// Not guaranteed: data still in the operating system's memory when the power fails.
/// Needs HDF5 1.10 to read. Throws FileError if the file cannot be written.
class Hdf5Series {
 public:
  explicit Hdf5Series(std::string path);
  /// Closes the file; without begin() no file remains.
  ~Hdf5Series();
  Hdf5Series(const Hdf5Series&) = delete;
  Hdf5Series& operator=(const Hdf5Series&) = delete;

  void write(const std::string& name, const MatrixX& matrix);  // column by column, as Hdf5Writer
  void write(const std::string& name, const std::vector<int>& integers);
  void write(const std::string& name, const std::vector<std::string>& texts);  // as bytes, each closed by a zero
  /// An attribute of a data set or the file ("/"): a unit, axes.
  void attribute(const std::string& of, const std::string& name, const std::string& text);
  /// A data set of rows, `width` numbers each.
  void add(const std::string& name, int width);
  void begin();
  /// Appends a row, before begin() too; SceneError for another width, or a name that was not added.
  void append(const std::string& name, ConstVectorRef row);
  /// Hands all rows to the operating system.
  void flush();

 private:
  struct Handles;
  [[noreturn]] void fail(const std::string& name) const;
  void write(const std::string& name, std::int64_t type, const std::vector<std::uint64_t>& extent, const void* values);

  std::string path_;
  std::unique_ptr<Handles> handles_;
};

}  // namespace lithe
