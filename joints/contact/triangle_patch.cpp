#include "joints/contact/triangle_patch_internal.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace lithe::narrow {
namespace triangle_parts {

/// Ericson, Real-Time Collision Detection, 2005, 5.1.5.
Vector3 nearest_weights(const std::array<Vector3, 3>& corners, const Vector3& x) {
  const Vector3 &a = corners[0], ab = corners[1] - a, ac = corners[2] - a, ax = x - a;
  const double d1 = ab.dot(ax), d2 = ac.dot(ax);
  if (d1 <= 0 && d2 <= 0) return {1, 0, 0};
  const Vector3 bx = x - corners[1];
  const double d3 = ab.dot(bx), d4 = ac.dot(bx);
  if (d3 >= 0 && d4 <= d3) return {0, 1, 0};
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return {1 - d1 / (d1 - d3), d1 / (d1 - d3), 0};
  const Vector3 cx = x - corners[2];
  const double d5 = ab.dot(cx), d6 = ac.dot(cx);
  if (d6 >= 0 && d5 <= d6) return {0, 0, 1};
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return {1 - d2 / (d2 - d6), 0, d2 / (d2 - d6)};
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    const double w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return {0, 1 - w, w};
  }
  const double v = vb / (va + vb + vc), w = vc / (va + vb + vc);
  return {1 - v - w, v, w};
}

Vector3 weighted(const std::array<Vector3, 3>& x, const Vector3& weights) {
  return weights[0] * x[0] + weights[1] * x[1] + weights[2] * x[2];
}

bool apart(const PatchTriangle& t, const Vector3& low, const Vector3& high) {
  return (t.low.array() > high.array()).any() || (t.high.array() < low.array()).any();
}

void drop_duplicates(const std::vector<PatchTriangle>& triangles, std::size_t start, std::vector<PatchTouch>& touches) {
  std::size_t kept = start;
  for (std::size_t i = start; i < touches.size(); ++i) {
    const double same = kRound * triangles[touches[i].triangle].size;
    const bool there = std::any_of(touches.begin() + start, touches.begin() + kept, [&](const PatchTouch& other) {
      return (other.touch.position - touches[i].touch.position).squaredNorm() < same * same &&
             (other.touch.normal - touches[i].touch.normal).squaredNorm() < 1e-10;
    });
    if (!there) touches[kept++] = touches[i];
  }
  touches.resize(kept);
}

}  // namespace triangle_parts

std::uint64_t feature_name(std::uint64_t kind, std::uint64_t a, std::uint64_t b) {
  std::uint64_t name = kind;
  for (std::uint64_t part : {a, b}) {  // splitmix64 (Steele, Lea & Flood 2014)
    name += part + 0x9e3779b97f4a7c15u;
    name = (name ^ (name >> 30)) * 0xbf58476d1ce4e5b9u;
    name = (name ^ (name >> 27)) * 0x94d049bb133111ebu;
    name ^= name >> 31;
  }
  return name;
}

void TrianglePatch::add(const std::array<int, 3>& corners, const std::array<bool, 3>& open,
                        const std::array<Vector3, 3>& x, const std::array<Vector3, 3>& local) {
  PatchTriangle t{.corners = corners, .open = open, .x = x};
  t.normal = (x[1] - x[0]).cross(x[2] - x[0]).normalized();
  t.low = x[0].cwiseMin(x[1]).cwiseMin(x[2]);
  t.high = x[0].cwiseMax(x[1]).cwiseMax(x[2]);
  t.size = std::sqrt(std::max({(x[1] - x[0]).squaredNorm(), (x[2] - x[1]).squaredNorm(), (x[0] - x[2]).squaredNorm()}));
  // A corner that slides over a flat surface keeps its name: that of the plane, its normal to a millionth.
  const Vector3 facing = 1e6 * (local[1] - local[0]).cross(local[2] - local[0]).normalized();
  const auto part = [&](int axis) { return static_cast<std::uint64_t>(std::llround(facing[axis])); };
  t.facet = feature_name(part(0), part(1), part(2));
  triangles.push_back(t);
}

/// Whether every triangle that shares the edge or corner `near` lies on has it as its nearest place too.
bool TrianglePatch::is_nearest_around(const Near& near) const {
  const PatchTriangle& t = triangles[near.triangle];
  for (const Near& other : near_) {
    if (other.triangle == near.triangle) continue;
    const auto& x = triangles[other.triangle].x;
    bool shares = true;
    for (int i = 0; i < 3; ++i)
      if (near.weights[i] > 0) shares = shares && std::find(x.begin(), x.end(), t.x[i]) != x.end();
    if (shares && (other.place - near.place).norm() > triangle_parts::kRound * t.size) return false;
  }
  return true;
}

