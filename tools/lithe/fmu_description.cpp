#include "tools/lithe/fmu_description.h"

#include <array>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <pugixml.hpp>
#include <sstream>

#include "engine/base/number_text.h"

namespace lithe::command {
namespace {

using nlohmann::json;

/// Exponents of a unit in FMI's base units.
constexpr std::array<const char*, 8> kBase = {"kg", "m", "s", "A", "K", "mol", "cd", "rad"};
using Exponents = std::array<int, 8>;

const std::map<std::string, Exponents>& known_units() {
  static const std::map<std::string, Exponents> all = {
      {"kg", {1}},
      {"m", {0, 1}},
      {"s", {0, 0, 1}},
      {"K", {0, 0, 0, 0, 1}},
      {"1", {}},
      {"N", {1, 1, -2}},
      {"J", {1, 2, -2}},
      {"W", {1, 2, -3}},
      {"Pa", {1, -1, -2}},
      {"Hz", {0, 0, -1}},
      {"rad", {0, 0, 0, 0, 0, 0, 0, 1}},
  };
  return all;
}

/// "N.m/rad", "m/s2"; none: not understood.
std::optional<Exponents> exponents_of(const std::string& unit) {
  Exponents sum{};
  int sign = 1;
  std::size_t at = 0;
  while (at < unit.size()) {
    const std::size_t end = std::min(unit.find_first_of("./", at), unit.size());
    std::string factor = unit.substr(at, end - at);
    int power = 1;
    if (factor.size() > 1 && std::isdigit(static_cast<unsigned char>(factor.back())))
      power = factor.back() - '0', factor.pop_back();
    const auto known = known_units().find(factor);
    if (known == known_units().end()) return std::nullopt;
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += sign * power * known->second[i];
    if (end < unit.size() && unit[end] == '/') sign = -1;
    at = end + 1;
  }
  return sum;
}

std::string text_of(const pugi::xml_document& document) {
  std::ostringstream text;
  document.save(text, "  ", pugi::format_default, pugi::encoding_utf8);
  return text.str();
}

void add_units(pugi::xml_node root, const json& variables) {
  std::map<std::string, bool> units;
  for (const json& v : variables)
    if (const std::string unit = fmi_unit(v.at("unit")); !unit.empty()) units[unit] = true;
  if (units.empty()) return;
  pugi::xml_node definitions = root.append_child("UnitDefinitions");
  for (const auto& [name, used] : units) {
    pugi::xml_node unit = definitions.append_child("Unit");
    unit.append_attribute("name") = name.c_str();
    const auto exponents = exponents_of(name);
    if (!exponents) continue;
    pugi::xml_node base = unit.append_child("BaseUnit");
    for (std::size_t i = 0; i < kBase.size(); ++i)
      if ((*exponents)[i] != 0) base.append_attribute(kBase[i]) = (*exponents)[i];
  }
}

/// What both versions say of a variable, on its element for 3.0 and the type's element for 2.0.
void add_type_attributes(pugi::xml_node node, const json& v) {
  if (const std::string unit = fmi_unit(v.at("unit")); !unit.empty()) node.append_attribute("unit") = unit.c_str();
  if (!v.at("lower").is_null()) node.append_attribute("min") = number_text(v.at("lower").get<double>()).c_str();
  if (!v.at("upper").is_null()) node.append_attribute("max") = number_text(v.at("upper").get<double>()).c_str();
}

enum Role { kTime, kInput, kParameter, kOutput, kState, kDerivative, kIndicator };

/// What an importer may do with instances of one form.
pugi::xml_node add_form(pugi::xml_node root, const char* name, const std::string& identifier, bool three) {
  pugi::xml_node form = root.append_child(name);
  form.append_attribute("modelIdentifier") = identifier.c_str();
  form.append_attribute(three ? "canGetAndSetFMUState" : "canGetAndSetFMUstate") = "true";
  form.append_attribute(three ? "canSerializeFMUState" : "canSerializeFMUstate") = "true";
  if (!three) form.append_attribute("canNotUseMemoryManagementFunctions") = "true";
  return form;
}

/// Places in the list of variables.
class Places {
 public:
  explicit Places(const json& variables) {
    for (std::size_t i = 0; i < variables.size(); ++i) of_[variables[i].at("role").get<int>()].push_back(i);
  }
  const std::vector<std::size_t>& of(Role role) const { return of_[role]; }

