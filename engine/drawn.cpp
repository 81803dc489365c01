#include "engine/drawn.h"

#include "engine/error.h"

namespace lithe::drawn {

void same_direction(const Vector3& a, const Vector3& b, const std::string& axis) {
  if (a.dot(b) > 0) return;
  throw SceneError("the " + axis + " axes of its markers differ by " + std::to_string(std::acos(std::clamp(a.dot(b), -1.0, 1.0)) * 180 / M_PI) +
                       " degrees as drawn",
                   "", "orient one marker so that both " + axis + " axes point the same way: marker(position, orientation)");
}

}  // namespace lithe::drawn
