#pragma once

#include <string>
#include <vector>

#include "engine/assembly/system.h"
#include "engine/observe/event.h"

namespace lithe {

/// Where a law of a scene changes its form, such as a stop that is reached or left: where a function of the state
/// passes a level. No method keeps its order across it.
struct Kink {
  std::string name;  // of the element
  EventFunction function;
  double level = 0;
  int a = -1, b = -1;  // of a contact: the colliders whose gap the function is
};

/// The switches of force laws (ForceElement::switches), then where surfaces of compliant contacts meet and part.
std::vector<Kink> find_kinks(const System& system);

}  // namespace lithe