/// Whether the edge or corner that `near` lies on belongs to the border of an open surface.
bool TrianglePatch::on_border(const Near& near) const {
  const PatchTriangle& t = triangles[near.triangle];
  for (int i = 0; i < 3; ++i)
    if (near.weights[(i + 2) % 3] == 0 && twin(near.triangle, i) < 0) return true;
  if (near.weights.maxCoeff() < 1) return false;
  int k = 0;
  near.weights.maxCoeff(&k);
  for (const Near& other : near_) {
    const auto& x = triangles[other.triangle].x;
    for (int i = 0; i < 3; ++i)
      if ((x[i] == t.x[k] || x[(i + 1) % 3] == t.x[k]) && twin(other.triangle, i) < 0) return true;
  }
  return false;
}

void TrianglePatch::meet_ball(const Vector3& center, double radius, double reach, double depth, std::uint64_t name,
                              std::vector<PatchTouch>& touches, std::span<const Vector3> arms) {
  const double range = std::max(reach + radius, depth);
  const Vector3 low = center.array() - range, high = center.array() + range;
  near_.clear();
  double least = std::numeric_limits<double>::infinity();
  for (int k = 0; k < static_cast<int>(triangles.size()); ++k) {
    const PatchTriangle& t = triangles[k];
    if (triangle_parts::apart(t, low, high)) continue;
    Near near{.triangle = k, .weights = triangle_parts::nearest_weights(t.x, center)};
    near.place = triangle_parts::weighted(t.x, near.weights);
    near.distance = (center - near.place).norm();
    near.height = t.normal.dot(center - t.x[0]);
    if (near.distance > range) continue;
    least = std::min(least, near.distance);
    near_.push_back(near);
  }
  if (near_.empty()) return;

  const std::size_t start = touches.size();
  const double curvature = radius > 0 ? 1 / radius : 0;
  const auto add = [&](const Near& near, const Vector3& normal, double gap, std::uint64_t feature) {
    const Vector3 position = near.place + 0.5 * gap * normal;
    touches.push_back({{position, normal, gap, curvature, feature}, near.triangle, near.weights});
  };
  const auto of_face = [&](const Near& near) { return feature_name(1, name, triangles[near.triangle].facet); };

  const auto over_face = [&](const Near& near) {
    const PatchTriangle& t = triangles[near.triangle];
    return (center - near.place - near.height * t.normal).norm() <= triangle_parts::kRound * t.size;
  };
  const auto own = [&](const Vector3& normal) {
    return std::ranges::all_of(
        arms, [&](const Vector3& arm) { return normal.dot(arm) >= -triangle_parts::kSlope * arm.norm(); });
  };
  // Inside or outside says the nearest triangle; where several share the nearest place, the one most square to the way
  // there.
  const auto nearest_from = [&](double distance, const auto& counts) {
    const Near* nearest = nullptr;
    for (const Near& near : near_)
      if (near.distance <= distance + triangle_parts::kRound * triangles[near.triangle].size && counts(near) &&
          (!nearest || std::abs(near.height) > std::abs(nearest->height)))
        nearest = &near;
    return nearest;
  };
  const Near* nearest = nearest_from(least, [](const Near&) { return true; });
  if (nearest->height < 0) {
    const auto way_out = [&](const Near& near) {
      return over_face(near) ? triangles[near.triangle].normal : Vector3((near.place - center) / near.distance);
    };
    if (!arms.empty()) {
      const auto counts = [&](const Near& near) {
        return near.height < 0 && (over_face(near) || is_nearest_around(near)) && own(way_out(near));
      };
      least = std::numeric_limits<double>::infinity();
      for (const Near& near : near_)
        if (near.distance < least && counts(near)) least = near.distance;
      nearest = nearest_from(least, counts);
      if (!nearest) return;
    }
    const bool on_face = nearest->weights.minCoeff() > 0;
    if (nearest->distance > depth || (!on_face && on_border(*nearest))) return;
    add(*nearest, way_out(*nearest), (over_face(*nearest) ? nearest->height : -nearest->distance) - radius,
        of_face(*nearest));
    return;
  }
  for (const Near& near : near_) {
    const PatchTriangle& t = triangles[near.triangle];
    const bool over = over_face(near);
    if (near.height < 0 || (over ? near.height : near.distance) - radius >= reach || !own(t.normal)) continue;
    if (over) {
      add(near, t.normal, near.height - radius, of_face(near));
      continue;
    }
    if (!is_nearest_around(near)) continue;
    bool open = false;  // an edge that the place lies on
    std::uint64_t edge = 0;
    for (int i = 0; i < 3; ++i) {
      if (near.weights[(i + 2) % 3] == 0) open = open || t.open[i];
      if (near.weights[i] > 0) edge += feature_name(3, t.corners[i], 0);
    }
    if (!open)
      add(near, t.normal, near.height - radius, of_face(near));
    else if (radius > 0)
      add(near, (center - near.place) / near.distance, near.distance - radius, feature_name(2, name, edge));
  }
  triangle_parts::drop_duplicates(triangles, start, touches);
  // Two places on what was one plane before it bent.
  for (std::size_t i = start; i < touches.size(); ++i)
    for (std::size_t k = start; k < i; ++k)
      if (touches[k].touch.feature == touches[i].touch.feature)
        touches[i].touch.feature = feature_name(10, touches[i].touch.feature, 0);
}

}  // namespace lithe::narrow
