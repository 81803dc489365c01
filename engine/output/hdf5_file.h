#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "engine/base/math.h"

namespace lithe {

/// An HDF5 file that is written: data sets by path ("/modes", "/elements/0/type"), groups come as they are named.
/// Numbers as they lie in memory; matrices column by column, in HDF5's terms columns x rows. The file appears under its
/// name with commit(), not before. All failures throw FileError.
class Hdf5Writer {
 public:
  explicit Hdf5Writer(std::string path);
  ~Hdf5Writer();
  Hdf5Writer(const Hdf5Writer&) = delete;
  Hdf5Writer& operator=(const Hdf5Writer&) = delete;

  void write(const std::string& name, const Eigen::Ref<const MatrixX>& matrix);
  void write(const std::string& name, const std::vector<int>& integers);
  void write(const std::string& name, const std::vector<double>& numbers);
  void write(const std::string& name, const std::string& text);
  void write(const std::string& name, const std::vector<std::string>& texts);
  /// An attribute of a group or data set ("/" is the file): a unit, a version.
  void attribute(const std::string& of, const std::string& name, const std::string& text);
  void attribute(const std::string& of, const std::string& name, std::int64_t number);
  /// Closes the file and gives it its final name.
  void commit();

 private:
  struct Handles;
  std::string path_;
  std::unique_ptr<Handles> handles_;
};

/// An HDF5 file that is read. Sizes and types are checked against what the caller expects; FileError names the path of
/// the file and the data set.
class Hdf5Reader {
 public:
  explicit Hdf5Reader(std::string path);
  ~Hdf5Reader();
  Hdf5Reader(const Hdf5Reader&) = delete;
  Hdf5Reader& operator=(const Hdf5Reader&) = delete;

  static constexpr std::int64_t kAny = -1;
  bool has(const std::string& name) const;
  MatrixX matrix(const std::string& name, std::int64_t rows = kAny, std::int64_t columns = kAny) const;
  std::vector<int> integers(const std::string& name, std::int64_t size = kAny) const;
  std::vector<double> numbers(const std::string& name, std::int64_t size = kAny) const;
  std::string text(const std::string& name) const;
  std::vector<std::string> texts(const std::string& name) const;
  std::string text_attribute(const std::string& of, const std::string& name) const;
  std::int64_t number_attribute(const std::string& of, const std::string& name) const;
  const std::string& path() const { return path_; }
  /// The error of a reader for a data set with wrong content.
  [[noreturn]] void refuse(const std::string& name, const std::string& problem) const;

 private:
  struct Handles;
  std::string path_;
  std::unique_ptr<Handles> handles_;
};

}  // namespace lithe
