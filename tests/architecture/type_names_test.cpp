// Types of headers have names of their own: two of one name are one to the linker, which takes the functions of either.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

namespace lithe::test::type_names_test {
namespace {

namespace fs = std::filesystem;

/// Where the types of a header are defined: "lithe::Body" -> "engine/model/body.h:71". Types within others are those
/// others' business.
void read_types(std::istream& text, const std::string& path, std::map<std::string, std::vector<std::string>>& places) {
  static const std::regex enters(R"(^namespace ([\w:]+) \{)"), leaves(R"(^\}  // namespace)"),
      defines(R"(^(?:class|struct) (\w+)(?: final)?(?: : .*)? \{)");
  std::vector<std::string> within;
  std::smatch found;
  int number = 0;
  for (std::string line; std::getline(text, line);) {
    ++number;
    if (std::regex_search(line, found, enters)) within.push_back(found[1]);
    if (std::regex_search(line, leaves) && !within.empty()) within.pop_back();
    if (!std::regex_search(line, found, defines)) continue;
    std::string name;
    for (const std::string& space : within) name += space + "::";
    places[name + found[1].str()].push_back(path + ":" + std::to_string(number));
  }
}

TEST(TypeNames, AreThoseOfOneTypeEach) {
  std::map<std::string, std::vector<std::string>> places;
  for (const char* folder : {"engine", "bodies", "joints", "integrators", "plugins", "models"})
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(LITHE_SOURCE_DIR) / folder)) {
      if (entry.path().extension() != ".h") continue;
      std::ifstream file(entry.path());
      read_types(file, fs::relative(entry.path(), LITHE_SOURCE_DIR).string(), places);
    }
  EXPECT_GT(places.size(), 300u) << "the headers were not found";
  for (const auto& [name, all] : places) {
    std::string text;
    for (const std::string& place : all) text += " " + place;
    EXPECT_EQ(all.size(), 1u) << name << " is defined at" << text;
  }
}

TEST(TypeNames, AreToldApartByTheirNamespaces) {
  std::istringstream header(
      "namespace lithe {\nclass Row;\nstruct Row {\n};\nnamespace detail {\nstruct Row final : Body {\n};\n"
      "}  // namespace detail\nstruct Row {\n};\n}  // namespace lithe\n");
  std::map<std::string, std::vector<std::string>> places;
  read_types(header, "a.h", places);
  EXPECT_EQ(places["lithe::Row"], (std::vector<std::string>{"a.h:3", "a.h:9"}));
  EXPECT_EQ(places["lithe::detail::Row"], (std::vector<std::string>{"a.h:6"}));
}

}  // namespace
}  // namespace lithe::test::type_names_test
