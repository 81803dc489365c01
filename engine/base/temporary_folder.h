#pragma once

#include <filesystem>
#include <string>

namespace lithe {

/// An empty folder of its own below the system's temporary one, which goes with this and with all that it holds.
class TemporaryFolder {
 public:
  /// `name` begins the folder's. Throws FileError where none can be made.
  explicit TemporaryFolder(const std::string& name);
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace lithe
