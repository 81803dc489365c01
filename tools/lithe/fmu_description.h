#pragma once

#include <string>

namespace lithe::command {

/// modelDescription.xml of an FMU, from what the compiled scene says of itself (engine/fmu/:
/// fmu_facts()). `version`: 2 or 3, of FMI.
std::string fmu_description(const std::string& facts, const std::string& identifier, int version);

/// terminalsAndIcons.xml of FMI 3.0: a terminal for each sensor of several columns. Empty: there is none.
std::string fmu_terminals(const std::string& facts);

/// A unit as FMI names it, "N m/rad" as "N.m/rad"; empty stays empty.
std::string fmi_unit(const std::string& unit);

}  // namespace lithe::command
