#pragma once

#include <string>

#include "engine/math.h"

/// Checks that joints make of their markers as drawn; each throws SceneError. assemble() puts the joint's name before it.
namespace lithe::drawn {

/// Axis `axis` of both markers points the same way, within 90 degrees.
void same_direction(const Vector3& a, const Vector3& b, const std::string& axis);

}  // namespace lithe::drawn
