#pragma once

#include <vector>

#include "engine/base/math.h"

/// Where the nodes of a cable lie as drawn.
namespace lithe::cable_drawing {

/// Along a curve of straight pieces, at shares of its length that rise from 0 to 1.
Matrix3X along(const std::vector<Vector3>& points, const VectorX& shares);
double length(const std::vector<Vector3>& points);

/// On an arc of a circle that hangs towards `sag`, the elements as long as they are: a polygon whose ends are `from`
/// and `to`, shorter apart than the elements together. Throws SceneError where there is none: too few elements.
Matrix3X hanging(const Vector3& from, const Vector3& to, const Vector3& sag, const VectorX& elements);

}  // namespace lithe::cable_drawing
