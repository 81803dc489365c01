#include <dlfcn.h>
#include <unistd.h>
#include <zip.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "engine/base/error.h"
#include "engine/base/number_text.h"
#include "engine/base/resource.h"
#include "engine/base/temporary_folder.h"
#include "tools/lithe/commands.h"
#include "tools/lithe/compiler_messages.h"
#include "tools/lithe/fmu_description.h"
#include "tools/lithe/process.h"
#include "tools/lithe/scene_cache.h"
#include "tools/lithe/scene_program.h"

namespace lithe::command {
namespace fs = std::filesystem;
namespace {

constexpr const char* kFacts = "facts of the FMU: ";

struct FmuOptions {
  std::string scene, out, facts_of;
  std::vector<std::string> resources;
  int version = 3;
  double tolerance = 1e-6, step = 0;
  bool verbose = false, with_libraries = false;
};

/// What is compiled around a scene.
std::string source_around(const fs::path& scene, const FmuOptions& options, const std::string& token) {
  const std::string integrator =
      options.step > 0
          ? "lithe::GeneralizedAlpha>(lithe::GeneralizedAlpha::Parameters{.step = " + number_text(options.step)
          : "lithe::Automatic>(lithe::Automatic::Parameters{.tolerance = {" + number_text(options.tolerance) + ", " +
                number_text(0.01 * options.tolerance) + "}";
  return text_around(scene, R"(#include "engine/fmu/fmu_instance.h"
static lithe::FmuModel lithe_fmu_model() {
  return {scene(), [] { return std::make_unique<)" +
                                integrator + R"(}); }, ")" + token + R"("};
}
#include "engine/fmu/fmi2_border.h"
#include "engine/fmu/fmi3_border.h"
LITHE_FMU_EXPORT const char* lithe_fmu_facts() {
  static std::string facts;
  try {
    facts = lithe::fmu_facts(lithe_fmu_model());
  } catch (const std::exception& error) {
    facts = std::string("!") + error.what();
  }
  return facts.c_str();
}
)");
}

std::string identifier_of(const fs::path& path) {
  std::string name = path.stem().string();
  for (char& c : name)
    if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
  return name.empty() || std::isdigit(static_cast<unsigned char>(name[0])) ? "fmu_" + name : name;
}

/// All of Lithe, beneath any FMU.
fs::path library_of_fmus(const Installation& installation) {
  return installation.library.parent_path() / "liblithe_fmu.so";
}

/// The shared libraries that it needs, but those of glibc, which every Linux has and which must be the importer's.
std::vector<fs::path> libraries_beneath(const fs::path& library) {
  static const std::set<std::string> kGlibc = {"libc.so.6",  "libm.so.6",      "libdl.so.2",          "libpthread.so.0",
                                               "librt.so.1", "libresolv.so.2", "ld-linux-x86-64.so.2"};
  const Finished listed = run_captured({find_program("ldd"), library.string()});
  if (listed.exit_code != 0)
    throw FileError("ldd cannot tell what it needs: " + listed.output, library.filename().string(),
                    "see that ldd (package libc-bin) is there");
  std::vector<fs::path> needed;
  std::istringstream lines(listed.output);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string name, arrow, path;
    if (!(words >> name >> arrow >> path) || arrow != "=>" || kGlibc.contains(name)) continue;
    if (!path.starts_with("/"))
      throw FileError("needs " + name + ", which is not found", library.filename().string(), "install it");
    needed.push_back(fs::path(path).parent_path() / name);
  }
  return needed;
}

/// Compiles the scene to a library beside which Lithe's own lies, and what this needs. Named here, these are found
/// there by libraries with search paths of their own too.
void compile(const Installation& installation, const SceneFile& scene, const FmuOptions& options,
             const std::string& key, const std::string& source, const fs::path& library,
             const std::vector<fs::path>& beneath) {
  const fs::path main = library.parent_path() / "main.cpp";
  std::ofstream(main) << source;
  // Hidden by the linker, not by -fvisibility: Clang refuses a precompiled header made without that flag.
  const fs::path exported = library.parent_path() / "exported.map";
  std::ofstream(exported) << "{ global: fmi*; lithe_fmu_facts; local: *; };\n";
  const fs::path lithe = library_of_fmus(installation);
  std::vector<std::string> command = compile_command(installation);
  append_include_folders(command, installation);
  append_precompiled(command, key);
  command.insert(command.end(),
                 {"-shared", main.string(), "-o", library.string(), lithe.string(),
                  "-Wl,--version-script=" + exported.string(), "-Wl,-Bsymbolic", "-Wl,-z,defs", "-Wl,-rpath,$ORIGIN",
                  "-Wl,--disable-new-dtags"});  // an old tag holds for the libraries of libraries too
  if (!beneath.empty()) command.push_back("-Wl,--no-as-needed");
  for (const fs::path& needed : beneath) command.push_back(needed.string());
  command.insert(command.end(), installation.link_flags.begin(), installation.link_flags.end());
  const Finished compiled = run_captured(command);
  if (options.verbose) std::fprintf(stderr, "%s", compiled.output.c_str());
  if (compiled.exit_code != 0)
    throw CompileFailure(options.verbose ? "" : explain(compiled.output, scene.path, scene.shown, installation));
  fs::copy_file(lithe, library.parent_path() / lithe.filename());
}

/// What the library says of itself, asked in a process of its own: loading a scene runs its code.
std::string facts_of(const Installation& installation, const fs::path& library) {
  const Finished asked = run_captured({installation.command.string(), "fmu", "--facts-of", library.string()});
  const std::size_t at = asked.output.find(kFacts);
  if (asked.exit_code != 0 || at == std::string::npos)
    throw SceneError("the scene cannot be drawn as an FMU: " + asked.output, library.filename().string(),
                     "see what it says; `lithe chart` draws the same function scene()");
  const std::size_t first = at + std::string(kFacts).size();
  return asked.output.substr(first, asked.output.find('\n', first) - first);
}

int print_facts(const std::string& library) {
  void* handle = dlopen(library.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!handle) throw FileError(std::string("cannot be loaded: ") + dlerror(), library, "build Lithe again");
  const auto facts = reinterpret_cast<const char* (*)()>(dlsym(handle, "lithe_fmu_facts"));
  const std::string text = facts ? facts() : "!it is no FMU of Lithe";
  if (text[0] == '!') {
    std::printf("%s\n", text.c_str() + 1);
    return 1;
  }
  std::printf("%s%s\n", kFacts, text.c_str());
  std::fflush(stdout);
  _exit(0);  // no destructors of a library that is not ours to unload
}

/// A zip whose entries appear together under its name, or not at all.
void write_zip(const fs::path& path, const std::vector<std::pair<std::string, fs::path>>& files,
               const std::string& description) {
  if (path.has_parent_path()) fs::create_directories(path.parent_path());
  const fs::path unfinished = path.string() + ".unfinished";
  int code = 0;
  zip_t* zip = zip_open(unfinished.c_str(), ZIP_CREATE | ZIP_TRUNCATE, &code);
  const auto fail = [&](const std::string& why) {
    if (zip) zip_discard(zip);
    throw FileError("the FMU cannot be written: " + why, path.string(), "give a path that can be written, by -o");
  };
  if (!zip) fail("zip_open gives " + std::to_string(code));
  const auto add = [&](const std::string& name, zip_source_t* source) {
    const zip_int64_t place = source ? zip_file_add(zip, name.c_str(), source, ZIP_FL_ENC_UTF_8) : -1;
    if (place < 0) fail(zip_strerror(zip));
    // FMI knows methods 0 and 8 alone. Level 6 takes twice the time for 6 % less of liblithe_fmu.so.
    if (zip_set_file_compression(zip, static_cast<zip_uint64_t>(place), ZIP_CM_DEFLATE, 3) != 0)
      fail(zip_strerror(zip));
  };
  add("modelDescription.xml", zip_source_buffer(zip, description.data(), description.size(), 0));
  for (const auto& [name, file] : files) add(name, zip_source_file(zip, file.c_str(), 0, -1));
  if (zip_close(zip) != 0) fail(zip_strerror(zip));
  fs::rename(unfinished, path);
}

/// Files to pack, by their names in the FMU.
std::vector<std::pair<std::string, fs::path>> packed_resources(const std::vector<std::string>& paths) {
  std::vector<std::pair<std::string, fs::path>> files;
  for (const std::string& path : paths) {
    const fs::path file = resource(path);
    if (!fs::is_regular_file(file))
      throw FileError("the resource is not a file", path, "give one, by its path from the folder that this runs in");
    files.emplace_back("resources/" + file.generic_string(), file);
  }
  return files;
}

int make_fmu(const FmuOptions& options) {
  if (!options.facts_of.empty()) return print_facts(options.facts_of);
  if (options.scene.empty())
    throw FileError("no scene is given", "lithe fmu", "give a .cpp file with  lithe::StudyScene scene()  in it");
  const Installation installation = Installation::find();
  const SceneFile scene = SceneFile::find(options.scene);
  const fs::path out = options.out.empty() ? fs::path(scene.path.stem().string() + ".fmu") : fs::path(options.out);
  const std::string identifier = identifier_of(scene.path);
  const std::string key = headers_key(installation);
  Digest token;
  token.add(key);
  token.add_file(scene.path);
  token.add(number_text(options.tolerance) + " " + number_text(options.step));
  const std::vector<std::pair<std::string, fs::path>> resources = packed_resources(options.resources);
  for (const auto& [name, file] : resources) token.add(name), token.add_file(file);

  const TemporaryFolder scratch("lithe_fmu");
  const fs::path library = scratch.path() / (identifier + ".so");
  std::vector<fs::path> beneath;
  if (options.with_libraries) beneath = libraries_beneath(library_of_fmus(installation));
  try {
    compile(installation, scene, options, key, source_around(scene.path, options, "lithe-" + token.text()), library,
            beneath);
  } catch (const CompileFailure& failure) {
    std::fprintf(stderr, "%s", failure.what());
    return 2;
  }
  const std::string facts = facts_of(installation, library);
  const std::string folder = options.version == 3 ? "binaries/x86_64-linux/" : "binaries/linux64/";
  std::vector<std::pair<std::string, fs::path>> files = {
      {folder + identifier + ".so", library}, {folder + "liblithe_fmu.so", scratch.path() / "liblithe_fmu.so"}};
  files.insert(files.end(), resources.begin(), resources.end());
  for (const fs::path& needed : beneath) files.emplace_back(folder + needed.filename().string(), needed);
  if (const std::string terminals = fmu_terminals(facts); options.version == 3 && !terminals.empty()) {
    const fs::path file = scratch.path() / "terminalsAndIcons.xml";
    std::ofstream(file) << terminals;
    files.emplace_back("terminalsAndIcons/terminalsAndIcons.xml", file);
  }
  write_zip(out, files, fmu_description(facts, identifier, options.version));
  std::printf("FMU: %s\n", out.string().c_str());
  if (const std::string why = nlohmann::json::parse(facts).at("no model exchange"); !why.empty())
    std::printf("  for co-simulation alone: %s\n", why.c_str());
  return 0;
}

}  // namespace

void add_fmu(CLI::App& app, int& exit_code) {
  auto* command = app.add_subcommand("fmu", "A scene as a functional mock-up unit (FMI 3.0 or 2.0)");
  const auto options = std::make_shared<FmuOptions>();
  command->add_option(
      "scene", options->scene,
      "A .cpp file with  lithe::StudyScene scene()  in it: its inputs become inputs and parameters, its "
      "sensors outputs");
  command->add_option("-o,--out", options->out, "The FMU; default: SCENE.fmu");
  command->add_option("--fmi", options->version, "Version of the standard")
      ->check(CLI::IsMember({2, 3}))
      ->capture_default_str();
  command->add_option("--tolerance", options->tolerance, "Of the integrator, Automatic")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command->add_option("--step", options->step, "s: a fixed step instead, by GeneralizedAlpha")
      ->check(CLI::PositiveNumber);
  command->add_option("--resource", options->resources,
                      "A file that the scene reads by resource(PATH), from the folder that this runs in: packed");
  command->add_flag("--with-libraries", options->with_libraries,
                    "Pack the shared libraries that it needs too: it then runs where glibc alone is");
  command->add_flag("--verbose", options->verbose, "Show all messages of the compiler");
  command->add_option("--facts-of", options->facts_of)->group("");  // our own call
  command->callback([options, &exit_code] { exit_code = make_fmu(*options); });
}

}  // namespace lithe::command
