#pragma once

#include "engine/base/math.h"
#include "engine/model/appearance.h"

namespace lithe::test {

/// How many times a surface winds around a point, both in the axes of its marker: 1 within it, 0 outside.
double winding(const DrawnShape& shape, const Vector3& point);

}  // namespace lithe::test
