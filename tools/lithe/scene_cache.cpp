#include "tools/lithe/scene_cache.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>

#include "engine/base/error.h"
#include "tools/lithe/process.h"

namespace lithe::command {
namespace fs = std::filesystem;
namespace {

constexpr int kKeptPrecompiled = 2;  // a quarter of a gigabyte each

/// Each change of Lithe's headers leaves a precompiled header behind.
void remove_old_precompiled(const fs::path& newest) {
  std::vector<fs::path> folders;
  for (const auto& entry : fs::directory_iterator(newest.parent_path()))
    if (entry.path() != newest) folders.push_back(entry.path());
  std::error_code ignored;  // another process may have removed it first
  std::sort(folders.begin(), folders.end(), [&](const fs::path& a, const fs::path& b) {
    return fs::last_write_time(a, ignored) > fs::last_write_time(b, ignored);
  });
  for (std::size_t i = kKeptPrecompiled - 1; i < folders.size(); ++i) fs::remove_all(folders[i], ignored);
}

bool is_clang(const Installation& installation) { return installation.compiler.find("clang") != std::string::npos; }

}  // namespace

void Digest::add(const std::string& text) {
  value_ = (fnv1a(text, value_) ^ 0x100) * kFnvPrime;  // ends the text: "ab", "c" is not "a", "bc"
}

void Digest::add_file(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  add(stream ? "content " + std::string(std::istreambuf_iterator<char>(stream), {}) : "missing");
}

std::string Digest::text() const {
  char digits[17];
  std::snprintf(digits, sizeof digits, "%016llx", static_cast<unsigned long long>(value_));
  return digits;
}

FolderLock::FolderLock(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  file_ = open((folder / "lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  if (file_ < 0)
    throw FileError("the cache cannot be written: " + std::string(std::strerror(errno)), folder.string(),
                    "make that folder writable, or let the environment variable XDG_CACHE_HOME name one that is");
  while (flock(file_, LOCK_EX) != 0 && errno == EINTR) {
  }
}
FolderLock::~FolderLock() { close(file_); }

fs::path cache_folder() {
  const auto variable = [](const char* name) {
    const char* value = std::getenv(name);
    return fs::path(value ? value : "");
  };
  if (const fs::path chosen = variable("XDG_CACHE_HOME"); chosen.is_absolute()) return chosen / "lithe";
  if (const fs::path home = variable("HOME"); home.is_absolute()) return home / ".cache" / "lithe";
  throw FileError("there is no folder for compiled scenes", "environment variables XDG_CACHE_HOME, HOME",
                  "let XDG_CACHE_HOME name a folder by its full path");
}

std::string headers_key(const Installation& installation) {
  Digest digest;
  const fs::path compiler = fs::canonical(installation.compiler);
  digest.add(compiler.string() + std::to_string(fs::file_size(compiler)) +
             std::to_string(fs::last_write_time(compiler).time_since_epoch().count()));
  std::vector<std::string> command = compile_command(installation);
  append_include_folders(command, installation);
  for (const std::string& part : command) digest.add(part);
  digest.add(installation.library.string());

  std::vector<fs::path> headers;
  for (const fs::path& folder : installation.includes)
    for (const std::string library : {"lithe", "engine", "bodies", "joints", "integrators", "models"}) {
      if (!fs::is_directory(folder / library)) continue;
      for (const auto& entry : fs::recursive_directory_iterator(folder / library))
        if (entry.path().extension() == ".h") headers.push_back(entry.path());
    }
  std::sort(headers.begin(), headers.end());
  for (const fs::path& header : headers) digest.add(header.string()), digest.add_file(header);
  return digest.text();
}

fs::path precompiled_header(const std::string& key) { return cache_folder() / "headers" / key / "scene.h"; }

bool is_precompiled(const std::string& key) { return fs::exists(precompiled_header(key).string() + ".gch"); }

std::vector<std::string> compile_command(const Installation& installation) {
  std::vector<std::string> command = {installation.compiler};
  command.insert(command.end(), installation.flags.begin(), installation.flags.end());
  // Of programs and of the libraries beneath FMUs alike: they share the precompiled header.
  command.insert(command.end(), {"-fdiagnostics-color=never", "-fPIC"});
  // Fields out of order: an error of C++ and of GCC, to Clang a warning.
  if (is_clang(installation)) command.push_back("-Werror=reorder-init-list");
  return command;
}

void append_include_folders(std::vector<std::string>& command, const Installation& installation) {
  for (const fs::path& folder : installation.includes) command.push_back("-I" + folder.string());
  for (const fs::path& folder : installation.system_includes)
    command.insert(command.end(), {"-isystem", folder.string()});
}

void append_precompiled(std::vector<std::string>& command, const std::string& key) {
  if (is_precompiled(key)) command.insert(command.end(), {"-include", precompiled_header(key).string()});
}

void precompile(const Installation& installation, const std::string& key) {
  const fs::path header = precompiled_header(key), folder = header.parent_path();
  const FolderLock lock(folder);
  if (is_precompiled(key)) return;
  const fs::path unfinished = folder / "unfinished";
  std::ofstream(header) << "#include \"lithe/lithe.h\"\n";
  std::vector<std::string> command = compile_command(installation);
  append_include_folders(command, installation);
  command.insert(command.end(), {"-x", "c++-header", header.string(), "-o", unfinished.string()});
  if (is_clang(installation)) command.push_back("-fpch-instantiate-templates");  // once, not in every scene
  const Finished compiler = run_captured(command);
  if (compiler.exit_code != 0)
    throw FileError("lithe/lithe.h does not compile:\n" + compiler.output, installation.compiler,
                    "use the compiler that built Lithe, or build Lithe again with this one");
  fs::rename(unfinished, header.string() + ".gch");
  remove_old_precompiled(folder);
}

}  // namespace lithe::command
