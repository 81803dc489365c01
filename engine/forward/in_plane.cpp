#include "engine/forward/in_plane.h"

#include <cmath>

namespace lithe {

bool are_parallel(const Vector3& a, const Vector3& b) { return a.cross(b).norm() <= kParallelAxes; }
bool are_perpendicular(const Vector3& a, const Vector3& b) { return std::abs(a.dot(b)) <= kParallelAxes; }

bool holds_in_plane(const JointFreedom& f, const Matrix3& R, const Vector3& n) {
  if (f.rotation == JointFreedom::Rotation::any) return false;
  if (f.rotation == JointFreedom::Rotation::about_z && !are_parallel(R.col(2), n)) return false;
  const bool shifts[] = {f.x, f.y, f.z};
  for (int i = 0; i < 3; ++i)
    if (shifts[i] && !are_perpendicular(R.col(i), n)) return false;
  return true;
}

std::vector<char> reached_over(const std::vector<std::pair<int, int>>& pairs, std::vector<char> held) {
  std::vector<std::vector<int>> next(held.size());
  for (const auto& [a, b] : pairs) next[a].push_back(b), next[b].push_back(a);
  std::vector<int> reached;
  for (std::size_t i = 0; i < held.size(); ++i)
    if (held[i]) reached.push_back(static_cast<int>(i));
  for (std::size_t i = 0; i < reached.size(); ++i)
    for (int other : next[reached[i]])
      if (!held[other]) held[other] = 1, reached.push_back(other);
  return held;
}

}  // namespace lithe
