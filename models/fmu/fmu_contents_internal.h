#pragma once

#include <optional>
#include <string>
#include <vector>

namespace lithe {

/// A variable of a unit, as its modelDescription.xml has it.
struct ImportedVariable {
  std::string name;
  unsigned reference = 0;
  std::string type;         // Float64, Float32, Int8 … UInt64, Boolean, String, Binary, Clock: FMI 3.0's names
  std::string causality;    // parameter, calculatedParameter, input, output, local, independent
  std::string variability;  // constant, fixed, tunable, discrete, continuous
  std::string unit, description;
  std::optional<double> start;
  bool array = false;
};

/// What a unit for co-simulation says of itself.
struct FmuContents {
  int version = 0;  // 2 or 3
  std::string model_name, token, identifier, tool;
  bool variable_step = false, needs_tool = false, saves = false, serializes = false;
  double default_step = 0;  // s; 0: none is given
  std::vector<ImportedVariable> variables;
};

/// Reads a modelDescription.xml of FMI 2.0 or 3.0. Throws FileError, with the line, for one that is not well-formed, of
/// another version, without co-simulation, or without what an importer needs.
FmuContents read_fmu_contents(const std::string& path);

}  // namespace lithe
