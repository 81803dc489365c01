#pragma once

#include <string>

#include "engine/base/math.h"
#include "engine/model/marker.h"

/// Checks and measures of the markers of joints as drawn.
namespace lithe::initial {

/// An angle, or a count of quarter turns, as drawn: half a turn counts as +1/2, since round-off may give -1/2 as
/// well. A connector's initialize() and the start of the engine's count must agree on the sign.
double angle(double measured);
double quarter_turns(double counted);

// ---- checks: each throws SceneError; assemble() puts the joint's name first ----

/// Axis `axis` of both markers points the same way, clearly: within 84 degrees. (Rows of three axes also vanish with
/// the axes exchanged in a circle, all 90 degrees off.)
void same_direction(const Vector3& a, const Vector3& b, const std::string& axis);
/// All three axes of both markers point the same way.
void same_axes(const MarkerView& A, const MarkerView& B);
/// Axis `axis_a` of the first marker and `axis_b` of the second are at least a degree from one line.
void not_parallel(const Vector3& a, const Vector3& b, const std::string& axis_a, const std::string& axis_b);
/// The markers are in two places.
void apart(const MarkerView& A, const MarkerView& B);

}  // namespace lithe::initial
