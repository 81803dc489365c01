#pragma once

#include <filesystem>
#include <string>

namespace lithe {

/// The file that a scene reads, a table, a reduced body, a plug-in: `path` itself, from the folder that the program
/// runs in. Within an FMU it is the file of that name among the resources, where `lithe fmu --resource PATH` has put
/// it. Throws SceneError for a path that no FMU could have: an absolute one, or one that leads out of its folder.
std::filesystem::path resource(const std::string& path);

/// While it lives, resource() looks in this folder, in this thread; an empty one changes nothing.
class ResourceFolder {
 public:
  explicit ResourceFolder(std::filesystem::path folder);
  /// By its address, as in "file:///data/a%20b"; null or another kind of address: none.
  static std::filesystem::path of_address(const char* address);
  ~ResourceFolder();
  ResourceFolder(const ResourceFolder&) = delete;
  ResourceFolder& operator=(const ResourceFolder&) = delete;

 private:
  const std::filesystem::path folder_;
  const std::filesystem::path* const outer_;
};

}  // namespace lithe
