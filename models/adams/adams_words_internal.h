#pragma once

#include <map>
#include <string>
#include <vector>

#include "models/adams/adams_function.h"

/// The words of Adams' function language, for reading and writing.
namespace lithe::adams {

struct KnownFunction {
  AdamsFunction::Operation operation;
  int least, most;  // arguments
};
const std::map<std::string, KnownFunction>& function_words();
const std::map<std::string, AdamsMeasure::Kind>& measure_words();
/// The markers of a measure in the order of its arguments.
std::vector<int*> markers_of(AdamsMeasure& measure);

}  // namespace lithe::adams
