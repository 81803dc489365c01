#pragma once

#include <string>
#include <vector>

namespace lithe {

/// What an FMU may be exported for: it steps itself, or its equations are integrated by whoever imports it.
enum class FmuKind { co_simulation, model_exchange };

/// A variable of a unit, as its modelDescription.xml has it.
struct ImportedVariable {
  std::string name;
  unsigned reference = 0;
  std::string type;         // Float64, Float32, Int8 … UInt64, Boolean, String, Binary, Clock: FMI 3.0's names
  std::string causality;    // parameter, calculatedParameter, input, output, local, independent
  std::string variability;  // constant, fixed, tunable, discrete, continuous
  std::string unit, description;
  int size = 1;  // of an array, row by row
  bool array = false;
  std::vector<double> starts;  // one for each entry, or one for all; empty: none given

  bool is_number() const { return type != "String" && type != "Binary" && type != "Clock"; }
  /// Of one entry; 0 where none is given.
  double start(int entry) const {
    return starts.empty() ? 0 : starts[starts.size() == 1 ? 0 : static_cast<std::size_t>(entry)];
  }
};

/// One number of a variable: the whole of a scalar, an entry of an array.
struct FmuNumber {
  const ImportedVariable* variable;
  int entry = 0;
};

/// What a unit says of itself, for the kind that it is imported for.
struct FmuContents {
  int version = 0;  // 2 or 3
  std::string model_name, token, identifier, tool;
  bool variable_step = false, needs_tool = false, serializes = false;
  double default_step = 0;  // s; 0: none is given
  std::vector<ImportedVariable> variables;
  // Of model exchange:
  std::vector<unsigned> states, derivatives;  // value references, in the same order
  int state_count = 0, indicator_count = 0;   // numbers, entries of arrays counted
  bool completes_steps = true;                // it is to be told of each step
  bool differentiates = false;                // it gives directional derivatives
};

/// Reads a modelDescription.xml of FMI 2.0 or 3.0. Throws FileError, with the line, for one that is not well-formed, of
/// another version, not of this kind, or without what an importer needs.
FmuContents read_fmu_contents(const std::string& path, FmuKind kind);

}  // namespace lithe
