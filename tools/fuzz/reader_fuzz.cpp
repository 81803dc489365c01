// One fuzz target a reader, chosen by -DLITHE_READER=...; tools/fuzz.sh builds and runs them. A reader either returns
// or throws lithe::Error; anything else is a crash.
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "bodies/flexible/readers/abaqus.h"
#include "bodies/flexible/readers/ansys.h"
#include "bodies/flexible/readers/calculix.h"
#include "bodies/flexible/readers/calculix_modes.h"
#include "bodies/flexible/readers/gmsh.h"
#include "bodies/flexible/readers/matrix_market.h"
#include "bodies/flexible/readers/nastran.h"
#include "bodies/flexible/readers/sid.h"
#include "engine/error.h"

namespace lithe {

// Messages are of no interest here, and spdlog is not linked.
namespace log {
void info(const std::string&) {}
void warn(const std::string&) {}
}  // namespace log

namespace {

/// A model for mode shapes to belong to.
FiniteElementModel four_nodes() {
  FiniteElementModel model;
  model.node_ids = {1, 2, 3, 4};
  model.nodes = Matrix3X::Zero(3, 4);
  return model;
}

[[maybe_unused]] void sid(const std::string& job) { read_sid(job + ".sid"); }
[[maybe_unused]] void gmsh(const std::string& job) { read_gmsh(job + ".msh", Material{2.1e11, 0.3, 7850}); }
[[maybe_unused]] void frd(const std::string& job) { read_calculix_modes(job + ".frd", four_nodes()); }
[[maybe_unused]] void calculix(const std::string& job) { read_calculix(job); }
[[maybe_unused]] void matrix_market(const std::string& job) {
  read_matrix_market(job + ".K", job + ".M", job + ".nodes", job + ".sets", job + ".elements");
}

[[maybe_unused]] void abaqus(const std::string& job) { read_abaqus({job + ".inp", job + ".K", job + ".M"}); }
[[maybe_unused]] void ansys(const std::string& job) {
  read_ansys({job + ".K", job + ".M", job + ".mapping", job + ".nodes"});
}
[[maybe_unused]] void nastran(const std::string& job) { read_nastran({.deck = job + ".bdf"}); }
[[maybe_unused]] void op4(const std::string& job) { read_nastran({.deck = job + ".bdf", .matrices = {job + ".op4"}}); }

/// The files of a body in one input: what follows a line "=== name" becomes the file job.name.
void write_files(const std::string& job, std::string_view input) {
  while (!input.empty()) {
    const size_t line_end = std::min(input.find('\n'), input.size());
    std::string_view name = input.substr(0, line_end);
    input.remove_prefix(std::min(line_end + 1, input.size()));
    const size_t next = input.find("\n=== ");
    const std::string_view text = input.substr(0, next == std::string_view::npos ? next : next + 1);
    if (name.rfind("=== ", 0) == 0) name.remove_prefix(4);
    // No other names than those below: an input must not reach for files elsewhere.
    for (const char* known : {"sid", "msh", "frd", "inp", "sti", "mas", "dof", "K", "M", "nodes", "sets", "elements",
                              "mapping", "bdf", "op4"})
      if (name == known) std::ofstream(job + "." + known, std::ios::binary) << text;
    input.remove_prefix(text.size());
  }
}

}  // namespace
}  // namespace lithe

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const std::filesystem::path folder = [] {
    std::string name = (std::filesystem::temp_directory_path() / "lithe_fuzz_XXXXXX").string();
    if (!mkdtemp(name.data())) std::abort();
    return std::filesystem::path(name);
  }();
  for (const auto& old : std::filesystem::directory_iterator(folder)) std::filesystem::remove(old.path());
  lithe::write_files((folder / "job").string(), {reinterpret_cast<const char*>(data), size});
  try {
    lithe::LITHE_READER((folder / "job").string());
  } catch (const lithe::Error&) {  // refused, as it should be
  }
  return 0;
}
