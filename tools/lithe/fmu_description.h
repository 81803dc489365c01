#pragma once

#include <string>

namespace lithe::command {

/// modelDescription.xml of an FMU, from what the compiled scene says of itself (engine/fmu/:
/// fmu_facts()). `version`: 2 or 3, of FMI.
std::string fmu_description(const std::string& facts, const std::string& identifier, int version);

/// A unit as FMI names it, "N m/rad" as "N.m/rad"; empty stays empty.
std::string fmi_unit(const std::string& unit);

}  // namespace lithe::command
