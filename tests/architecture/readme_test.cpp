// What the README shows is a piece of a tested file.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <set>
#include <string>

namespace lithe::test {
namespace {

namespace fs = std::filesystem;

TEST(Readme, shows_only_lines_of_the_examples) {
  const fs::path root = LITHE_SOURCE_DIR;
  std::set<std::string> lines;
  for (const auto& file : fs::directory_iterator(root / "examples")) {
    std::ifstream in(file.path());
    for (std::string line; file.path().extension() == ".cpp" && std::getline(in, line);) lines.insert(line);
  }
  std::ifstream readme(root / "README.md");
  bool inside = false;
  int shown = 0;
  for (std::string line; std::getline(readme, line);) {
    if (line.starts_with("```")) {
      inside = line == "```cpp";
      continue;
    }
    if (!inside || line.empty()) continue;
    ++shown;
    EXPECT_TRUE(lines.contains(line)) << "README.md shows a line that no example has:\n" << line;
  }
  EXPECT_GT(shown, 10);
}

TEST(Readme, links_to_files_that_exist) {
  const fs::path root = LITHE_SOURCE_DIR;
  std::ifstream readme(root / "README.md");
  const std::string text{std::istreambuf_iterator<char>(readme), {}};
  int links = 0;
  for (std::size_t at = text.find("]("); at != std::string::npos; at = text.find("](", at + 1), ++links) {
    const std::string target = text.substr(at + 2, text.find(')', at) - at - 2);
    EXPECT_TRUE(fs::exists(root / target)) << target;
  }
  EXPECT_GT(links, 5);
}

}  // namespace
}  // namespace lithe::test
