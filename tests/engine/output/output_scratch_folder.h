#pragma once

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "engine/base/temporary_folder.h"
#include "tests/support/message_of.h"

namespace lithe::test {

/// An empty folder of its own for one test, removed with all it holds.
class ScratchFolder {
 public:
  std::string path(const std::string& name) const { return (folder_.path() / name).string(); }
  int file_count() const {
    int count = 0;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder_.path()))
      count += entry.is_regular_file();
    return count;
  }

 private:
  const TemporaryFolder folder_{"lithe_output"};
};

inline std::string file_text(const std::string& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

inline void write_text(const std::string& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

}  // namespace lithe::test
