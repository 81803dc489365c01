#include "tests/scripting/fmu_importer.h"

#include <dlfcn.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdarg>
#include <cstdlib>
#include <fstream>
#include <regex>
#include <sstream>
#include <stdexcept>

namespace lithe::test {
namespace {

namespace fs = std::filesystem;

void log3(void* environment, int, const char*, const char* message) {
  static_cast<FmuLog*>(environment)->text += std::string(message) + "\n";
}
void log2(void* environment, const char*, int, const char*, const char* format, ...) {
  char text[4096];
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  static_cast<FmuLog*>(environment)->text += std::string(text) + "\n";
}

}  // namespace

UnpackedFmu::UnpackedFmu(const ScriptFolder& scratch, const std::string& scene, int version, const std::string& options,
                         const std::string& step) {
  const Outcome made = scratch.shell("lithe fmu " + std::string(LITHE_SOURCE_DIR) + "/" + scene + " --step " + step +
                                     " --fmi " + std::to_string(version) + " " + options + " -o model.fmu && " +
                                     "python3 -m zipfile -e model.fmu unpacked");
  EXPECT_EQ(made.exit_code, 0) << made.output;
  folder = scratch.path() / "unpacked";
  std::ifstream file(folder / "modelDescription.xml");
  description = {std::istreambuf_iterator<char>(file), {}};
  library = folder / (version == 3 ? "binaries/x86_64-linux" : "binaries/linux64") /
            (fs::path(scene).stem().string() + ".so");
}

std::string UnpackedFmu::attribute(const std::string& name) const {
  std::smatch found;
  return std::regex_search(description, found, std::regex(" " + name + "=\"([^\"]*)\"")) ? found[1].str() : "";
}

std::string UnpackedFmu::token() const {
  const std::string three = attribute("instantiationToken");
  return three.empty() ? attribute("guid") : three;
}

unsigned UnpackedFmu::reference(const std::string& variable) const {
  const std::string before = "name=\"" + variable + "\" valueReference=\"";
  const std::size_t at = description.find(before);
  EXPECT_NE(at, std::string::npos) << variable;
  return at == std::string::npos ? 9999u : static_cast<unsigned>(std::stoul(description.substr(at + before.size(), 9)));
}

unsigned UnpackedFmu::first_output() const {
  std::smatch found;
  EXPECT_TRUE(std::regex_search(description, found, std::regex("valueReference=\"(\\d+)\"[^>]* causality=\"output\"")));
  return static_cast<unsigned>(std::stoul(found[1]));
}

void expect_passes_importers(const ScriptFolder& scratch) {
  const Outcome checked = scratch.shell(
      "python3 -c 'import fmpy' 2>/dev/null || { echo no FMPy: pip install fmpy; exit 0; }; python3 -c '"
      "import fmpy; from fmpy.validation import validate_fmu; p = validate_fmu(\"model.fmu\"); print(p); "
      "r = fmpy.simulate_fmu(\"model.fmu\", stop_time=0.03, output_interval=0.001); print(r[-1]); exit(len(p))'");
  EXPECT_EQ(checked.exit_code, 0) << checked.output;
  const Outcome run = scratch.shell(
      "command -v OMSimulator >/dev/null || { echo no OMSimulator: pip install OMSimulator; exit 0; }; "
      "OMSimulator --stopTime=0.03 model.fmu");
  EXPECT_EQ(run.exit_code, 0) << run.output;
  std::printf("%s%s", checked.output.c_str(), run.output.c_str());
}

void expect_valid_description(const ScriptFolder& scratch, int version) {
  const std::string schema =
      std::string(LITHE_TEST_DATA) + "/fmi/schema-" + (version == 3 ? "3.0.2/fmi3" : "2.0.5/fmi2");
  const Outcome valid =
      scratch.shell("command -v xmllint >/dev/null || { echo no xmllint; exit 0; }; xmllint --noout --schema " +
                    schema + "ModelDescription.xsd unpacked/modelDescription.xml" +
                    (version == 3 ? " && { [ ! -e unpacked/terminalsAndIcons ] || xmllint --noout --schema " + schema +
                                        "TerminalsAndIcons.xsd unpacked/terminalsAndIcons/terminalsAndIcons.xml; }"
                                  : ""));
  EXPECT_EQ(valid.exit_code, 0) << valid.output;
  std::printf("%s", valid.output.c_str());
}

std::vector<std::vector<double>> rows_of(const std::string& output) {
  std::vector<std::vector<double>> all;
  std::istringstream lines(output);
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with("row ")) continue;
    std::istringstream words(line.substr(4));
    std::vector<double>& row = all.emplace_back();
    for (std::string word; words >> word;) row.push_back(std::strtod(word.c_str(), nullptr));
  }
  return all;
}
std::string exact_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%a", value);
  return text;
}

