#pragma once

#include <filesystem>
#include <string>

namespace lithe {

/// An FMU's archive, unpacked into a folder of its own, which goes with this.
class FmuPackage {
 public:
  /// Throws FileError for a file that is missing, no zip archive or damaged, that names files outside the folder, or
  /// links, or more than 100,000 files or 4 GiB.
  explicit FmuPackage(const std::string& path);
  ~FmuPackage();
  FmuPackage(const FmuPackage&) = delete;
  FmuPackage& operator=(const FmuPackage&) = delete;

  const std::string& path() const { return path_; }
  const std::filesystem::path& folder() const { return folder_; }

 private:
  [[noreturn]] void fail(const std::string& problem, const std::string& fix) const;
  void unpack();

  const std::string path_;
  std::filesystem::path folder_;
};

}  // namespace lithe
