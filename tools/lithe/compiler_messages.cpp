#include "tools/lithe/compiler_messages.h"

#include <algorithm>
#include <fstream>
#include <regex>
#include <set>
#include <sstream>

#include "tools/lithe/scene_call.h"
#include "tools/lithe/vocabulary.h"

namespace lithe::command {
namespace fs = std::filesystem;
namespace {

constexpr const char* kNoList = "; its list is no ";  // scene_call.cpp reads it
constexpr int kShown = 5;                             // errors; what follows them is mostly their consequence

/// One "file:line:column: error: message" of GCC or Clang, moved to the user's line where a header of Lithe was
/// instantiated from there.
struct Diagnostic {
  std::string file;
  int line = 0, column = 0;
  std::string message;
};

std::vector<std::string> lines_of(const fs::path& file) {
  std::ifstream stream(file);
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

bool is_users(const std::string& file, const Installation& installation) {
  if (file.starts_with("/usr/")) return false;
  for (const auto* folders : {&installation.includes, &installation.system_includes})
    for (const fs::path& folder : *folders)
      for (const char* part : {"lithe/", "engine/", "bodies/", "joints/", "integrators/", "Eigen/", "unsupported/"})
        if (file.starts_with(folder.string() + "/" + part)) return false;
  return true;
}

std::vector<Diagnostic> read_errors(const std::string& output, const Installation& installation) {
  static const std::regex head(R"(^(.+?):(\d+):(\d+): (?:fatal )?error: (.*)$)");
  static const std::regex from(R"(^(.+?):(\d+):(\d+):\s+required from.*$)");  // GCC, before the error
  static const std::regex wanted(
      R"(^(.+?):(\d+):(\d+): note: in instantiation of .* requested here$)");  // Clang, after
  static const std::regex list(
      R"(^.* note: candidate .* cannot convert initializer list argument to '(?:const )?([\w:]+)(?: &)?'.*$)");
  std::vector<Diagnostic> errors;
  Diagnostic origin;  // of the instantiation that is being reported
  std::istringstream stream(output);
  for (std::string line; std::getline(stream, line);) {
    std::smatch match;
    if (std::regex_match(line, match, from)) {
      if (is_users(match[1], installation)) origin = {match[1], std::stoi(match[2]), std::stoi(match[3]), ""};
    } else if (!errors.empty() && std::regex_match(line, match, wanted)) {
      Diagnostic& error = errors.back();
      if (!is_users(error.file, installation) && is_users(match[1], installation))
        error.file = match[1], error.line = std::stoi(match[2]), error.column = std::stoi(match[3]);
    } else if (!errors.empty() && std::regex_match(line, match, list)) {
      std::string& message = errors.back().message;
      if (message.starts_with("no matching function") && message.find(kNoList) == std::string::npos)
        message += kNoList + match[1].str();
    } else if (std::regex_match(line, match, head)) {
      Diagnostic error{match[1], std::stoi(match[2]), std::stoi(match[3]), match[4]};
      if (!is_users(error.file, installation) && origin.line > 0)
        error.file = origin.file, error.line = origin.line, error.column = origin.column;
      errors.push_back(error);
      origin = {};
    }
  }
  // An error in a header is mostly the detail of the one just before it; the first is shown as it stands.
  if (!errors.empty())
    errors.erase(std::remove_if(errors.begin() + 1, errors.end(),
                                [&](const Diagnostic& error) { return !is_users(error.file, installation); }),
                 errors.end());
  return errors;
}

/// What the compiler and the linker say where no line is known.
std::string linker_message(const std::string& output) {
  if (output.find("undefined reference to `main'") != std::string::npos)
    return "error: the scene has no main().\n  fix:  write  int main() { ... }  in it\n";
  if (output.find("undefined reference to `scene()'") != std::string::npos)
    return "error: the scene has nothing to chart.\n  fix:  write  lithe::StudyScene scene() { ... }  in it\n";
  static const std::regex undefined(R"(undefined reference to `([^']+)')");
  std::smatch match;
  if (std::regex_search(output, match, undefined))
    return "error: '" + match[1].str() +
           "' is declared but nowhere defined.\n"
           "  fix:  lithe run compiles one file: define it there, or in a header that the scene includes\n";
  return output;
}

}  // namespace

std::string explain(const std::string& compiler_output, const fs::path& scene, const std::string& shown,
                    const Installation& installation) {
  std::vector<Diagnostic> errors = read_errors(compiler_output, installation);
  if (errors.empty()) return linker_message(compiler_output);

  Vocabulary vocabulary;
  for (const fs::path& folder : installation.includes)
    for (const char* library : {"engine", "bodies", "joints", "integrators"})
      if (fs::is_directory(folder / library))
        for (const auto& entry : fs::recursive_directory_iterator(folder / library))
          if (entry.path().extension() == ".h") vocabulary.read(entry.path());
  vocabulary.read(scene);

  std::string text;
  int count = 0;
  std::set<std::pair<std::string, int>> told;  // one mistake a line: the rest follows from it
  for (const Diagnostic& error : errors) {
    if (!told.insert({error.file, error.line}).second) continue;
    if (++count > kShown) continue;
    const std::vector<std::string> source = lines_of(error.file);
    const Explanation words = explain_call(error.message, source, error.line, error.column, vocabulary);
    const std::string name = error.file == scene.string() ? shown : error.file;
    text += "error: " + words.what + "\n";
    text += "  at:   " + name + ":" + std::to_string(error.line) + ":" + std::to_string(error.column) + "\n";
    if (error.line <= static_cast<int>(source.size())) {
      const std::string& line = source[error.line - 1];
      const auto indent = std::min(line.find_first_not_of(" \t"), line.size());
      text += "        " + line.substr(indent) + "\n";
    }
    if (!words.fix.empty()) text += "  fix:  " + words.fix + "\n";
  }
  if (count > kShown) text += "and " + std::to_string(count - kShown) + " more errors.\n";
  return text + "(lithe run --verbose " + shown + " shows all that the compiler says)\n";
}

}  // namespace lithe::command
