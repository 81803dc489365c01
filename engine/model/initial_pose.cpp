#include "engine/model/initial_pose.h"

#include <algorithm>
#include <cmath>

#include "engine/base/error.h"

namespace lithe::initial {
namespace {

std::string degrees_between(const Vector3& a, const Vector3& b) {
  return std::to_string(std::acos(std::clamp(a.dot(b), -1.0, 1.0)) * 180 / M_PI) + " degrees";
}

constexpr double kHalfTurn = 1e-9;  // what a drawing of it may be off: far above round-off, far below what is drawn

}  // namespace

double angle(double measured) { return measured < kHalfTurn - M_PI ? measured + 2 * M_PI : measured; }
double quarter_turns(double counted) { return counted < kHalfTurn - 2 ? counted + 4 : counted; }

void same_direction(const Vector3& a, const Vector3& b, const std::string& axis) {
  if (a.dot(b) > 0.1) return;
  throw SceneError(
      "the " + axis + " axes of its markers differ by " + degrees_between(a, b) + " as drawn", "",
      "orient one marker so that both " + axis + " axes point the same way: marker(position, orientation)");
}

void same_axes(const MarkerView& A, const MarkerView& B) {
  same_direction(A.x(), B.x(), "x");
  same_direction(A.y(), B.y(), "y");
  same_direction(A.z(), B.z(), "z");
}

void not_parallel(const Vector3& a, const Vector3& b, const std::string& axis_a, const std::string& axis_b) {
  if (a.cross(b).norm() > std::sin(M_PI / 180)) return;
  throw SceneError("the " + axis_a + " axis of its first marker and the " + axis_b + " axis of its second differ by " +
                       degrees_between(a, b) + " as drawn, and are to be at right angles",
                   "",
                   "orient the markers so that " + axis_a + " of the first and " + axis_b +
                       " of the second are at right angles: marker(position, orientation)");
}

void apart(const MarkerView& A, const MarkerView& B) {
  const double scale = 1 + A.p.norm() + B.p.norm();
  if ((B.p - A.p).norm() > 1e-12 * scale) return;
  throw SceneError("its markers are in one place as drawn, so it has no direction", "",
                   "draw the markers apart: marker(position), or tie them with a spherical joint");
}

}  // namespace lithe::initial
