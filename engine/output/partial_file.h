#pragma once

#include <fstream>
#include <ostream>
#include <string>

namespace lithe {

/// A file that has a temporary name beside its final one until commit(), so that a killed run leaves either the old
/// file or the new one, never part of it. Without commit() the destructor removes what was written. Devices and pipes
/// (/dev/stdout) are written straight away.
class PartialFile {
 public:
  /// Creates the parent folders and opens the temporary file; throws FileError if either cannot be done.
  explicit PartialFile(std::string path);
  ~PartialFile();
  PartialFile(const PartialFile&) = delete;
  PartialFile& operator=(const PartialFile&) = delete;

  std::ostream& stream() { return stream_; }
  const std::string& temporary_path() const { return temporary_path_; }
  /// Closes the file and gives it its final name; throws FileError if the disk is full or the name is taken by a
  /// folder.
  void commit();

 private:
  std::string path_, temporary_path_;
  std::ofstream stream_;
};

}  // namespace lithe
