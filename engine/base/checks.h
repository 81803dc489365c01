#pragma once

#include <string>

#include "engine/base/error.h"
#include "engine/base/math.h"

/// Checks of parameters; each throws SceneError that says which parameter is wrong and how to fix it. SystemGraph::add
/// puts the element's name and the line of the scene before it.
namespace lithe::require {

void finite(double value, const std::string& parameter);
void finite(ConstVectorRef value, const std::string& parameter);
void positive(double value, const std::string& parameter);
void not_negative(double value, const std::string& parameter);
/// Orthonormal and right-handed to 1e-9.
void rotation(const Matrix3& value, const std::string& parameter);
/// Symmetric, positive definite, and principal values that obey the triangle inequality of a real body.
void inertia(const Matrix3& value, const std::string& parameter);

/// Runs checks whose errors are to name `where` (a line of the scene, a type).
template <class Checks>
void at(const std::string& where, Checks&& checks) {
  try {
    checks();
  } catch (const SceneError& error) {
    throw SceneError(error.problem(), where, error.fix());
  }
}

}  // namespace lithe::require
