#include <charconv>
#include <cmath>
#include <cstring>

#include "engine/archive/archive.h"
#include "engine/base/error.h"
#include "engine/base/number_text.h"
#include "engine/plugin/plugin_type.h"
#include "models/fmu/fmu_file_internal.h"

namespace lithe {
namespace {

FmuContents contents_of(const FmuPackage& package, FmuKind kind) {
  const auto description = package.folder() / "modelDescription.xml";
  if (!std::filesystem::is_regular_file(description))
    throw FileError("the archive has no modelDescription.xml.", package.path(), "give an FMU.");
  try {
    return read_fmu_contents(description.string(), kind);
  } catch (const FileError& error) {  // where it lies unpacked is nobody's business
    std::string where = error.where();
    const std::string folder = package.folder().string() + "/";
    if (where.starts_with(folder)) where = package.path() + ", " + where.substr(folder.size());
    throw FileError(error.problem(), where, error.fix());
  }
}

/// The i in name[i]; 0: the text has no such end.
int entry_of(const std::string& name, std::string& array) {
  const std::size_t open = name.rfind('[');
  if (open == std::string::npos || name.back() != ']') return 0;
  int entry = 0;
  const char* const end = name.data() + name.size() - 1;
  const auto [stop, error] = std::from_chars(name.data() + open + 1, end, entry);
  if (error != std::errc() || stop != end || entry < 1) return 0;
  array = name.substr(0, open);
  return entry;
}

const char* in_words(FmuFile::Role role) {
  switch (role) {
    case FmuFile::Role::input:
      return "input";
    case FmuFile::Role::output:
      return "output";
    case FmuFile::Role::parameter:
      return "parameter";
    default:
      return "variable";
  }
}

bool fits(const ImportedVariable& v, FmuFile::Role role) {
  switch (role) {
    case FmuFile::Role::input:
      return v.causality == "input";
    case FmuFile::Role::output:
      return v.causality == "output" || v.causality == "local";
    case FmuFile::Role::parameter:
      return v.causality == "parameter" || v.causality == "input";
    default:
      return true;
  }
}

}  // namespace

FmuFile::FmuFile(const std::string& path, FmuKind kind, std::string name)
    : package_(path),
      kind_(kind),
      contents_(contents_of(package_, kind)),
      name_(name.empty() ? contents_.model_name : std::move(name)) {
  if (contents_.needs_tool)
    refuse("the FMU needs the tool that made it to run", "export it with its own solver and without that need");
}

std::unique_ptr<FmuLibrary> FmuFile::make_instance() const {
  return make_fmu_library(contents_, kind_, package_.folder().string(), package_.path(), name_);
}

void FmuFile::refuse(const std::string& problem, const std::string& fix) const {
  throw SceneError(problem, "FMU '" + name_ + "'", fix);
}

FmuNumber FmuFile::find(const std::string& name, Role role) const {
  std::string array;
  const int entry = entry_of(name, array);
  const ImportedVariable* found = nullptr;
  std::vector<std::string> known;
  for (const ImportedVariable& v : contents_.variables) {
    if (v.name == name) {  // this name itself may end with an index
      found = &v;
      break;
    }
    if (entry > 0 && v.array && v.name == array) found = &v;
    if (fits(v, role)) known.push_back(v.name);
  }
  if (!found) refuse("it has no " + std::string(in_words(role)) + " '" + name + "'", name_hint(name, known));
  if (!fits(*found, role))
    refuse("'" + name + "' is no " + in_words(role) + ", its causality is " + found->causality,
           "connect one of that kind");
  if (!found->is_number())
    refuse("'" + name + "' is of type " + found->type + "; single numbers can be used", "use another variable");
  if (found->array && found->name == name)
    refuse("'" + name + "' is an array of " + std::to_string(found->size) + "; single numbers can be used",
           "name one of them, from '" + name + "[1]' on, row by row");
  if (found->array && entry > found->size)
    refuse("'" + found->name + "' has " + std::to_string(found->size) + " numbers, no '" + name + "'",
           "count from 1, row by row");
  return {found, found->array ? entry - 1 : 0};
}

FmuNumber FmuFile::find_parameter(const std::string& name, double value) const {
  const FmuNumber found = find(name, Role::parameter);
  if (!std::isfinite(value)) refuse("the value of '" + name + "' is not finite", "give a number");
  return found;
}

double FmuFile::checked(const std::string& variable, double value) const {
  if (!std::isfinite(value))
    throw SimulationError("the FMU gives " + number_text(value) + " for '" + variable + "'.", "FMU '" + name_ + "'",
                          "look at its inputs and parameters.");
  return value;
}

void FmuFile::history(Archive& archive, std::unique_ptr<FmuLibrary>& instance, bool begun) const {
  if (!contents_.serializes)
    refuse("it cannot give its state (canSerializeFMUstate), which checkpoints need",
           "run without checkpoints, or export it with that ability");
  std::vector<int> words;
  std::size_t size = 0;
  if (!archive.loads() && begun) {
    if (!instance) refuse("it failed before, so there is no state to save", "save before the failure");
    const std::vector<unsigned char> bytes = instance->save();
    size = bytes.size();
    words.resize((size + sizeof(int) - 1) / sizeof(int));
    std::memcpy(words.data(), bytes.data(), size);
  }
  archive("size", size);
  archive("state", words);
  if (!archive.loads()) return;
  instance.reset();  // some binaries allow one instance at a time
  instance = make_instance();
  if (!begun) return;
  if (words.size() != (size + sizeof(int) - 1) / sizeof(int))
    throw FileError("the state of the FMU '" + name_ + "' is damaged.", archive.source(), "take another checkpoint.");
  std::vector<unsigned char> bytes(size);
  std::memcpy(bytes.data(), words.data(), size);
  instance->load(bytes);
}

std::string FmuFile::title() const {
  return "FMU '" + name_ + "': " + contents_.model_name + ", FMI " + std::to_string(contents_.version) + ".0" +
         (contents_.tool.empty() ? "" : ", made by " + contents_.tool);
}

std::string FmuFile::values_of(const ImportedVariable& v, const std::vector<std::pair<std::string, double>>& values,
                               bool connected) const {
  std::string out;
  for (const auto& [name, value] : values)
    if (find(name, Role::any).variable == &v) out += entry(name, v) + " = " + number_text(value);
  if (out.empty() && !connected && (v.causality == "parameter" || v.causality == "input") && !v.array &&
      !v.starts.empty())
    out = " = " + number_text(v.starts[0]) + ", its default";
  return out;
}

std::string FmuFile::entry(const std::string& name, const ImportedVariable& v) {
  return v.array ? " " + name.substr(v.name.size()) : "";
}

std::string FmuFile::line(const ImportedVariable& v, const std::string& is) {
  return "  " + v.causality + " " + v.name + (v.unit.empty() ? "" : " [" + v.unit + "]") + is + "\n";
}

}  // namespace lithe
