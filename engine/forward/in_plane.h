#pragma once

#include <utility>
#include <vector>

#include "engine/base/math.h"
#include "engine/model/constraint.h"

/// Which bodies lower pairs hold in planes with a common normal: asked by the planar kernel and by simplification.
namespace lithe {

/// Sine of the angle by which axes may be off.
inline constexpr double kParallelAxes = 1e-9;

bool are_parallel(const Vector3& unit_a, const Vector3& unit_b);
bool are_perpendicular(const Vector3& unit_a, const Vector3& unit_b);

/// Whether the joint keeps a body in a plane normal to n if the other is kept so; R: axes of its first marker, world.
bool holds_in_plane(const JointFreedom& freedom, const Matrix3& R, const Vector3& n);

/// Those in `held`, and all that the pairs connect to them.
std::vector<char> reached_over(const std::vector<std::pair<int, int>>& pairs, std::vector<char> held);

}  // namespace lithe
