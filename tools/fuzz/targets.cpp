#include "tools/fuzz/targets.h"

#include <fstream>

namespace lithe::fuzz {

void demand(bool holds, const char* what) {
  if (!holds) throw SilentAcceptance(what);
}

std::string file_of(std::string_view input, const std::filesystem::path& folder, const std::string& name) {
  const std::string path = (folder / name).string();
  std::ofstream(path, std::ios::binary) << input;
  return path;
}

}  // namespace lithe::fuzz
