#pragma once

#include <string>

namespace lithe {

/// "RevoluteJoint": the class without its namespaces and parameters, of typeid(...).name().
std::string class_name(const char* mangled);

}  // namespace lithe
