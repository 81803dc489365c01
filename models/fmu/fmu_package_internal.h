#pragma once

#include <string>

#include "engine/base/temporary_folder.h"

namespace lithe {

/// An FMU's archive, unpacked into a temporary folder.
class FmuPackage {
 public:
  /// Throws FileError for a file that is missing, no zip archive or damaged, that names files outside the folder, or
  /// links, or more than 100,000 files or 4 GiB.
  explicit FmuPackage(const std::string& path);

  const std::string& path() const { return path_; }
  const std::filesystem::path& folder() const { return folder_.path(); }

 private:
  [[noreturn]] void fail(const std::string& problem, const std::string& fix) const;
  void unpack();

  const std::string path_;
  const TemporaryFolder folder_{"lithe_fmu"};
};

}  // namespace lithe
