#include "engine/base/temporary_folder.h"

#include <stdlib.h>

#include "engine/base/error.h"

namespace lithe {

TemporaryFolder::TemporaryFolder(const std::string& name) {
  std::error_code error;
  const std::filesystem::path folder = std::filesystem::temp_directory_path(error);
  constexpr const char* kUnique = "_XXXXXX";  // as mkdtemp() asks for
  std::string path = (folder / (name + kUnique)).string();
  if (error || !mkdtemp(path.data()))
    throw FileError("no temporary folder can be made.", folder.string(), "set TMPDIR to a folder that can be written.");
  path_ = path;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

}  // namespace lithe
