#include "joints/contact/solid_internal.h"

namespace lithe::narrow {
namespace patch_parts {

constexpr int kRimPoints = 16;
constexpr double kSlack = 2e-6;  // of the size: corners so little outside a face count as inside

/// The corner, edge or face that a shape turns towards the other: x, y across the normal, z along it.
struct Outline {
  std::vector<Vector3> points;
  std::vector<int> names;
  Vector3 plane;  // of a face: its normal

  void clear() { points.clear(), names.clear(); }
  int count() const { return static_cast<int>(points.size()); }
  double height(double x, double y) const {
    if (count() == 1) return points[0].z();
    if (count() == 2) {
      const Vector3 along = points[1] - points[0], d = Vector3(x, y, 0) - points[0];
      const double square = along.head<2>().squaredNorm();
      return points[0].z() + (square > 0 ? along.head<2>().dot(d.head<2>()) / square * along.z() : 0);
    }
    const Vector3 d = points[0] - Vector3(x, y, 0);
    return plane.dot(d) / plane.z();
  }
  /// Twice the area: its sign tells which way round the points go.
  double turn() const {
    double area = 0;
    for (int i = 2; i < count(); ++i) area += cross(points[i - 1] - points[0], points[i] - points[0]);
    return area;
  }
  static double cross(const Vector3& a, const Vector3& b) { return a.x() * b.y() - a.y() * b.x(); }
  /// By how much p is outside; zero or less: it is not.
  double outside(const Vector3& p, double orientation) const {
    if (count() == 1) return (p - points[0]).head<2>().norm();
    double most = -std::numeric_limits<double>::infinity();
    for (int i = 0; i < count(); ++i) {
      const Vector3 along = points[(i + 1) % count()] - points[i], d = p - points[i];
      const double length = along.head<2>().norm();
      if (!(length > 0)) continue;
      most = std::max(most, -orientation * cross(along, d) / length);
      if (count() == 2) most = std::max(most, -along.head<2>().dot(d.head<2>()) / length);
    }
    return most;
  }
};

struct Axes {
  Vector3 x, y, z;
  explicit Axes(const Vector3& normal) : z(normal) { x = normal.unitOrthogonal(), y = z.cross(x); }
  Vector3 to(const Vector3& p) const { return {x.dot(p), y.dot(p), z.dot(p)}; }
  Vector3 from(const Vector3& p) const { return p[0] * x + p[1] * y + p[2] * z; }
};

/// The disc of a round shape as a polygon whose first corner is the one that reaches farthest along n, or the line of
/// its side there.
void outline_round(const Solid& s, const Vector3& n, const Axes& axes, Outline& outline) {
  const double along = n.dot(s.axis);
  const Vector3 wide = n - along * s.axis;
  const double width = wide.norm();
  const Vector3 side = width > 1e-9 ? Vector3(wide / width) : s.across;
  const Vector3 end = s.half_length * s.axis;
  const double sine = s.sin_side();
  const bool base = s.cone && -along > std::sqrt(1 - sine * sine) * width + sine * along;
  if (base || (!s.cone && std::abs(along) > width)) {
    const double up = s.cone || along < 0 ? -1 : 1;
    const Vector3 other = s.axis.cross(side);
    for (int k = 0; k < kRimPoints; ++k) {
      const double angle = 2 * M_PI * k / kRimPoints;
      // Quarters exactly: a shape that stands is as high at each.
      const double c = k % 8 == 4 ? 0 : std::cos(angle), d = k % 8 == 0 ? 0 : std::sin(angle);
      outline.points.push_back(axes.to(s.centre + up * end + s.rim * (c * side + d * other)));
      outline.names.push_back(k + (up > 0 ? kRimPoints : 0));
    }
    outline.plane = axes.to(up * s.axis);
    return;
  }
  outline.points.push_back(axes.to(s.centre - end + s.rim * side));
  outline.points.push_back(axes.to(s.centre + end + (s.cone ? 0 : s.rim) * side));
  outline.names.assign({2 * kRimPoints, 2 * kRimPoints + 1});
}

/// What of the shape reaches farthest along n: the face whose three farthest corners are farthest.
void outline_of(const Solid& s, const Vector3& n, const Axes& axes, Outline& outline) {
  outline.clear();
  if (s.flat == nullptr) return outline_round(s, n, axes, outline);
  const auto add = [&](int corner) {
    outline.points.push_back(axes.to(s.corners[corner]));
    outline.names.push_back(corner);
  };
  const int faces = static_cast<int>(s.normals.size());
  if (faces == 0) {
    for (int c = 0; c < static_cast<int>(s.corners.size()); ++c) add(c);
    return;
  }
  int best = 0;
  double farthest = -std::numeric_limits<double>::infinity();
  for (int f = 0; f < faces; ++f) {
    if (n.dot(s.normals[f]) <= 0) continue;
    std::array<double, 3> high;
    high.fill(-std::numeric_limits<double>::infinity());
    for (int c : s.flat->loop(f)) {
      const double h = n.dot(s.corners[c]);
      if (h > high[0])
        high = {h, high[0], high[1]};
      else if (h > high[1])
        high = {high[0], h, high[1]};
      else if (h > high[2])
        high[2] = h;
    }
    const double sum = high[0] + high[1] + high[2];
    if (sum > farthest) farthest = sum, best = f;
  }
  if (s.normals[best].dot(n) < 0.01) {  // seen from the side: its two farthest corners
    const auto loop = s.flat->loop(best);
    int p = -1, q = -1;
    for (int c : loop) {
      if (p < 0 || n.dot(s.corners[c]) > n.dot(s.corners[p]))
        q = p, p = c;
      else if (q < 0 || n.dot(s.corners[c]) > n.dot(s.corners[q]))
        q = c;
    }
    add(p), add(q);
    return;
  }
  for (int c : s.flat->loop(best)) add(c);
  outline.plane = axes.to(s.normals[best]);
}

std::uint64_t name_of(int kind, std::uint64_t a, std::uint64_t b) {
  return std::uint64_t(kind) << 60 | (a & 0x3fffffff) << 30 | (b & 0x3fffffff);
}
std::uint64_t edge_name(const Outline& o, int i) {
  const auto [low, high] = std::minmax(o.names[i], o.names[(i + 1) % o.count()]);
  return std::uint64_t(low & 0x7fff) << 15 | std::uint64_t(high & 0x7fff);
}

/// Mean curvature, 1/m: of a ball at the ends of a capsule, half of it along its side.
double curvature_of(const Solid& s, const Outline& outline, const Vector3& p, double slack) {
  if (s.flat == nullptr) return !s.cone && outline.count() == 2 ? 0.5 / s.rim : 0;
  if (s.radius == 0) return 0;
  const bool end = outline.count() < 2 || (p - outline.points[0]).head<2>().norm() <= slack ||
                   (p - outline.points[1]).head<2>().norm() <= slack;
  return (end ? 1 : 0.5) / s.radius;
}

}  // namespace patch_parts

double patch(const Solid& a, const Solid& b, const Separation& at, std::vector<Touch>& touches) {
  using namespace patch_parts;
  thread_local Outline A, B;
  const Axes axes(at.normal);
  outline_of(a, at.normal, axes, A);
  outline_of(b, -at.normal, axes, B);
  const double turn_a = A.turn() < 0 ? -1 : 1, turn_b = B.turn() < 0 ? -1 : 1, size = std::max(a.size, b.size);
  // A round surface falls away beside its line: there the slack is none.
  const bool faces = A.count() > 2 && B.count() > 2;
  const double slack = (faces ? kSlack : 1e-12) * size;
  const std::size_t start = touches.size();
  double least = std::numeric_limits<double>::infinity();
  const auto add = [&](const Vector3& p, double z_a, double z_b, std::uint64_t name) {
    // Steep faces magnify the slack: nothing is deeper than the shapes are.
    const double top = z_a + a.radius, bottom = z_b - b.radius;
    touches.push_back({axes.from({p.x(), p.y(), (top + bottom) / 2}), at.normal,
                       std::max(bottom - top, at.distance - a.radius - b.radius),
                       curvature_of(a, A, p, 1e-9 * size) + curvature_of(b, B, p, 1e-9 * size), name});
  };
  const auto known = [&](const Vector3& p) {
    for (std::size_t i = start; i < touches.size(); ++i)
      if ((axes.to(touches[i].position) - p).head<2>().squaredNorm() < 4 * slack * slack) return true;
    return false;
  };
  const double sharp = 1e-15 * size;
  for (int i = 0; i < A.count(); ++i) {
    const Vector3& p = A.points[i];
    const double out = B.outside(p, turn_b), z_b = B.height(p.x(), p.y());
    if (!(out <= slack)) continue;
    add(p, p.z(), z_b, name_of(1, A.names[i], 0));
    if (out <= sharp) least = std::min(least, z_b - p.z());
  }
  for (int j = 0; j < B.count(); ++j) {
    const Vector3& p = B.points[j];
    const double out = A.outside(p, turn_a), z_a = A.height(p.x(), p.y());
    if (!(out <= slack)) continue;
    if (!known(p)) add(p, z_a, p.z(), name_of(2, B.names[j], 0));
    if (out <= sharp) least = std::min(least, p.z() - z_a);
  }
  const auto edges = [](const Outline& o) { return o.count() > 2 ? o.count() : o.count() - 1; };
  for (int i = 0; i < edges(A); ++i)
    for (int j = 0; j < edges(B); ++j) {
      const Vector3 &p = A.points[i], &q = B.points[j];
      const Vector3 u = A.points[(i + 1) % A.count()] - p, v = B.points[(j + 1) % B.count()] - q, d = q - p;
      const double det = Outline::cross(u, v), lengths = u.head<2>().norm() * v.head<2>().norm();
      if (std::abs(det) < (faces ? 1e-6 : 1e-5) * lengths) {
        if (faces || !(lengths > 0)) continue;
        // Lines side by side: where they begin and end to face each other.
        if (A.count() > 2 || B.count() > 2 || std::abs(Outline::cross(u, d)) > 1e-5 * size * u.head<2>().norm())
          continue;
        const double square = u.head<2>().squaredNorm(), s = u.head<2>().dot(d.head<2>()) / square;
        const double t = s + u.head<2>().dot(v.head<2>()) / square;
        const double low = std::max(0.0, std::min(s, t)), high = std::min(1.0, std::max(s, t));
        touches.resize(start);
        if (low > high) return least;
        for (double x : {low, high}) {
          const double y = std::clamp((x - s) / (t - s), 0.0, 1.0);
          add(p + x * u, p.z() + x * u.z(), q.z() + y * v.z(), name_of(3, x == low ? 1 : 2, 0));
          least = std::min(least, q.z() + y * v.z() - p.z() - x * u.z());
        }
        return least;
      }
      const double x = Outline::cross(d, v) / det, y = Outline::cross(d, u) / det;
      if (!(x >= 0 && x <= 1 && y >= 0 && y <= 1)) continue;
      const Vector3 point = p + x * u;
      const double z_b = q.z() + y * v.z();
      if (!known(point)) add(point, point.z(), z_b, name_of(3, edge_name(A, i), edge_name(B, j)));
      least = std::min(least, z_b - point.z());
    }
  return least;
}

}  // namespace lithe::narrow
