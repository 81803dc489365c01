#pragma once

#include <zip.h>

#include <filesystem>
#include <string>

#include "tests/models/scratch_folder.h"

namespace lithe::test {

/// An FMU packed as a test wants it: a library built with the tests and a description.
class TestFmu {
 public:
  /// `version`: 2 or 3; `identifier`: the modelIdentifier of the description.
  TestFmu(int version, const std::string& identifier, const std::string& library, const std::string& description) {
    const std::filesystem::path there = file(version == 2 ? "binaries/linux64" : "binaries/x86_64-linux");
    std::filesystem::create_directories(there);
    std::filesystem::copy_file(library, there / (identifier + ".so"));
    describe(description);
  }

  /// Another modelDescription.xml.
  void describe(const std::string& text) const { folder_.write("content/modelDescription.xml", text); }
  std::string file(const std::string& inside) const { return (path() / "content" / inside).string(); }
  std::filesystem::path path() const { return folder_.path(); }
  /// The archive; its path.
  std::string packed(const std::string& name = "model") const {
    const std::string out = (path() / (name + ".fmu")).string();
    zip_t* zip = zip_open(out.c_str(), ZIP_CREATE | ZIP_TRUNCATE, nullptr);
    const std::filesystem::path content = path() / "content";
    for (const auto& entry : std::filesystem::recursive_directory_iterator(content)) {
      const std::string inside = std::filesystem::relative(entry.path(), content).string();
      if (entry.is_directory())
        zip_dir_add(zip, inside.c_str(), ZIP_FL_ENC_UTF_8);
      else
        zip_file_add(zip, inside.c_str(), zip_source_file(zip, entry.path().c_str(), 0, -1), ZIP_FL_ENC_UTF_8);
    }
    EXPECT_EQ(zip_close(zip), 0);
    return out;
  }

 private:
  ScratchFolder folder_;
};

inline std::string replaced(std::string text, const std::string& what, const std::string& by) {
  const std::size_t at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return at == std::string::npos ? text : text.replace(at, what.size(), by);
}

}  // namespace lithe::test
