#include <map>
#include <set>

#include "models/fmu/fmu_contents_internal.h"
#include "models/xml_file_internal.h"

namespace lithe {
namespace {

using Units = std::map<std::string, std::string>;  // of declared types

bool is_true(const pugi::xml_node& node, const char* attribute) {
  const std::string text = node.attribute(attribute).as_string();
  return text == "true" || text == "1";
}

unsigned reference_of(const XmlFile& file, const pugi::xml_node& node) {
  const double number = file.number(node, "valueReference");
  if (number < 0 || number > 4294967295.0 || number != static_cast<double>(static_cast<unsigned>(number)))
    file.fail(node, "valueReference is no whole number from 0 to 4294967295.", "export the FMU again.");
  return static_cast<unsigned>(number);
}

/// The start value of a number or truth value; none: not given, or of another kind.
std::optional<double> start_of(const XmlFile& file, const pugi::xml_node& node, const std::string& type) {
  const pugi::xml_attribute start = node.attribute("start");
  if (!start || type == "String" || type == "Binary" || type == "Clock") return std::nullopt;
  if (type == "Boolean") return is_true(node, "start") ? 1 : 0;
  return file.numbers(node, "start", start.as_string(), 1, 1 << 20).front();
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
  out.start = start_of(file, typed, type);
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
  for (const auto& node : file.root().child("ModelVariables").children("ScalarVariable")) {
    pugi::xml_node typed;
    for (const auto& child : node.children())
      if (kTypes2.contains(child.name())) typed = child;
    if (!typed) file.fail(node, "the variable has no type.", "export the FMU again.");
    out.variables.push_back(variable_of(file, node, typed, kTypes2.at(typed.name()), units));
  }
}

void read_variables3(const XmlFile& file, FmuContents& out) {
  Units units;
  for (const auto& type : file.root().child("TypeDefinitions").children())
    units[type.attribute("name").as_string()] = type.attribute("unit").as_string();
  for (const auto& node : file.root().child("ModelVariables").children()) {
    std::string type = node.name();
    if (node.type() != pugi::node_element) continue;
    if (type == "Enumeration") type = "Int64";
    if (!kTypes3.contains(type)) file.fail(node, "<" + type + "> is no type of FMI 3.0.", "export the FMU again.");
    out.variables.push_back(variable_of(file, node, node, type, units));
    out.variables.back().array = !node.child("Dimension").empty();
  }
}

}  // namespace

FmuContents read_fmu_contents(const std::string& path) {
  const XmlFile file(path);
  const pugi::xml_node root = file.root();
  if (std::string(root.name()) != "fmiModelDescription")
    file.fail(root, "<" + std::string(root.name()) + "> is no description of an FMU.", "give an FMU.");
  const std::string version = file.text(root, "fmiVersion");
  FmuContents out;
  out.version = version.starts_with("2.") ? 2 : version.starts_with("3.") ? 3 : 0;
  if (out.version == 0)
    file.fail(root, "the FMU is of FMI " + version + "; 2.0 and 3.0 can be imported.", "export it as one of these.");
  const pugi::xml_node unit = root.child("CoSimulation");
  if (!unit)
    file.fail(root, "the FMU is not for co-simulation, but for model exchange alone.", "export it for co-simulation.");
  const bool two = out.version == 2;
  out.model_name = file.text(root, "modelName");
  out.token = file.text(root, two ? "guid" : "instantiationToken");
  out.tool = root.attribute("generationTool").as_string();
  out.identifier = file.text(unit, "modelIdentifier");
  if (out.identifier.find('/') != std::string::npos)
    file.fail(unit, "modelIdentifier '" + out.identifier + "' is no name.", "do not use this file.");
  out.variable_step = is_true(unit, "canHandleVariableCommunicationStepSize");
  out.needs_tool = is_true(unit, "needsExecutionTool");
  out.saves = is_true(unit, two ? "canGetAndSetFMUstate" : "canGetAndSetFMUState");
  out.serializes = is_true(unit, two ? "canSerializeFMUstate" : "canSerializeFMUState");
  out.default_step = file.number(root.child("DefaultExperiment"), "stepSize", 0);
  if (const double fixed = file.number(unit, "fixedInternalStepSize", 0); fixed > 0 && !out.variable_step)
    out.default_step = fixed;
  two ? read_variables2(file, out) : read_variables3(file, out);
  return out;
}

}  // namespace lithe
