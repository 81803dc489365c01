#pragma once

#include <string>

#include "engine/math.h"

/// Checks of parameters; each throws SceneError that says which parameter is wrong and how to mend it. SystemGraph::add
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

}  // namespace lithe::require
