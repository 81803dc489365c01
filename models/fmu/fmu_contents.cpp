#include <map>
#include <set>
#include <sstream>

#include "models/fmu/fmu_contents_internal.h"
#include "models/xml_file_internal.h"

namespace lithe {
namespace {

constexpr int kMostNumbers = 1 << 20;  // of one variable, and of event indicators

using Units = std::map<std::string, std::string>;  // of declared types

bool is_true(const std::string& text) { return text == "true" || text == "1"; }
bool is_true(const pugi::xml_node& node, const char* attribute, const char* otherwise = "") {
  return is_true(node.attribute(attribute).as_string(otherwise));
}

unsigned reference_of(const XmlFile& file, const pugi::xml_node& node, const char* attribute = "valueReference") {
  const double number = file.number(node, attribute);
  if (number < 0 || number > 4294967295.0 || number != static_cast<double>(static_cast<unsigned>(number)))
    file.fail(node, std::string(attribute) + " is no whole number from 0 to 4294967295.", "export the FMU again.");
  return static_cast<unsigned>(number);
}

/// A number of things: a whole one, not negative and not absurd.
int count_of(const XmlFile& file, const pugi::xml_node& node, const std::string& what, double count) {
  if (!(count >= 0 && count <= kMostNumbers) || count != static_cast<int>(count))
    file.fail(node, what + " is no whole number from 0 to " + std::to_string(kMostNumbers) + ".",
              "export the FMU again, or do not use this file.");
  return static_cast<int>(count);
}

/// The start values of numbers or truth values; empty: not given, or of another kind.
std::vector<double> starts_of(const XmlFile& file, const pugi::xml_node& node, const ImportedVariable& variable) {
  const pugi::xml_attribute start = node.attribute("start");
  if (!start || !variable.is_number()) return {};
  if (variable.type != "Boolean") return file.numbers(node, "start", start.as_string(), 1, kMostNumbers);
  std::vector<double> out;
  std::istringstream words(start.as_string());
  for (std::string word; words >> word;) out.push_back(is_true(word) ? 1 : 0);
  return out;
}

ImportedVariable variable_of(const XmlFile& file, const pugi::xml_node& node, const pugi::xml_node& typed,
                             const std::string& type, const Units& units) {
  ImportedVariable out;
  out.name = file.text(node, "name");
  out.reference = reference_of(file, node);
  out.type = type;
  out.causality = node.attribute("causality").as_string("local");
  out.variability = node.attribute("variability").as_string(type.starts_with("Float") ? "continuous" : "discrete");
  out.description = node.attribute("description").as_string();
  out.unit = typed.attribute("unit").as_string();
  if (const auto declared = units.find(typed.attribute("declaredType").as_string());
      out.unit.empty() && declared != units.end())
    out.unit = declared->second;
  out.starts = starts_of(file, typed, out);
  return out;
}

const std::map<std::string, std::string> kTypes2 = {
    {"Real", "Float64"}, {"Integer", "Int32"}, {"Enumeration", "Int32"}, {"Boolean", "Boolean"}, {"String", "String"}};
const std::set<std::string> kTypes3 = {"Float64", "Float32", "Int8",   "UInt8",   "Int16",  "UInt16", "Int32",
                                       "UInt32",  "Int64",   "UInt64", "Boolean", "String", "Binary", "Clock"};

void read_variables2(const XmlFile& file, FmuContents& out) {
  Units units;
  for (const auto& type : file.root().child("TypeDefinitions").children("SimpleType"))
    units[type.attribute("name").as_string()] = type.child("Real").attribute("unit").as_string();
  std::vector<unsigned> state_index;  // from 1, of the variable that each is the derivative of; 0: of none
  for (const auto& node : file.root().child("ModelVariables").children("ScalarVariable")) {
    pugi::xml_node typed;
    for (const auto& child : node.children())
      if (kTypes2.contains(child.name())) typed = child;
    if (!typed) file.fail(node, "the variable has no type.", "export the FMU again.");
    out.variables.push_back(variable_of(file, node, typed, kTypes2.at(typed.name()), units));
    state_index.push_back(typed.attribute("derivative") ? reference_of(file, typed, "derivative") : 0);
  }
  const auto known = [&](unsigned index) { return index >= 1 && index <= out.variables.size(); };
  for (const auto& node : file.root().child("ModelStructure").child("Derivatives").children("Unknown")) {
    const unsigned index = reference_of(file, node, "index");
    if (!known(index) || !known(state_index[index - 1]))
      file.fail(node, "no variable " + std::to_string(index) + " is the derivative of another.",
                "export the FMU again.");
    out.derivatives.push_back(out.variables[index - 1].reference);
    out.states.push_back(out.variables[state_index[index - 1] - 1].reference);
  }
  out.state_count = static_cast<int>(out.states.size());
  out.indicator_count =
      count_of(file, file.root(), "numberOfEventIndicators", file.number(file.root(), "numberOfEventIndicators", 0));
}

void read_variables3(const XmlFile& file, FmuContents& out) {
  Units units;
  for (const auto& type : file.root().child("TypeDefinitions").children())
    units[type.attribute("name").as_string()] = type.attribute("unit").as_string();
  std::vector<pugi::xml_node> nodes;
  std::map<unsigned, std::size_t> places;  // of references
  for (const auto& node : file.root().child("ModelVariables").children()) {
    std::string type = node.name();
    if (node.type() != pugi::node_element) continue;
    if (type == "Enumeration") type = "Int64";
    if (!kTypes3.contains(type)) file.fail(node, "<" + type + "> is no type of FMI 3.0.", "export the FMU again.");
    out.variables.push_back(variable_of(file, node, node, type, units));
    places.emplace(out.variables.back().reference, nodes.size());
    nodes.push_back(node);
  }
  const auto place = [&](const pugi::xml_node& node, const char* attribute) {
    const unsigned reference = reference_of(file, node, attribute);
    const auto at = places.find(reference);
    if (at == places.end())
      file.fail(node, "no variable has the value reference " + std::to_string(reference) + ".",
                "export the FMU again.");
    return at->second;
  };
  // Arrays: sizes are numbers, or the start values of others.
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    ImportedVariable& variable = out.variables[i];
    double size = 1;
    for (const auto& dimension : nodes[i].children("Dimension")) {
      variable.array = true;
      if (dimension.attribute("start")) {
        size *= file.number(dimension, "start");
      } else {
        const std::vector<double>& starts = out.variables[place(dimension, "valueReference")].starts;
        size *= starts.empty() ? -1 : starts[0];
      }
      variable.size = count_of(file, dimension, "the size of '" + variable.name + "'", size);
    }
    if (variable.starts.size() > 1 && variable.starts.size() != static_cast<std::size_t>(variable.size))
      file.fail(nodes[i],
                "'" + variable.name + "' has " + std::to_string(variable.starts.size()) + " start values for " +
                    std::to_string(variable.size) + " numbers.",
                "export the FMU again.");
  }
  const pugi::xml_node structure = file.root().child("ModelStructure");
  for (const auto& node : structure.children("ContinuousStateDerivative")) {
    const std::size_t derivative = place(node, "valueReference");
    const std::size_t state = place(nodes[derivative], "derivative");
    if (out.variables[state].size != out.variables[derivative].size)
      file.fail(nodes[derivative], "'" + out.variables[derivative].name + "' is not of the size of its state.",
                "export the FMU again.");
    out.derivatives.push_back(out.variables[derivative].reference);
    out.states.push_back(out.variables[state].reference);
    out.state_count = count_of(file, node, "the number of states", out.state_count + out.variables[state].size);
  }
  for (const auto& node : structure.children("EventIndicator"))
    out.indicator_count = count_of(file, node, "the number of event indicators",
                                   out.indicator_count + out.variables[place(node, "valueReference")].size);
}

}  // namespace

