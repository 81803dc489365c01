#include "tests/architecture/include_rules.h"

#include <algorithm>
#include <fstream>
#include <map>
#include <optional>
#include <regex>
#include <set>

namespace lithe::test {
namespace {

namespace fs = std::filesystem;

// Who may include whom, by first folder. Plugins are not here: beside their own folder they may include two files only.
const std::map<std::string, std::set<std::string>> kArrows = {
    {"engine", {"engine"}},
    {"bodies", {"engine", "bodies"}},
    {"joints", {"engine", "joints"}},
    {"integrators", {"engine", "integrators"}},
    {"models", {"engine", "bodies", "joints", "models"}},
    {"examples",
     {"lithe", "engine", "bodies", "joints", "integrators", "models"}},  // lithe/lithe.h: the generated umbrella
};
const std::set<std::string> kPluginIncludes = {"engine/plugin.h", "engine/plugin_abi.h"};
// engine/ has rooms in the order of the pipeline: each knows itself and those before it. Two headers stand at the door,
// where plug-ins find them.
const std::vector<std::string> kRooms = {"base",   "factor",  "cones",    "model",    "forward", "archive", "output",
                                         "motion", "contact", "assembly", "simplify", "observe", "run",     "analysis",
                                         "page",   "study",   "gradient", "fmu",      "plugin"};
const std::set<std::string> kLibraries = {"engine", "bodies", "joints", "integrators", "models"};

/// A third-party package: its headers, the files that may include them, and whether only one of those files may.
struct Package {
  std::string name;
  std::regex headers;
  std::regex home;
  std::string home_in_words;
  bool one_file = false;
};

const std::vector<Package>& packages() {
  const std::string ida = R"(integrators/(.*/)?ida\w*\.cpp)";
  const std::string cvode = R"(integrators/(.*/)?adams\w*\.cpp)";
  const std::string shared = R"((integrators/sundials|engine/base/sundials_context)_internal\.h)";
  const std::string statics = R"(engine/analysis/static_equations\.cpp)";
  static const std::vector<Package> all = {
      {"Boost.Math", std::regex(R"(boost/math/.*)"), std::regex(R"(engine/(run/event_finder|gradient/fit)\.cpp)"),
       "engine/run/event_finder.cpp, engine/gradient/fit.cpp"},
      {"Boost", std::regex(R"(boost/(?!math/).*)"), std::regex(R"(engine/factor/graph_topology\w*\.cpp)"),
       "engine/factor/graph_topology*.cpp", true},
      {"spdlog, fmt", std::regex(R"((spdlog|fmt)/.*)"), std::regex(R"(engine/base/log\.cpp)"), "engine/base/log.cpp"},
      {"IDA", std::regex(R"(idas?/.*|klu\.h|Eigen/KLUSupport)"), std::regex(ida), "integrators/ida*.cpp"},
      {"CVODE", std::regex(R"(cvodes?/.*)"), std::regex(cvode), "integrators/adams*.cpp"},
      {"SUNDIALS", std::regex(R"((kinsol|sundials|nvector|sunmatrix|sunlinsol|sunnonlinsol|arkode)/.*)"),
       std::regex(ida + "|" + cvode + "|" + shared + "|" + statics),
       "integrators/ida*.cpp, adams*.cpp, sundials_internal.h, engine/analysis/static_equations.cpp, "
       "engine/base/sundials_context_internal.h"},
      {"Bullet", std::regex(R"(bt[A-Z]\w*\.h|(BulletCollision|BulletDynamics|BulletSoftBody|LinearMath|bullet)/.*)"),
       std::regex(R"(bodies/shapes\.cpp|joints/contact/.*)"), "bodies/shapes.cpp, joints/contact/"},
      {"Spectra", std::regex(R"(Spectra/.*)"), std::regex(R"(bodies/flexible/.*\.cpp)"), "bodies/flexible/*.cpp"},
      {"CHOLMOD", std::regex(R"((suitesparse/)?(cholmod|SuiteSparse)\w*\.h|Eigen/CholmodSupport)"),
       std::regex(R"(bodies/flexible/.*\.cpp)"), "bodies/flexible/*.cpp"},
      {"Ceres", std::regex(R"(ceres/.*)"), std::regex(R"(engine/gradient/fit\.cpp)"), "engine/gradient/fit.cpp"},
      {"NLopt", std::regex(R"(nlopt\.h(pp)?)"), std::regex(R"(engine/gradient/minimize\.cpp)"),
       "engine/gradient/minimize.cpp"},
      {"MPI", std::regex(R"(mpi\.h)"), std::regex(R"(engine/study/sweep_mpi\.cpp)"), "engine/study/sweep_mpi.cpp"},
      {"HDF5", std::regex(R"(hdf5\.h)"), std::regex(R"(engine/output/hdf5_(\w+\.cpp|internal\.h))"),
       "engine/output/hdf5_*.cpp, hdf5_internal.h"},
      {"gnuplot", std::regex(R"(spawn\.h)"), std::regex(R"(engine/output/chart\.cpp)"), "engine/output/chart.cpp"},
      {"sockets", std::regex(R"((netinet|arpa)/\w+\.h|netdb\.h|sys/socket\.h)"),
       std::regex(R"(engine/page/loopback_server\.cpp)"), "engine/page/loopback_server.cpp"},
      {"zlib", std::regex(R"(z(lib|conf)\.h)"), std::regex(R"(engine/page/packed_text\.cpp)"),
       "engine/page/packed_text.cpp"},
      {"pugixml", std::regex(R"(pugixml\.hpp)"), std::regex(R"(models/xml_file_internal\.h)"),
       "models/xml_file_internal.h"},
      {"nlohmann_json", std::regex(R"(nlohmann/.*)"), std::regex(R"(.*\.cpp)"), "any .cpp"},
  };
  return all;
}

// Eigen is the shared vocabulary; its adapters to other packages are not, see packages().
const std::regex kEigen(R"((unsupported/)?Eigen/.*)");
// The standard library's headers bear neither folder nor suffix; C's own are listed.
const std::regex kStandard(
    R"([a-z_0-9]+|(assert|errno|float|inttypes|limits|math|stddef|stdint|stdio|stdlib|string)\.h)");
// What the operating system or the compiler brings. Not for public headers.
const std::regex kSystem(R"(sys/\w+\.h|(cxxabi|dlfcn|fcntl|unistd|signal|poll|pthread|link|fenv|\w*intrin)\.h)");

const std::regex kInclude(R"re(^\s*#\s*include\s*(?:<([^>]+)>|"([^"]+)"|(\S+)).*)re");
// gnuplot is a program: what starts one, and its name at the head of a command.
const std::regex kStartsProgram(R"(\b(popen|posix_spawnp?|execl[pe]?|execv[pe]?|execvpe|std::system)\s*\()");
const std::regex kGnuplotCommand(R"("\s*(/usr/bin/)?gnuplot\b)");
const std::regex kChart(R"(engine/output/chart\.cpp)");

struct Source {
  std::string path;    // from the root
  std::string folder;  // its first component

  bool is_header() const { return path.ends_with(".h") || path.ends_with(".hpp"); }
  // A private header is included by .cpp files of its own library alone.
  bool is_private() const { return path.ends_with("_internal.h"); }
  bool is_public_header() const { return is_header() && kLibraries.contains(folder) && !is_private(); }
};

std::vector<Source> find_sources(const fs::path& root) {
  static const std::set<std::string> suffixes = {".h", ".hpp", ".c", ".cc", ".cpp", ".inl", ".ipp"};
  std::vector<Source> sources;
  for (const std::string folder : {"engine", "bodies", "joints", "integrators", "plugins", "examples"}) {
    if (!fs::exists(root / folder)) continue;
    for (const auto& entry : fs::recursive_directory_iterator(root / folder))
      if (entry.is_regular_file() && suffixes.contains(entry.path().extension().string()))
        sources.push_back({fs::relative(entry.path(), root).generic_string(), folder});
  }
  std::sort(sources.begin(), sources.end(), [](const Source& a, const Source& b) { return a.path < b.path; });
  return sources;
}

/// The code of a line: without comments, which may span lines. Good enough for includes and short commands: it takes
/// "//" within a string for a comment.
std::string without_comments(const std::string& line, bool& in_comment) {
  std::string code;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (in_comment) {
      if (line.compare(i, 2, "*/") == 0) in_comment = false, ++i;
    } else if (line.compare(i, 2, "/*") == 0) {
      in_comment = true, ++i;
    } else if (line.compare(i, 2, "//") == 0) {
      break;
    } else {
      code += line[i];
    }
  }
  return code;
}

/// Place in the pipeline of "engine/model/body.h": that of "model"; -1: it is in no room.
int room_of(const std::string& path) {
  if (kPluginIncludes.contains(path)) return static_cast<int>(kRooms.size()) - 1;
  const std::size_t first = sizeof "engine/" - 1, slash = path.find('/', first);
  if (slash == std::string::npos) return -1;
  const auto at = std::find(kRooms.begin(), kRooms.end(), path.substr(first, slash - first));
  return at == kRooms.end() ? -1 : static_cast<int>(at - kRooms.begin());
}

/// Includes written from the root, "engine/model/body.h": the arrows between folders, and between the rooms of engine/.
std::optional<std::string> broken_arrow(const Source& source, const std::string& included) {
  const std::size_t slash = included.find('/');
  if (slash == std::string::npos || included.starts_with('.'))
    return "includes are written from the root, as in \"engine/model/body.h\"";
  const std::string target = included.substr(0, slash);

  // What examples need to report lies beside them; nobody else includes it.
  if (source.folder == "examples" && included.starts_with("examples/support/")) return std::nullopt;
  if (source.folder == "plugins") {  // a plug-in may have several files of its own
    const std::string own = source.path.substr(0, source.path.find('/', sizeof "plugins") + 1);
    if (kPluginIncludes.contains(included) || included.starts_with(own)) return std::nullopt;
  }
  if (target == "plugins" || target == "examples") return "nothing includes " + target + "/";
  if (source.folder == "plugins")
    return "a plugin includes engine/plugin.h, engine/plugin_abi.h, its own folder, Eigen and the standard library "
           "only";
  if (!kArrows.at(source.folder).contains(target)) return source.folder + "/ must not include " + target + "/";
  if (source.is_public_header() && included.ends_with("_internal.h")) return "a public header includes no private one";
  if (source.folder == "engine" && room_of(source.path) < room_of(included))
    return "engine/" + kRooms[room_of(source.path)] + "/ comes before engine/" + kRooms[room_of(included)] +
           "/ and must not include it";
  return std::nullopt;
}

/// Includes of packages, <boost/graph/adjacency_list.hpp>: homes, and what users of a header get to see.
std::optional<std::string> wrong_home(const Source& source, const std::string& included) {
  if (std::regex_match(included, kStandard)) return std::nullopt;
  if (source.folder == "plugins" && !std::regex_match(included, kEigen))
    return "a plugin includes engine/plugin.h, engine/plugin_abi.h, its own folder, Eigen and the standard library "
           "only";
  if (std::regex_match(included, kSystem)) {
    if (!source.is_public_header()) return std::nullopt;
    return "public headers include Eigen and the standard library only";
  }

  for (const Package& package : packages()) {
    if (!std::regex_match(included, package.headers)) continue;
    if (source.is_public_header()) return package.name + " in a public header: only Eigen and the standard library may";
    if (!std::regex_match(source.path, package.home)) return package.name + " lives in " + package.home_in_words;
    return std::nullopt;
  }
  if (std::regex_match(included, kEigen)) return std::nullopt;
  return "<" + included + "> has no home yet: give it one in tests/architecture/include_rules.cpp";
}

}  // namespace

std::string to_string(const Violation& violation) {
  return violation.file + ":" + std::to_string(violation.line) + ": " + violation.text + "\n    " + violation.reason;
}

std::vector<std::string> rooms() { return kRooms; }

int count_sources(const fs::path& root) { return static_cast<int>(find_sources(root).size()); }

std::vector<Violation> find_violations(const fs::path& root) {
  std::vector<Violation> violations;
  std::map<std::string, std::string> first_home;  // package -> the file that has it

  for (const Source& source : find_sources(root)) {
    std::ifstream stream(root / source.path);
    bool in_comment = false, has_pragma_once = false;
    int number = 0;
    for (std::string line; std::getline(stream, line);) {
      ++number;
      const std::string code = without_comments(line, in_comment);
      const auto report = [&](const std::string& reason) { violations.push_back({source.path, number, line, reason}); };
      if (code.starts_with("#pragma once")) has_pragma_once = true;

      // Before expressions, which take seconds on all lines.
      const auto names = [&](const char* word) { return code.find(word) != std::string::npos; };
      // gnuplot is a program, not a header: one file may start it.
      if ((names("popen") || names("spawn") || names("exec") || names("system") || names("gnuplot")) &&
          !std::regex_match(source.path, kChart)) {
        if (std::regex_search(code, kStartsProgram)) report("only engine/output/chart.cpp starts another program");
        if (std::regex_search(code, kGnuplotCommand)) report("gnuplot lives in engine/output/chart.cpp");
      }

      std::smatch match;
      if (!names("include") || !std::regex_match(code, match, kInclude)) continue;
      const std::string package_header = match[1], own_header = match[2];
      if (match[3].matched) {
        report("an include names its file, not a macro");
      } else if (own_header.empty()) {
        if (const auto reason = wrong_home(source, package_header)) report(*reason);
        for (const Package& package : packages()) {
          if (!package.one_file || !std::regex_match(package_header, package.headers)) continue;
          const auto home = first_home.try_emplace(package.name, source.path).first->second;
          if (home != source.path) report(package.name + " has one home, which is " + home);
        }
      } else if (const auto reason = broken_arrow(source, own_header)) {
        report(*reason);
      }
    }
    if (source.folder == "engine" && room_of(source.path) < 0)
      violations.push_back({source.path, 1, "", "engine/ has rooms: put the file into the one whose idea it serves"});
    if (source.is_header() && !has_pragma_once)
      violations.push_back({source.path, 1, "", "a header begins with #pragma once"});
  }
  return violations;
}

}  // namespace lithe::test
