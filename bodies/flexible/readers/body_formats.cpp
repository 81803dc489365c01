#include "bodies/flexible/readers/body_formats.h"

#include <algorithm>
#include <cstdio>
#include <fstream>

#include "bodies/flexible/elements/solid_element.h"
#include "bodies/flexible/readers/abaqus.h"
#include "bodies/flexible/readers/ansys.h"
#include "bodies/flexible/readers/calculix.h"
#include "bodies/flexible/readers/calculix_deck.h"
#include "bodies/flexible/readers/calculix_modes.h"
#include "bodies/flexible/readers/gmsh.h"
#include "bodies/flexible/readers/matrix_market.h"
#include "bodies/flexible/readers/nastran.h"
#include "bodies/flexible/readers/sid.h"
#include "bodies/flexible/readers/text_file.h"
#include "engine/base/error.h"

namespace lithe {
namespace {

namespace fs = std::filesystem;

bool is_file(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored);
}

/// "the lower triangle" where the first thousand entries `row column value` say so.
std::string listed_triangle(const fs::path& path) {
  std::ifstream stream(path);
  std::string line;
  bool lower = false, upper = false;
  for (int k = 0; k < 1000 && std::getline(stream, line);) {
    long row = 0, column = 0;
    if (std::sscanf(line.c_str(), "%ld %ld", &row, &column) != 2) continue;
    ++k;
    lower = lower || row > column;
    upper = upper || row < column;
  }
  return lower && upper ? "both triangles" : lower ? "the lower triangle" : upper ? "the upper triangle" : "a diagonal";
}

// ---- CalculiX ----
bool is_calculix(const BodyOpening& file) {
  return is_file(file.beside(".inp")) && (is_file(file.beside(".dof")) || is_file(file.beside(".sti")));
}

FoundBody read_calculix_job(const BodyOpening& file, const ImportOptions&) {
  FoundBody found;
  const fs::path job = file.beside("");
  found.model = read_calculix(job.string());
  for (const char* extension : {".inp", ".sti", ".mas", ".dof"}) found.body.files.push_back(file.beside(extension));
  const int hidden = read_calculix_deck(file.beside(".inp").string()).incompatible_elements;
  auto& notes = found.body.notes;
  notes.push_back("rows in the order of .dof; of K the file has " + listed_triangle(file.beside(".sti")) + ", of M " +
                  listed_triangle(file.beside(".mas")));
  if (hidden > 0)
    notes.push_back(std::to_string(9 * hidden) + " hidden rows of " + std::to_string(hidden) +
                    " C3D8I elements condensed out of K; M is that of the nodes");
  if (is_file(file.beside(".frd"))) {
    found.modes = read_calculix_modes(file.beside(".frd").string(), found.model).shapes;
    found.body.files.push_back(file.beside(".frd"));
  }
  return found;
}

// ---- Matrix Market ----
bool is_matrix_market(const BodyOpening& file) { return file.begins_with("%%matrixmarket"); }

/// "rod_K.mtx" to "rod_M.mtx", "stiffness.mtx" to "mass.mtx": the last such word of the name.
fs::path mass_beside(const fs::path& stiffness) {
  const std::string stem = stiffness.stem().string();
  for (const auto& [from, to] :
       {std::pair("stiffness", "mass"), std::pair("Stiffness", "Mass"), std::pair("K", "M"), std::pair("k", "m")}) {
    const size_t at = stem.rfind(from);
    if (at == std::string::npos) continue;
    const std::string mass = std::string(stem).replace(at, std::string(from).size(), to);
    return stiffness.parent_path() / (mass + stiffness.extension().string());
  }
  throw FileError("the matrix of masses cannot be found: this name has no K in it.", stiffness.string(),
                  "name the files K.mtx, M.mtx, or rod_K.mtx, rod_M.mtx.");
}

/// The other way round, where the matrix of masses was named and the other stands beside it; else the path itself.
fs::path stiffness_beside(const fs::path& named) {
  const std::string stem = named.stem().string();
  for (const auto& [from, to] : {std::pair("mass", "stiffness"), std::pair("Mass", "Stiffness"), std::pair("M", "K")}) {
    const size_t at = stem.rfind(from);
    if (at == std::string::npos) continue;
    const std::string other = std::string(stem).replace(at, std::string(from).size(), to);
    const fs::path path = named.parent_path() / (other + named.extension().string());
    if (is_file(path)) return path;
  }
  return named;
}

FoundBody read_matrix_market_folder(const BodyOpening& file, const ImportOptions&) {
  FoundBody found;
  const fs::path stiffness = stiffness_beside(file.path);
  const fs::path mass = mass_beside(stiffness), folder = stiffness.parent_path();
  const auto optional = [&](const char* name) {
    return is_file(folder / name) ? (folder / name).string() : std::string();
  };
  const std::string sets = optional("node_sets.csv"), elements = optional("elements.csv");
  found.model = read_matrix_market(stiffness.string(), mass.string(), (folder / "nodes.csv").string(), sets, elements);
  found.body.files = {stiffness, mass, folder / "nodes.csv"};
  for (const std::string& extra : {sets, elements})
    if (!extra.empty()) found.body.files.push_back(extra);
  found.body.notes.push_back("rows 3 i + axis in the order of nodes.csv; matrices are " +
                             std::string(file.text.find("symmetric") < file.text.find('\n')
                                             ? "symmetric (one triangle)"
                                             : "general (both triangles)"));
  return found;
}

// ---- SID ----
bool is_sid(const BodyOpening& file) {
  const auto part = std::find(file.words.begin(), file.words.end(), "part");
  return file.words.end() - part > 2 && *(part + 1) == "new" && *(part + 2) == "modal";
}

FoundBody read_sid_file(const BodyOpening& file, const ImportOptions&) {
  FoundBody found;
  SidBody body = read_sid(file.path.string());
  found.basis = body.basis;
  found.body.files = {file.path};
  found.body.notes = std::move(body.notes);
  return found;
}

// ---- gmsh ----
bool is_gmsh(const BodyOpening& file) { return file.begins_with("$meshformat"); }

FoundBody read_gmsh_mesh(const BodyOpening& file, const ImportOptions& options) {
  FoundBody found;
  found.model = read_gmsh(file.path.string(), options.materials);
  assemble_matrices(found.model);
  found.body.files = {file.path};
  found.body.notes.push_back("K and M assembled here from " + std::to_string(found.model.elements.size()) +
                             " block(s) of elements");
  return found;
}

// ---- Abaqus ----
/// "job_STIF1.mtx" or "job_MASS1.mtx" beside any file of the job, the first of its kind; empty if there is none.
fs::path generated(const BodyOpening& file, const std::string& kind) {
  std::string job = file.path.stem().string();
  for (const char* mark : {"_STIF", "_MASS"})
    if (const size_t at = job.rfind(mark); at != std::string::npos) job.resize(at);
  for (int step = 1; step < 100; ++step) {
    const fs::path path = file.path.parent_path() / (job + kind + std::to_string(step) + ".mtx");
    if (is_file(path)) return path;
  }
  return {};
}

bool is_abaqus(const BodyOpening& file) {
  return !generated(file, "_STIF").empty() && !generated(file, "_MASS").empty();
}

FoundBody read_abaqus_job(const BodyOpening& file, const ImportOptions&) {
  FoundBody found;
  const fs::path stiffness = generated(file, "_STIF"), mass = generated(file, "_MASS");
  const std::string name = stiffness.string(), deck = name.substr(0, name.rfind("_STIF")) + ".inp";
  found.model = read_abaqus({.deck = deck, .stiffness = stiffness.string(), .mass = mass.string()});
  found.body.files = {deck, stiffness, mass};
  return found;
}

// ---- ANSYS ----
/// The only file of a folder with this ending; empty if there are none or several.
fs::path only_one(const fs::path& folder, const std::string& ending) {
  fs::path found;
  std::error_code failed;
  for (const auto& entry : fs::directory_iterator(folder.empty() ? fs::path(".") : folder, failed)) {
    if (lower_case(entry.path().extension().string()) != ending) continue;
    if (!found.empty()) return {};
    found = entry.path();
  }
  return found;
}

/// Beside K.hb: K.mapping, or the only .mapping of the folder; beside K.mmf: also mapping.mmf.
fs::path mapping_of(const BodyOpening& file) {
  if (is_file(file.beside(".mapping"))) return file.beside(".mapping");
  const fs::path plain = file.path.parent_path() / ("mapping" + file.path.extension().string());
  if (is_file(plain)) return plain;
  return only_one(file.path.parent_path(), ".mapping");
}

bool is_ansys(const BodyOpening& file) {
  // Harwell-Boeing: the type of matrix begins the third line. Matrix Market of ANSYS: a mapping instead of nodes.csv.
  size_t third = file.text.find('\n');
  if (third != std::string::npos) third = file.text.find('\n', third + 1);
  if (third != std::string::npos)
    if (const std::string type = file.text.substr(third + 1, 3); type == "rsa" || type == "rua") return true;
  return file.begins_with("%%matrixmarket") && !is_file(file.path.parent_path() / "nodes.csv") &&
         !mapping_of(file).empty();
}

FoundBody read_ansys_files(const BodyOpening& file, const ImportOptions&) {
  FoundBody found;
  const fs::path stiffness = stiffness_beside(file.path), mass = mass_beside(stiffness), mapping = mapping_of(file);
  if (mapping.empty())
    throw FileError("the names of the rows cannot be found.", file.path.string(),
                    "keep the .mapping file that HBMAT writes beside the matrices.");
  fs::path nodes;
  for (const char* ending : {".cdb", ".node", ".lis"})
    if (nodes.empty()) nodes = only_one(file.path.parent_path(), ending);
  if (nodes.empty())
    throw FileError("the nodes cannot be found.", file.path.string(),
                    "put one archive of the model beside it: CDWRITE,DB,model,cdb (or NWRITE,model,node).");
  found.model = read_ansys({stiffness.string(), mass.string(), mapping.string(), nodes.string()});
  found.body.files = {stiffness, mass, mapping, nodes};
  return found;
}

// ---- Nastran ----
fs::path first_beside(const BodyOpening& file, std::initializer_list<const char*> endings) {
  for (const char* ending : endings)
    if (is_file(file.beside(ending))) return file.beside(ending);
  return {};
}

/// Of matrices: the bulk data under their name, or the only ones of the folder.
fs::path bulk_data_of(const BodyOpening& file) {
  fs::path deck = first_beside(file, {".bdf", ".dat", ".nas"});
  for (const char* ending : {".bdf", ".dat", ".nas"})
    if (deck.empty()) deck = only_one(file.path.parent_path(), ending);
  return deck;
}

bool is_nastran(const BodyOpening& file) {
  const std::string ending = lower_case(file.path.extension().string());
  if (ending == ".op4" || ending == ".pch") return !bulk_data_of(file).empty();
  return ending != ".inp" && (file.text.find("begin bulk") != std::string::npos ||
                              file.text.find("\ngrid") != std::string::npos || file.begins_with("grid"));
}

FoundBody read_nastran_job(const BodyOpening& file, const ImportOptions&) {
  FoundBody found;
  const std::string ending = lower_case(file.path.extension().string());
  const bool deck_named = ending != ".op4" && ending != ".pch";
  const fs::path deck = deck_named ? file.path : bulk_data_of(file);
  const fs::path matrices = deck_named ? first_beside(file, {".pch", ".op4"}) : file.path;
  NastranFiles files{.deck = deck.string()};
  found.body.files = {deck};
  if (!matrices.empty()) {
    files.matrices = {matrices.string()};
    found.body.files.push_back(matrices);
  }
  if (is_file(file.beside(".rows"))) {
    files.rows = file.beside(".rows").string();
    found.body.files.push_back(files.rows);
  }
  found.model = read_nastran(files);
  return found;
}

}  // namespace

