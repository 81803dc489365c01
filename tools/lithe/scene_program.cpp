#include "tools/lithe/scene_program.h"

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <regex>

#include "engine/base/error.h"
#include "tools/lithe/compiler_messages.h"
#include "tools/lithe/process.h"
#include "tools/lithe/scene_cache.h"

namespace lithe::command {
namespace fs = std::filesystem;
namespace {

std::string read_text(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// The user's files named in the compiler's list "scene.o: scene.cpp part.h ...".
std::vector<fs::path> read_dependencies(const fs::path& file, const Installation& installation) {
  std::vector<fs::path> found;
  std::string word;
  const std::string text = read_text(file) + "\n";
  const auto is_own = [&](const std::string& path) {  // those of Lithe and of the cache are in the key
    for (const fs::path& folder : installation.includes)
      for (const char* library : {"lithe", "engine", "bodies", "joints", "integrators"})
        if (path.starts_with((folder / library).string() + "/")) return false;
    return !path.starts_with(cache_folder().string() + "/");
  };
  for (std::size_t i = text.find(": ") + 2; i < text.size(); ++i) {
    if (text[i] == '\\' && i + 1 < text.size() && text[i + 1] != '\n') {
      word += text[++i];  // a blank in a name
    } else if (text[i] == ' ' || text[i] == '\n' || text[i] == '\\') {
      if (!word.empty() && is_own(word)) found.push_back(word);
      word.clear();
    } else {
      word += text[i];
    }
  }
  return found;
}

/// One scene and the folder that keeps what was made of it.
class SceneProgram {
 public:
  SceneProgram(const Installation& installation, const SceneFile& scene, std::string key, const std::string& main_text)
      : installation_(installation), scene_(scene), key_(std::move(key)), main_text_(main_text) {
    Digest digest;
    digest.add(key_);
    digest.add(scene_.path.string());
    if (!main_text_.empty()) digest.add(main_text_);
    folder_ = cache_folder() / "programs" / digest.text();
  }

  /// The program made of the files as they are now, empty if there is none yet.
  fs::path find() const {
    std::ifstream depends(folder_ / "depends");
    if (!depends) return {};
    std::vector<fs::path> files;
    for (std::string line; std::getline(depends, line);) files.push_back(line);
    const fs::path program = program_of(files);
    return fs::exists(program) ? program : fs::path();
  }

  /// Compiles unless another process has just done so. Throws CompileFailure with what the compiler says.
  fs::path make(bool verbose) const {
    const FolderLock lock(folder_);
    if (const fs::path program = find(); !program.empty()) return program;
    const fs::path unfinished = folder_ / "unfinished", listed = folder_ / "unfinished.d";
    if (!main_text_.empty()) std::ofstream(source()) << main_text_;
    const std::vector<std::string> command = compiler(unfinished, listed);
    if (verbose) {
      for (const std::string& part : command) std::fprintf(stderr, "%s ", part.c_str());
      std::fprintf(stderr, "\n");
    }
    const Finished compiled = run_captured(command);
    if (verbose) std::fprintf(stderr, "%s", compiled.output.c_str());
    if (compiled.exit_code != 0)
      throw CompileFailure(verbose ? "" : explain(compiled.output, scene_.path, scene_.shown, installation_));

    const std::vector<fs::path> files = read_dependencies(listed, installation_);
    const fs::path program = program_of(files);
    std::ofstream depends(folder_ / "depends.new");
    for (const fs::path& file : files) depends << file.string() << "\n";
    depends.close();
    fs::rename(unfinished, program);
    fs::rename(folder_ / "depends.new", folder_ / "depends");
    remove_old(program);
    return program;
  }

 private:
  fs::path program_of(const std::vector<fs::path>& files) const {
    Digest digest;
    for (const fs::path& file : files) digest.add(file.string()), digest.add_file(file);
    return folder_ / ("program-" + digest.text());
  }

  fs::path source() const { return main_text_.empty() ? scene_.path : folder_ / "main.cpp"; }

  std::vector<std::string> compiler(const fs::path& program, const fs::path& listed) const {
    std::vector<std::string> command = compile_command(installation_);
    append_include_folders(command, installation_);
    // A precompiled header must come first, wherever the scene includes it.
    static const std::regex includes_lithe(R"((^|\n)\s*#\s*include\s*["<]lithe/lithe\.h[">])");
    if (std::regex_search(read_text(source()), includes_lithe)) append_precompiled(command, key_);
    // The library also tells errors that a scene does not catch: it is linked even where no call needs it.
    const std::string library = installation_.library.string();
    command.insert(command.end(),
                   {"-MMD", "-MF", listed.string(), source().string(), "-o", program.string(), "-Wl,--no-as-needed",
                    library, "-Wl,-rpath," + installation_.library.parent_path().string()});
    command.insert(command.end(), installation_.link_flags.begin(), installation_.link_flags.end());
    return command;
  }

  /// Programs of a day ago that the newest replaces; younger ones may be about to start.
  void remove_old(const fs::path& newest) const {
    const auto yesterday = fs::file_time_type::clock::now() - std::chrono::hours(24);
    for (const auto& entry : fs::directory_iterator(folder_))
      if (entry.path() != newest && entry.path().filename().string().starts_with("program-") &&
          entry.last_write_time() < yesterday)
        fs::remove(entry.path());
  }

  const Installation& installation_;
  const SceneFile& scene_;
  std::string key_, main_text_;
  fs::path folder_;
};

}  // namespace

SceneFile SceneFile::find(const std::string& name) {
  const fs::path path = fs::absolute(name).lexically_normal();
  if (!fs::is_regular_file(path))
    throw FileError("there is no scene file '" + name + "'", fs::current_path().string(),
                    "give the path of a .cpp file; `lithe new DIR` writes one to start from");
  return {name, path};
}

fs::path compiled_scene(const Installation& installation, const SceneFile& scene, bool verbose,
                        const std::string& main_text) {
  const std::string key = headers_key(installation);
  const SceneProgram made(installation, scene, key, main_text);
  if (const fs::path program = made.find(); !program.empty()) return program;
  const fs::path program = made.make(verbose);
  // The next compilation is three times as quick; meanwhile this scene runs. It takes a quarter of a gigabyte.
  const char* wanted = std::getenv("LITHE_PRECOMPILED");
  if (!is_precompiled(key) && std::string(wanted ? wanted : "") != "off")
    start_detached({installation.command.string(), "prepare"});
  return program;
}

std::string text_around(const fs::path& scene, const std::string& rest) {
  return R"(#include "lithe/lithe.h"
lithe::StudyScene scene();
#define main main_of_the_scene
#include ")" +
         scene.string() + R"("
#undef main
)" + rest;
}

void become_scene(const fs::path& program, const std::vector<std::string>& arguments) {
  std::vector<std::string> command = {program.string()};
  command.insert(command.end(), arguments.begin(), arguments.end());
  become(command);
  throw FileError("the compiled scene cannot be started: " + std::string(std::strerror(errno)), program.string(),
                  "is its folder mounted without execution? Let XDG_CACHE_HOME name another");
}

}  // namespace lithe::command
