#pragma once

#include <filesystem>
#include <string>
#include <vector>

/// HOUSE.md section 1 as a table: which folder may include which, and where each third-party package has its home.
namespace lithe::test {

/// One line of a source file that breaks a rule.
struct Violation {
  std::string file;  // from the repository's root, with '/'
  int line = 0;
  std::string text;    // the line itself
  std::string reason;  // the rule it breaks
};

/// "engine/model/body.h:12: #include <boost/...>: Boost lives in ..."
std::string to_string(const Violation& violation);

/// Reads every source and header in engine/, bodies/, joints/, integrators/, plugins/ and examples/ below `root`: the
/// arrows between folders, the homes of packages, and headers that show a third-party package to their users.
std::vector<Violation> find_violations(const std::filesystem::path& root);

/// Folders of engine/, in the order of the pipeline.
std::vector<std::string> rooms();

/// How many files find_violations reads: a check that it looked at the right tree.
int count_sources(const std::filesystem::path& root);

}  // namespace lithe::test