 private:
  std::array<std::vector<std::size_t>, kIndicator + 1> of_;
};

/// The structure of a model: what depends on what is left open, which means on all.
void add_structure(pugi::xml_node root, const Places& places, bool three) {
  pugi::xml_node structure = root.append_child("ModelStructure");
  const auto add = [&](const char* group, const char* element, std::initializer_list<Role> roles) {
    pugi::xml_node parent = three ? structure : structure.append_child(group);
    for (const Role role : roles)
      for (const std::size_t i : places.of(role)) {
        pugi::xml_node node = parent.append_child(three ? element : "Unknown");
        node.append_attribute(three ? "valueReference" : "index") = static_cast<unsigned>(three ? i : i + 1);
      }
  };
  add("Outputs", "Output", {kOutput});
  if (!places.of(kState).empty()) add("Derivatives", "ContinuousStateDerivative", {kDerivative});
  add("InitialUnknowns", "InitialUnknown", {kOutput, kState, kDerivative});
  if (three) add("", "EventIndicator", {kIndicator});
}

}  // namespace

std::string fmi_unit(const std::string& unit) {
  std::string text;
  for (std::size_t i = 0; i < unit.size(); ++i) {
    const auto byte = static_cast<unsigned char>(unit[i]);
    if (byte == 0xC2 && i + 1 < unit.size()) {  // ², ³, ·
      const auto next = static_cast<unsigned char>(unit[++i]);
      text += next == 0xB2 ? "2" : next == 0xB3 ? "3" : next == 0xB7 ? "." : std::string{unit[i - 1], unit[i]};
    } else {
      text += unit[i] == ' ' ? '.' : unit[i];
    }
  }
  return text;
}

std::string fmu_description(const std::string& facts_text, const std::string& identifier, int version) {
  const json facts = json::parse(facts_text);
  const json& variables = facts.at("variables");
  const bool three = version == 3;
  pugi::xml_document document;
  pugi::xml_node declaration = document.append_child(pugi::node_declaration);
  declaration.append_attribute("version") = "1.0";
  declaration.append_attribute("encoding") = "UTF-8";
  pugi::xml_node root = document.append_child("fmiModelDescription");
  root.append_attribute("fmiVersion") = three ? "3.0" : "2.0";
  root.append_attribute("modelName") = facts.at("name").get<std::string>().c_str();
  root.append_attribute(three ? "instantiationToken" : "guid") = facts.at("token").get<std::string>().c_str();
  root.append_attribute("generationTool") = ("Lithe " + facts.at("lithe").get<std::string>()).c_str();
  root.append_attribute("variableNamingConvention") = "flat";

  const Places places(variables);
  if (!three && !places.of(kIndicator).empty())
    root.append_attribute("numberOfEventIndicators") = static_cast<unsigned>(places.of(kIndicator).size());
  if (facts.at("no model exchange") == "") {
    pugi::xml_node exchange = add_form(root, "ModelExchange", identifier, three);
    exchange.append_attribute(three ? "providesDirectionalDerivatives" : "providesDirectionalDerivative") = "true";
    if (three) exchange.append_attribute("providesAdjointDerivatives") = "true";
    if (three) exchange.append_attribute("needsCompletedIntegratorStep") = "true";  // 2.0: as long as nothing is said
  }
  pugi::xml_node steps = add_form(root, "CoSimulation", identifier, three);
  steps.append_attribute("canHandleVariableCommunicationStepSize") = "true";
  if (three)
    for (const char* offered : {"providesIntermediateUpdate", "canReturnEarlyAfterIntermediateUpdate", "hasEventMode"})
      steps.append_attribute(offered) = "true";

  add_units(root, variables);
  pugi::xml_node categories = root.append_child("LogCategories");
  for (const auto& [name, meaning] : {std::pair("logStatusError", "errors: what, where, how to fix it"),
                                      {"logStatusDiscard", "a state for which the equations have no solution"},
                                      {"logStatusWarning", "warnings of the engine"},
                                      {"logEvents", "milestones of the engine"}}) {
    pugi::xml_node category = categories.append_child("Category");
    category.append_attribute("name") = name;
    category.append_attribute("description") = meaning;
  }
  pugi::xml_node experiment = root.append_child("DefaultExperiment");
  experiment.append_attribute("startTime") = "0";
  experiment.append_attribute("stopTime") = number_text(facts.at("duration").get<double>()).c_str();

  pugi::xml_node list = root.append_child("ModelVariables");
  for (std::size_t i = 0; i < variables.size(); ++i) {
    const json& v = variables[i];
    const int role = v.at("role");
    pugi::xml_node node = list.append_child(three ? "Float64" : "ScalarVariable");
    node.append_attribute("name") = v.at("name").get<std::string>().c_str();
    node.append_attribute("valueReference") = static_cast<unsigned>(i);
    if (const std::string description = v.at("description"); !description.empty())
      node.append_attribute("description") = description.c_str();
    constexpr const char* kCausality[] = {"independent", "input", "parameter", "output", "local", "local", "local"};
    node.append_attribute("causality") = kCausality[role];
    node.append_attribute("variability") = role == kParameter ? "tunable" : "continuous";
    if (role == kParameter) node.append_attribute("initial") = "exact";
    if (role >= kOutput) node.append_attribute("initial") = "calculated";
    if (three && (role == kOutput || role == kState || role == kDerivative || v.at("within steps")))
      node.append_attribute("intermediateUpdate") = "true";
    pugi::xml_node type = three ? node : node.append_child("Real");
    add_type_attributes(type, v);
    if (role == kInput || role == kParameter)
      type.append_attribute("start") = number_text(v.at("start").get<double>()).c_str();
    if (role == kState) {
      type.append_attribute("nominal") = number_text(v.at("nominal").get<double>()).c_str();
      type.append_attribute("reinit") = "true";
    }
    if (role == kDerivative) {
      const std::size_t state = places.of(kState)[v.at("place").get<std::size_t>()];
      type.append_attribute("derivative") = static_cast<unsigned>(three ? state : state + 1);
    }
  }

  add_structure(root, places, three);
  return text_of(document);
}

std::string fmu_terminals(const std::string& facts_text) {
  pugi::xml_document document;
  pugi::xml_node root = document.append_child("fmiTerminalsAndIcons");
  root.append_attribute("fmiVersion") = "3.0";
  pugi::xml_node terminal, list;
  const json facts = json::parse(facts_text);
  for (const json& v : facts.at("variables")) {
    const std::string sensor = v.at("sensor"), name = v.at("name");
    if (sensor.empty()) continue;
    if (!list) list = root.append_child("Terminals");
    if (sensor != terminal.attribute("name").value()) {
      terminal = list.append_child("Terminal");
      terminal.append_attribute("name") = sensor.c_str();
      terminal.append_attribute("matchingRule") = "plug";
    }
    pugi::xml_node member = terminal.append_child("TerminalMemberVariable");
    member.append_attribute("variableName") = name.c_str();
    member.append_attribute("memberName") =
        (name.starts_with(sensor + "_") ? name.substr(sensor.size() + 1) : name).c_str();
    member.append_attribute("variableKind") = "signal";
  }
  return list ? text_of(document) : "";
}

}  // namespace lithe::command