FmuContents read_fmu_contents(const std::string& path, FmuKind kind) {
  const XmlFile file(path);
  const pugi::xml_node root = file.root();
  if (std::string(root.name()) != "fmiModelDescription")
    file.fail(root, "<" + std::string(root.name()) + "> is no description of an FMU.", "give an FMU.");
  const std::string version = file.text(root, "fmiVersion");
  FmuContents out;
  out.version = version.starts_with("2.") ? 2 : version.starts_with("3.") ? 3 : 0;
  if (out.version == 0)
    file.fail(root, "the FMU is of FMI " + version + "; 2.0 and 3.0 can be imported.", "export it as one of these.");
  const bool steps = kind == FmuKind::co_simulation;
  const pugi::xml_node unit = root.child(steps ? "CoSimulation" : "ModelExchange");
  if (!unit)
    file.fail(root,
              steps ? "the FMU is not for co-simulation, but for model exchange alone."
                    : "the FMU is not for model exchange, but for co-simulation alone.",
              steps ? "import it by ModelExchangeFmu, or export it for co-simulation."
                    : "import it by ImportedFmu, or export it for model exchange.");
  const bool two = out.version == 2;
  out.model_name = file.text(root, "modelName");
  out.token = file.text(root, two ? "guid" : "instantiationToken");
  out.tool = root.attribute("generationTool").as_string();
  out.identifier = file.text(unit, "modelIdentifier");
  if (out.identifier.find('/') != std::string::npos)
    file.fail(unit, "modelIdentifier '" + out.identifier + "' is no name.", "do not use this file.");
  out.variable_step = is_true(unit, "canHandleVariableCommunicationStepSize");
  out.needs_tool = is_true(unit, "needsExecutionTool");
  out.serializes = is_true(unit, two ? "canSerializeFMUstate" : "canSerializeFMUState");
  out.completes_steps =
      two ? !is_true(unit, "completedIntegratorStepNotNeeded") : is_true(unit, "needsCompletedIntegratorStep", "true");
  out.differentiates = is_true(unit, two ? "providesDirectionalDerivative" : "providesDirectionalDerivatives");
  out.default_step = file.number(root.child("DefaultExperiment"), "stepSize", 0);
  if (const double fixed = file.number(unit, "fixedInternalStepSize", 0); fixed > 0 && !out.variable_step)
    out.default_step = fixed;
  two ? read_variables2(file, out) : read_variables3(file, out);
  return out;
}

}  // namespace lithe
