#pragma once

#include <limits>
#include <string>

namespace lithe {

/// A variable of an FMU as importers see it.
struct FmuVariable {
  enum class Role { time, input, parameter, output, state, derivative, indicator };
  std::string name, unit, description;
  Role role = Role::time;
  double start = 0;  // of inputs and parameters, as their bounds
  double lower = -std::numeric_limits<double>::infinity(), upper = std::numeric_limits<double>::infinity();
  double nominal = 1;         // size of a state
  int place = 0;              // among those of its role
  std::string sensor;         // that it is one column of several of
  bool within_steps = false;  // an input that may be set within a communication step
};

}  // namespace lithe
