#include "bodies/beam/beam_surface.h"

#include <numeric>

#include "bodies/beam/se3_internal.h"
#include "engine/base/checks.h"

namespace lithe {
namespace {

using Corner = std::array<double, 2>;

/// Twice the area of a triangle, positive if it is counter-clockwise.
double turn(const Corner& a, const Corner& b, const Corner& c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

void check(const SectionOutline& outline, std::size_t corners) {
  if (outline.size() < 3 || outline.size() != corners)
    throw SceneError("the outline of a section has " + std::to_string(outline.size()) + " corners", "",
                     corners < 3 ? "give three or more" : "give " + std::to_string(corners) + ", as at the start");
  double area = 0;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    for (const double x : outline[i]) require::finite(x, "a corner of the outline");
    area += turn({0, 0}, outline[i], outline[(i + 1) % outline.size()]);
  }
  if (!(area > 0))
    throw SceneError("the outline of a section is clockwise or has no area", "",
                     "list its corners in the sense from axis 2 to axis 3");
}

/// Triangles of a polygon, counter-clockwise: one ear after another is cut off (Meisters 1975).
std::vector<std::array<int, 3>> fill(const SectionOutline& outline) {
  std::vector<int> rest(outline.size());
  std::iota(rest.begin(), rest.end(), 0);
  std::vector<std::array<int, 3>> triangles;
  const auto at = [&](int corner) -> const Corner& { return outline[static_cast<std::size_t>(corner)]; };
  while (rest.size() > 2) {
    const std::size_t n = rest.size();
    bool found = false;
    for (std::size_t i = 0; i < n && !found; ++i) {
      const int a = rest[(i + n - 1) % n], b = rest[i], c = rest[(i + 1) % n];
      if (!(turn(at(a), at(b), at(c)) > 0)) continue;
      found = std::none_of(rest.begin(), rest.end(), [&](int p) {
        return p != a && p != b && p != c && turn(at(a), at(b), at(p)) >= 0 && turn(at(b), at(c), at(p)) >= 0 &&
               turn(at(c), at(a), at(p)) >= 0;
      });
      if (!found) continue;
      triangles.push_back({a, b, c});
      rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(i));
    }
    if (!found)
      throw SceneError("the outline of a section crosses itself", "", "list the corners of a polygon along its rim");
  }
  return triangles;
}

}  // namespace

SurfaceMesh surface(Beam& beam, const std::function<SectionOutline(double)>& outline, int rings) {
  if (rings < 1)
    throw SceneError("the surface of '" + beam.name() + "' has " + std::to_string(rings) + " rings an element",
                     beam.where(), "give one or more");
  SurfaceMesh skin;
  require::at("the surface of '" + beam.name() + "', " + beam.where(), [&] {
    const std::size_t corners = outline(0).size();
    const FramePose& origin = beam.pose(0);
    SectionOutline section;
    // 1. Rings of corners.
    const auto add_ring = [&](double arc, const Vector3& p, const Matrix3& R) {
      section = outline(arc);
      check(section, corners);
      for (const auto& [x_2, x_3] : section) {
        const Vector3 offset(0, x_2, x_3);
        skin.nodes.push_back(beam.marker(arc, offset));
        skin.points.push_back(origin.axes.transpose() * (p + R * offset - origin.position));
      }
    };
    const int count = rings * beam.element_count();
    for (int ring = 0; ring <= count; ++ring) {
      const int e = ring / rings, inside = ring % rings;
      const FramePose& a = beam.pose(e);
      if (inside == 0) {
        add_ring(beam.arc(e), a.position, a.axes);
      } else {
        const double share = static_cast<double>(inside) / rings;
        const FramePose& b = beam.pose(e + 1);
        const auto h = se3::exp(share * se3::log_between(a.position, a.axes, b.position, b.axes));
        add_ring(beam.arc(e) + share * (beam.arc(e + 1) - beam.arc(e)), a.position + a.axes * h.p, a.axes * h.R);
      }
      // 2. Faces between them, and both ends.
      const int n = static_cast<int>(corners), first = n * ring;
      for (int k = 0; k < n && ring < count; ++k) {
        const int next = first + (k + 1) % n;
        skin.triangles.push_back({first + k, next, next + n});
        skin.triangles.push_back({first + k, next + n, first + k + n});
      }
      if (ring == 0)
        for (const auto& t : fill(section)) skin.triangles.push_back({t[0], t[2], t[1]});
      if (ring == count)
        for (const auto& t : fill(section)) skin.triangles.push_back({first + t[0], first + t[1], first + t[2]});
    }
    skin.frame = beam.marker(0);
  });
  return skin;
}

SurfaceMesh surface(Beam& beam, const SectionOutline& outline, int rings) {
  return surface(beam, std::function<SectionOutline(double)>([&](double) { return outline; }), rings);
}

SurfaceMesh surface(Beam& beam, const SectionShape& shape, int rings) {
  return surface(beam, shape.outline(32), rings);
}

}  // namespace lithe
