#pragma once

#include <string>

#include "engine/marker.h"
#include "engine/math.h"

/// Checks that joints make of their markers as drawn; each throws SceneError. assemble() puts the joint's name first.
namespace lithe::drawn {

/// Axis `axis` of both markers points the same way, clearly: within 84 degrees. (Rows of three axes also vanish with
/// the axes exchanged in a circle, all 90 degrees off.)
void same_direction(const Vector3& a, const Vector3& b, const std::string& axis);
/// All three axes of both markers point the same way.
void same_axes(const MarkerView& A, const MarkerView& B);
/// Axis `axis_a` of the first marker and `axis_b` of the second are at least a degree from one line.
void not_parallel(const Vector3& a, const Vector3& b, const std::string& axis_a, const std::string& axis_b);
/// The markers are in two places.
void apart(const MarkerView& A, const MarkerView& B);

}  // namespace lithe::drawn
