// Two surfaces of triangles: corners of one over the other, and edges that cross.
#include <algorithm>
#include <cmath>
#include <limits>

#include "joints/contact/triangle_patch_internal.h"

namespace lithe::narrow {

void TrianglePatch::meet_corners_of(const TrianglePatch& other, double reach, double depth,
                                    std::vector<PatchTouch>& touches) {
  const std::size_t start = touches.size();
  Vector3 low = Vector3::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (const PatchTriangle& t : triangles) low = low.cwiseMin(t.low), high = high.cwiseMax(t.high);
  low.array() -= std::max(reach, depth), high.array() += std::max(reach, depth);
  seen_.clear();  // rising
  for (const PatchTriangle& t : other.triangles)
    for (int i = 0; i < 3; ++i) {
      const Vector3& x = t.x[i];
      if ((!t.open[i] && !t.open[(i + 2) % 3]) || (x.array() < low.array()).any() || (x.array() > high.array()).any())
        continue;
      const auto place = std::ranges::lower_bound(seen_, t.corners[i]);
      if (place != seen_.end() && *place == t.corners[i]) continue;
      seen_.insert(place, t.corners[i]);
      arms_.clear();
      for (const PatchTriangle& u : other.triangles)
        if (std::ranges::find(u.x, x) != u.x.end())
          for (const Vector3& y : u.x)
            if (y != x) arms_.push_back(y - x);
      meet_ball(x, 0, reach, depth, feature_name(8, static_cast<std::uint64_t>(t.corners[i]), 0), touches, arms_);
    }
  triangle_parts::drop_duplicates(triangles, start, touches);
}

double TrianglePatch::depth_of(const Vector3& x, double most) {
  found_.clear();
  meet_ball(x, 0, 0, most, 0, found_);
  return found_.empty() ? 0 : std::max(0.0, -found_[0].touch.gap);
}

bool TrianglePatch::overlaps(const OpenEdge& mine, TrianglePatch& other, const OpenEdge& theirs, const Vector3& middle,
                             const Vector3& d, double depth) {
  const auto along = [](const TrianglePatch& patch, const OpenEdge& e) {
    const auto& x = patch.triangles[e.triangle].x;
    return Vector3((x[(e.edge + 1) % 3] - x[e.edge]).normalized());
  };
  // How deep a place moved by `way` is behind the faces at an edge, in the middle between it and the other.
  const auto behind = [&](const TrianglePatch& patch, const OpenEdge& e, const Vector3& out, const Vector3& way) {
    const auto face = [&](int k) {
      const Vector3& n = patch.triangles[k].normal;
      return 0.5 * depth * n.dot(out) - n.dot(way);
    };
    return e.other < 0 ? face(e.triangle) : std::min(face(e.triangle), face(e.other));
  };
  const Vector3 a = along(*this, mine), b = along(other, theirs);
  double expected = 0, actual = 0;
  for (double u : {0.0, -0.5, 0.5})
    for (double w : {0.0, -0.5, 0.5}) {
      const Vector3 along_b = u * depth * b, along_a = w * depth * a, x = middle + along_b + along_a;
      expected = std::max(expected, std::min(behind(*this, mine, d, along_b), behind(other, theirs, -d, along_a)));
      actual = std::max(actual, std::min(depth_of(x, 2 * depth), other.depth_of(x, 2 * depth)));
    }
  return actual > 0.5 * expected;
}

int TrianglePatch::twin(int triangle, int i) const {
  const auto& t = triangles[triangle].x;
  for (int k = 0; k < static_cast<int>(triangles.size()); ++k) {
    const auto& x = triangles[k].x;
    if (k != triangle && std::find(x.begin(), x.end(), t[i]) != x.end() &&
        std::find(x.begin(), x.end(), t[(i + 1) % 3]) != x.end())
      return k;
  }
  return -1;
}

bool TrianglePatch::leans(int triangle, int i, int other, const Vector3& d) const {
  const PatchTriangle& t = triangles[triangle];
  const Vector3 &start = t.x[i], along = t.x[(i + 1) % 3] - start;
  const auto out = [&](const PatchTriangle& side) {  // in its plane, away from it
    for (const Vector3& x : side.x)
      if (x != start && x != t.x[(i + 1) % 3])
        return Vector3((start - x) - (start - x).dot(along) / along.dot(along) * along);
    return Vector3(Vector3::Zero());
  };
  const auto beyond = [&](const Vector3& m) { return d.dot(m) >= -triangle_parts::kParallel * m.norm(); };
  if (!beyond(out(t))) return false;
  if (other < 0) return d.dot(t.normal) >= -triangle_parts::kParallel;
  return beyond(out(triangles[other])) && d.dot(t.normal + triangles[other].normal) > 0;
}

const std::vector<TrianglePatch::OpenEdge>& TrianglePatch::find_open_edges() {
  open_.clear();
  for (int k = 0; k < static_cast<int>(triangles.size()); ++k)
    for (int i = 0; i < 3; ++i) {
      if (!triangles[k].open[i]) continue;
      const int other = twin(k, i);
      if (other < 0 || other > k) open_.push_back({k, i, other});
    }
  return open_;
}

void TrianglePatch::meet_edges_of(TrianglePatch& other, double reach, double depth, std::vector<EdgeTouch>& touches) {
  constexpr double kRound = triangle_parts::kRound;
  const std::size_t start = touches.size();
  const auto& of_other = other.find_open_edges();
  const double range = std::max(reach, depth);
  for (const OpenEdge& mine : find_open_edges()) {
    const PatchTriangle& t = triangles[mine.triangle];
    const int a = mine.edge, a_end = (a + 1) % 3;
    const Vector3 &a0 = t.x[a], &a1 = t.x[a_end], along = a1 - a0;
    const Vector3 low = a0.cwiseMin(a1).array() - range, high = a0.cwiseMax(a1).array() + range;
    Vector3 facing = t.normal;
    if (mine.other >= 0) facing += triangles[mine.other].normal;
    for (const OpenEdge& theirs : of_other) {
      const PatchTriangle& u = other.triangles[theirs.triangle];
      const int b = theirs.edge, b_end = (b + 1) % 3;
      const Vector3 &b0 = u.x[b], &b1 = u.x[b_end];
      if ((b0.cwiseMin(b1).array() > high.array()).any() || (b0.cwiseMax(b1).array() < low.array()).any()) continue;
      const Vector3 across = b1 - b0, between = b0 - a0, square = along.cross(across);
      const double sine = square.norm();
      if (sine <= 1e-6 * along.norm() * across.norm()) continue;
      // a0 + s along and b0 + r across, joined by a line square to both
      const double s = between.cross(across).dot(square) / (sine * sine);
      const double r = between.cross(along).dot(square) / (sine * sine);
      if (std::min(s, r) < -kRound || std::max(s, r) > 1 + kRound) continue;
      const double sign = square.dot(facing) < 0 ? -1 : 1, gap = sign * between.dot(square) / sine;
      const Vector3 d = (sign / sine) * square;
      if (gap >= reach || gap < -depth || !leans(mine.triangle, a, mine.other, d) ||
          !other.leans(theirs.triangle, b, theirs.other, -d))
        continue;
      const Vector3 place = a0 + s * along + 0.5 * gap * d;
      if (-gap > kRound * (t.size + u.size) && !overlaps(mine, other, theirs, place, d, -gap)) continue;
      const auto name = [](const PatchTriangle& of, int i, int k) {
        return feature_name(3, of.corners[i], 0) + feature_name(3, of.corners[k], 0);
      };
      EdgeTouch touch{{place, d, gap, 0, feature_name(11, name(t, a, a_end), name(u, b, b_end))},
                      mine.triangle,
                      theirs.triangle,
                      Vector3::Zero(),
                      Vector3::Zero()};
      touch.weights[a] = 1 - s, touch.weights[a_end] = s;
      touch.other_weights[b] = 1 - r, touch.other_weights[b_end] = r;
      // Edges that go on behind a corner cross there twice.
      if (std::none_of(touches.begin() + static_cast<std::ptrdiff_t>(start), touches.end(), [&](const EdgeTouch& kept) {
            return (kept.touch.position - place).norm() < kRound * (t.size + u.size);
          }))
        touches.push_back(touch);
    }
  }
}

}  // namespace lithe::narrow