std::vector<std::vector<double>> native_rows(const ScriptFolder& scratch, const std::string& scene,
                                             const std::string& before, const std::string& body,
                                             const std::string& step) {
  // Named here too: the command then uses the precompiled header.
  scratch.write("native.cpp", "#include \"lithe/lithe.h\"\n#include \"" LITHE_SOURCE_DIR "/" + scene +
                                  "\"\n#include <cstdio>\n" + before + R"(
int main() {
  const StudyScene study = scene();
  SystemGraph graph({.gravity = study.gravity});
  const std::vector<Sensor> sensors = study.draw(graph);
  const System system = assemble(graph);
  GeneralizedAlpha method{{.step = )" +
                                  step + R"(}};
  Simulation simulation{system, method};
  State state = system.initial_state();
  Snapshot now(system);
  const auto print = [&](const State& at, Accelerations accelerations) {
    now.evaluate(at, accelerations);
    std::printf("row");
    for (const Sensor& sensor : sensors)
      for (std::size_t c = 0; c < sensor.columns().size(); ++c)
        std::printf(" %a", sensor.value(now, static_cast<int>(c)));
    std::printf("\n");
  };
)" + body + "}\n");
  const Outcome ran = scratch.shell("lithe run native.cpp");
  EXPECT_EQ(ran.exit_code, 0) << ran.output;
  return rows_of(ran.output);
}

FmuLibrary::FmuLibrary(const fs::path& path) : handle_(dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL)) {
  EXPECT_NE(handle_, nullptr) << dlerror();
}
bool FmuLibrary::has(const std::string& name) const { return dlsym(handle_, name.c_str()) != nullptr; }
void* FmuLibrary::find(const std::string& name) const {
  void* function = dlsym(handle_, name.c_str());
  if (!function) throw std::runtime_error(name + " is missing");
  return function;
}

ImportedInstance::ImportedInstance(const FmuLibrary& library, const std::string& token, int version, bool logging,
                                   Form form, const std::string& resources)
    : library_(library), three_(version == 3), callbacks_{log2, std::calloc, std::free, nullptr, &log} {
  using Callback = void (*)();
  const char* folder = resources.empty() ? nullptr : resources.c_str();
  const std::string address = resources.empty() ? "" : "file://" + resources;
  if (!three_)
    component_ = library_.call<void*>("fmi2Instantiate", "one", static_cast<int>(form), token.c_str(), address.c_str(),
                                      (const void*)&callbacks_, 0, static_cast<int>(logging));
  else if (form == Form::co_simulation)
    component_ =
        library_.call<void*>("fmi3InstantiateCoSimulation", "one", token.c_str(), folder, false, logging, false, false,
                             (const unsigned*)nullptr, std::size_t{0}, (void*)&log, &log3, (Callback) nullptr);
  else
    component_ = library_.call<void*>("fmi3InstantiateModelExchange", "one", token.c_str(), folder, false, logging,
                                      (void*)&log, &log3);
}
ImportedInstance::ImportedInstance(const FmuLibrary& library, const std::string& token, IntermediateUpdate update)
    : update_of(std::move(update)), library_(library), three_(true), callbacks_{} {
  // The environment is the instance here, for both callbacks.
  const auto told = +[](void* environment, int, const char*, const char* message) {
    static_cast<ImportedInstance*>(environment)->log.text += std::string(message) + "\n";
  };
  const auto updated = +[](void* environment, double time, bool, bool, bool, bool may_end, bool* ends, double* end) {
    *ends = static_cast<ImportedInstance*>(environment)->update_of(time, may_end);
    *end = time;
  };
  component_ =
      library_.call<void*>("fmi3InstantiateCoSimulation", "one", token.c_str(), (const char*)nullptr, false, false,
                           true, true, (const unsigned*)nullptr, std::size_t{0}, (void*)this, told, updated);
}
ImportedInstance::~ImportedInstance() { library_.call<void>(full("FreeInstance"), component_); }

