#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>

#include "tools/lithe/installation.h"

namespace lithe::command {

/// A scene that does not compile; what() is the explanation, ready to print.
class CompileFailure : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// GCC's messages in the scene's own terms: only lines of the user's files, and where the mistake is in a call of Lithe
/// (a field that does not exist, no markers, an unknown type) what is wrong, where, and how to fix it.
/// `shown`: the scene's path as the user wrote it.
std::string explain(const std::string& compiler_output, const std::filesystem::path& scene, const std::string& shown,
                    const Installation& installation);

}  // namespace lithe::command
