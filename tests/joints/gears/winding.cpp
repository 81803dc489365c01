#include "tests/joints/gears/winding.h"

#include <cmath>
#include <numbers>

namespace lithe::test {

double winding(const DrawnShape& shape, const Vector3& point) {
  double sum = 0;  // solid angles (van Oosterom & Strackee 1983)
  for (const auto& [i, j, k] : shape.triangles) {
    const Vector3 a = shape.points[static_cast<std::size_t>(i)] - point,
                  b = shape.points[static_cast<std::size_t>(j)] - point,
                  c = shape.points[static_cast<std::size_t>(k)] - point;
    const double A = a.norm(), B = b.norm(), C = c.norm();
    sum += 2 * std::atan2(a.dot(b.cross(c)), A * B * C + a.dot(b) * C + b.dot(c) * A + c.dot(a) * B);
  }
  return sum / (4 * std::numbers::pi);
}

}  // namespace lithe::test
