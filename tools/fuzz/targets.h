#pragma once

#include <filesystem>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

/// What the fuzzers throw inputs at, and the test that reads their corpus once more (tests/hardening/corpus_test.cpp).
namespace lithe::fuzz {

/// A damaged input that was taken as good: what was read is not finite, or does not fit together.
struct SilentAcceptance : std::logic_error {
  using std::logic_error::logic_error;
};
void demand(bool holds, const char* what);

/// Reads one input. Throws lithe::Error where it is refused, as it may be; SilentAcceptance where it should have been.
struct Target {
  const char* name;
  void (*run)(std::string_view input, const std::filesystem::path& folder);  // a folder to write into
};
std::vector<Target> body_targets();        // finite-element files
std::vector<Target> table_targets();       // tables and reduced bodies
std::vector<Target> model_targets();       // robots, data sets of Adams, FMUs
std::vector<Target> checkpoint_targets();  // checkpoints, by file and by content
std::vector<Target> run_targets();         // run files and the pages made of them
std::vector<Target> plugin_targets();      // tables of plug-ins
std::vector<Target> all_targets();

/// An input written to a file of that name; its path.
std::string file_of(std::string_view input, const std::filesystem::path& folder, const std::string& name);

/// A sound checkpoint, the first input of its target.
void write_checkpoint_seed(const std::string& path);

}  // namespace lithe::fuzz