int ImportedInstance::start(double time) {
  if (three_) {
    const int entered = library_.call<int>("fmi3EnterInitializationMode", component_, false, 0.0, time, false, 0.0);
    return entered | call("ExitInitializationMode");
  }
  return library_.call<int>("fmi2SetupExperiment", component_, 0, 0.0, time, 0, 0.0) | call("EnterInitializationMode") |
         call("ExitInitializationMode");
}
int ImportedInstance::set(unsigned reference, double value) {
  constexpr std::size_t kOne = 1;
  return three_ ? library_.call<int>("fmi3SetFloat64", component_, &reference, kOne, &value, kOne)
                : library_.call<int>("fmi2SetReal", component_, &reference, kOne, &value);
}
int ImportedInstance::get(const std::vector<unsigned>& references, std::vector<double>& values) {
  values.assign(references.size(), NAN);
  const std::size_t n = references.size();
  return three_ ? library_.call<int>("fmi3GetFloat64", component_, references.data(), n, values.data(), n)
                : library_.call<int>("fmi2GetReal", component_, references.data(), n, values.data());
}
int ImportedInstance::step(double time, double size) {
  bool flags[3];
  double last = 0;
  return three_ ? library_.call<int>("fmi3DoStep", component_, time, size, true, flags, flags + 1, flags + 2, &last)
                : library_.call<int>("fmi2DoStep", component_, time, size, 1);
}

int ImportedInstance::step(double time, double size, bool& early, double& last) {
  bool event = true, terminate = true;
  return library_.call<int>("fmi3DoStep", component_, time, size, true, &event, &terminate, &early, &last) |
         int{event || terminate};
}

int ImportedInstance::save(void** state) {
  return library_.call<int>(three_ ? "fmi3GetFMUState" : "fmi2GetFMUstate", component_, state);
}
int ImportedInstance::restore(void* state) {
  return library_.call<int>(three_ ? "fmi3SetFMUState" : "fmi2SetFMUstate", component_, state);
}
int ImportedInstance::forget(void** state) {
  return library_.call<int>(three_ ? "fmi3FreeFMUState" : "fmi2FreeFMUstate", component_, state);
}
std::vector<unsigned char> ImportedInstance::serialized(void* state) {
  std::size_t size = 0;
  library_.call<int>(three_ ? "fmi3SerializedFMUStateSize" : "fmi2SerializedFMUstateSize", component_, state, &size);
  std::vector<unsigned char> bytes(size);
  EXPECT_EQ(library_.call<int>(three_ ? "fmi3SerializeFMUState" : "fmi2SerializeFMUstate", component_, state,
                               bytes.data(), size),
            0);
  return bytes;
}
int ImportedInstance::deserialize(const std::vector<unsigned char>& bytes, void** state) {
  return library_.call<int>(three_ ? "fmi3DeserializeFMUState" : "fmi2DeSerializeFMUstate", component_, bytes.data(),
                            bytes.size(), state);
}

int ImportedInstance::complete_step(bool& event) {
  if (three_) {
    bool terminate = false;
    return library_.call<int>("fmi3CompletedIntegratorStep", component_, true, &event, &terminate) | int{terminate};
  }
  int asks = 0, terminate = 0;
  const int status = library_.call<int>("fmi2CompletedIntegratorStep", component_, 1, &asks, &terminate);
  event = asks != 0;
  return status | terminate;
}
int ImportedInstance::update(bool& states_changed) {
  double next = 0;
  if (three_) {
    bool again = false, terminate = false, nominals = false, defined = false;
    return library_.call<int>("fmi3UpdateDiscreteStates", component_, &again, &terminate, &nominals, &states_changed,
                              &defined, &next) |
           int{again || terminate || nominals || defined};
  }
  struct {
    int again, terminate, nominals, states, defined;
    double next;
  } event{1, 1, 1, 1, 1, 0};
  const int status = library_.call<int>("fmi2NewDiscreteStates", component_, (void*)&event);
  states_changed = event.states != 0;
  return status | event.again | event.terminate | event.nominals | event.defined;
}
int ImportedInstance::directional_derivative(const std::vector<unsigned>& unknowns, const std::vector<unsigned>& knowns,
                                             const std::vector<double>& seed, std::vector<double>& sensitivity) {
  sensitivity.assign(unknowns.size(), NAN);
  const std::size_t u = unknowns.size(), k = knowns.size();
  return three_ ? library_.call<int>("fmi3GetDirectionalDerivative", component_, unknowns.data(), u, knowns.data(), k,
                                     seed.data(), k, sensitivity.data(), u)
                : library_.call<int>("fmi2GetDirectionalDerivative", component_, unknowns.data(), u, knowns.data(), k,
                                     seed.data(), sensitivity.data());
}

}  // namespace lithe::test
