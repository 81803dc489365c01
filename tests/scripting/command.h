#pragma once

#include <filesystem>
#include <string>

namespace lithe::test {

struct Outcome {
  int exit_code;
  std::string output;  // stdout and stderr
};

/// A folder of its own for one test, and the command `lithe` as a user there would call it.
class ScriptFolder {
 public:
  ScriptFolder();  // named after the running test; emptied

  const std::filesystem::path& path() const { return folder_; }
  void write(const std::string& name, const std::string& text) const;
  /// Runs a shell command in the folder; `lithe` is the built command, and the cache is that of the tests.
  Outcome shell(const std::string& command) const;
  /// Programs made of scenes so far: compilations, seen from outside.
  int program_count() const;

  /// Compiled programs go to a cache of the test's own; the precompiled header, made once, is shared by a link.
  std::filesystem::path cache() const { return folder_ / "cache"; }

 private:
  std::filesystem::path folder_;
};

/// A double pendulum of 40 lines. `elbow`: the line of its second joint.
inline constexpr const char* kElbow =
    "graph.add<RevoluteJoint>(\"elbow\", {upper.marker({0.5, 0, 0}, along_y), lower.marker({-0.5, 0, 0}, along_y)});";
inline constexpr int kElbowLine = 20;
std::string pendulum_scene(const std::string& elbow = kElbow);

}  // namespace lithe::test