// A new format is one line here, its test for the first look and its reader above. Saved bodies (HDF5) belong first:
// their files begin with "\x89HDF".
const std::vector<BodyFormat>& body_formats() {
  static const std::vector<BodyFormat> formats{
      {"SID", is_sid, read_sid_file},
      {"gmsh mesh", is_gmsh, read_gmsh_mesh},
      {"ANSYS", is_ansys, read_ansys_files},
      {"Matrix Market", is_matrix_market, read_matrix_market_folder},
      {"Abaqus", is_abaqus, read_abaqus_job},
      {"Nastran", is_nastran, read_nastran_job},
      {"CalculiX matrices", is_calculix, read_calculix_job},
  };
  return formats;
}

BodyOpening open_body(const std::string& given) {
  fs::path path = given;
  std::error_code ignored;
  if (fs::is_directory(path, ignored)) {
    if (!is_file(path / "K.mtx"))
      throw FileError("this is a folder without K.mtx.", given, "name a file: the deck, a matrix, a mesh.");
    path /= "K.mtx";
  }
  if (!is_file(path) && is_file(given + ".inp")) path = given + ".inp";
  if (!is_file(path)) throw FileError("there is no such file.", given, "check the path.");
  std::ifstream stream(path, std::ios::binary);
  std::string text(4096, '\0');
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<size_t>(stream.gcount()));
  BodyOpening opening{path, lower_case(text)};
  size_t start = 0;
  constexpr const char* white = " \t\r\n=";
  while ((start = opening.text.find_first_not_of(white, start)) != std::string::npos) {
    const size_t end = std::min(opening.text.find_first_of(white, start), opening.text.size());
    opening.words.push_back(opening.text.substr(start, end - start));
    start = end;
  }
  return opening;
}

}  // namespace lithe
