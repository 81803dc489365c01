#include "joints/contact/solid_internal.h"

namespace lithe::narrow {
namespace narrow_parts {

constexpr std::uint64_t kNearest = std::uint64_t(4) << 60;  // the nearest point, where no patch has it

/// Two balls, or balls around points; nothing where the points coincide.
void balls(const Vector3& a, double radius_a, const Vector3& b, double radius_b, double curvature, double reach,
           std::uint64_t feature, std::vector<Touch>& touches) {
  const Vector3 d = b - a;
  const double square = d.squaredNorm(), far = radius_a + radius_b + reach;
  if (!(square < far * far) || square == 0) return;
  const double distance = std::sqrt(square), gap = distance - radius_a - radius_b;
  const Vector3 n = d / distance;
  touches.push_back({a + (radius_a + gap / 2) * n, n, gap, curvature, feature});
}

struct Segment {
  Vector3 start, along;
  double radius;
  Segment(const btConvexShape& shape, const btTransform& at) {
    const auto& capsule = static_cast<const btCapsuleShape&>(shape);
    const Vector3 half = from_bullet(at.getBasis().getColumn(2)) * capsule.getHalfHeight();
    start = from_bullet(at.getOrigin()) - half, along = 2 * half;
    radius = capsule.getRadius();
  }
  double nearest(const Vector3& p) const { return std::clamp((p - start).dot(along) / along.squaredNorm(), 0.0, 1.0); }
  Vector3 at(double s) const { return start + s * along; }
  double curvature(double s) const { return (s > 0 && s < 1 ? 0.5 : 1) / radius; }
};

double radius_of(const btConvexShape& sphere) { return static_cast<const btSphereShape&>(sphere).getRadius(); }

void sphere_capsule(const btConvexShape& a, const btTransform& at, const btConvexShape& b, const btTransform& bt,
                    double reach, std::vector<Touch>& touches) {
  const Segment axis(b, bt);
  const Vector3 centre = from_bullet(at.getOrigin());
  const double s = axis.nearest(centre), radius = radius_of(a);
  balls(centre, radius, axis.at(s), axis.radius, 1 / radius + axis.curvature(s), reach, 0, touches);
}

void capsule_capsule(const btConvexShape& a, const btTransform& at, const btConvexShape& b, const btTransform& bt,
                     double reach, std::vector<Touch>& touches) {
  const Segment A(a, at), B(b, bt);
  const auto add = [&](double s, double t, std::uint64_t feature) {
    balls(A.at(s), A.radius, B.at(t), B.radius, A.curvature(s) + B.curvature(t), reach, feature, touches);
  };
  const Vector3 d = B.start - A.start;
  const double aa = A.along.squaredNorm(), bb = B.along.squaredNorm(), ab = A.along.dot(B.along);
  const double det = A.along.cross(B.along).squaredNorm();
  // Nearest points of the axes: along both lines, then cut to each segment in turn (Ericson 2005, 5.1.9).
  const auto nearest = [&] {
    double s = std::clamp((A.along.dot(d) * bb - B.along.dot(d) * ab) / det, 0.0, 1.0);
    double t = (s * ab - B.along.dot(d)) / bb;
    if (t < 0 || t > 1) t = std::clamp(t, 0.0, 1.0), s = A.nearest(B.at(t));
    return std::pair(s, t);
  };
  if (!(det < 1e-6 * aa * bb)) {
    const auto [s, t] = nearest();
    return add(s, t, 0);
  }
  // Side by side: both ends of what they share.
  const double first = A.along.dot(d) / aa, last = first + ab / aa;
  const double low = std::max(0.0, std::min(first, last)), high = std::min(1.0, std::max(first, last));
  if (low >= high) {
    const double s = low > 1 || first + last > 1 ? 1 : 0, t = B.nearest(A.at(s));
    return add(A.nearest(B.at(t)), t, 0);
  }
  const double t_low = B.nearest(A.at(low)), t_high = B.nearest(A.at(high));
  add(low, t_low, 1);
  add(high, t_high, 2);
  if (det < 1e-18 * aa * bb) return;
  const auto [s, t] = nearest();
  const double square = (B.at(t) - A.at(s)).squaredNorm(), slack = 1e-12 * aa;
  if (square < (B.at(t_low) - A.at(low)).squaredNorm() - slack &&
      square < (B.at(t_high) - A.at(high)).squaredNorm() - slack)
    add(s, t, 0);
}

void sphere_box(const btConvexShape& a, const btTransform& at, const btConvexShape& b, const btTransform& bt,
                double reach, std::vector<Touch>& touches) {
  const Vector3 half = static_cast<const Polyhedron*>(b.getUserPointer())->corners[7];
  const Vector3 centre = from_bullet(bt.invXform(at.getOrigin()));
  const double radius = radius_of(a);
  Vector3 normal, nearest = centre.cwiseMax(-half).cwiseMin(half);
  double distance = (centre - nearest).norm();
  if (!(distance < radius + reach)) return;
  if (distance > 0) {
    normal = (nearest - centre) / distance;
  } else {
    int axis = 0;  // inside: out by the nearest face
    const double depth = (half - centre.cwiseAbs()).minCoeff(&axis);
    const double side = centre[axis] < 0 ? -1 : 1;
    normal = -side * Vector3::Unit(axis);
    distance = -depth;
    nearest[axis] = side * half[axis];
  }
  const double gap = distance - radius;
  const auto& R = bt.getBasis();
  touches.push_back({from_bullet(bt(to_bullet(Vector3(nearest - gap / 2 * normal)))),
                     from_bullet(R * to_bullet(normal)), gap, 1 / radius, 0});
}

/// Any pair: in A's axes the direction of least depth or of distance, and the patch across it.
void general(const btConvexShape& a, const btTransform& at, const btConvexShape& b, const btTransform& bt, double reach,
             std::vector<Touch>& touches) {
  thread_local Solid A, B;
  const btMatrix3x3 to_a = at.getBasis().transpose();
  const btTransform relative(to_a * bt.getBasis(), to_a * (bt.getOrigin() - at.getOrigin()));
  Matrix3 R;
  for (int i = 0; i < 3; ++i) R.col(i) = from_bullet(relative.getBasis().getColumn(i));
  A.set(a, Vector3::Zero(), Matrix3::Identity());
  B.set(b, from_bullet(relative.getOrigin()), R);

  const double radii = A.radius + B.radius, enough = reach + radii, size = std::max(A.size, B.size);
  Separation best = separation_of_faces(A, B, enough);
  if (!(best.distance < enough)) return;
  const std::size_t start = touches.size();
  const auto deepest = [&] {
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = start; i < touches.size(); ++i) least = std::min(least, touches[i].gap);
    return least;
  };
  const double slack = 1e-12 * (size + radii);
  const double across = patch(A, B, best, touches);
  // Where something lies across this direction nothing is nearer; flat shapes that overlap have no better one, and
  // round ones that hardly do only within their depth of an edge.
  const bool flat = A.flat != nullptr && B.flat != nullptr;
  const bool sure =
      (flat && best.distance <= 0) || ((flat || best.distance > -1e-3 * size) && across <= best.distance + slack);
  if (!sure) {
    touches.resize(start);
    refine_separation(a, b, relative, A, B, best);
    if (!(best.distance < enough)) return;
    patch(A, B, best, touches);
  }
  const double gap = best.distance - radii;
  if (!(deepest() <= gap + slack)) {
    if (!best.on_a.allFinite()) best.on_a = B.extreme(-best.normal) - best.distance * best.normal;
    touches.push_back({best.on_a + (A.radius + gap / 2) * best.normal, best.normal, gap,
                       (A.radius > 0 ? 1 / A.radius : 0) + (B.radius > 0 ? 1 / B.radius : 0), kNearest});
  }
  std::size_t kept = start;
  const auto& basis = at.getBasis();
  for (std::size_t i = start; i < touches.size(); ++i) {
    if (!(touches[i].gap < reach)) continue;
    Touch t = touches[i];
    t.position = from_bullet(at(to_bullet(t.position)));
    t.normal = from_bullet(basis * to_bullet(t.normal));
    touches[kept++] = t;
  }
  touches.resize(kept);
}

/// Swaps the sides of touches found with the shapes the other way round.
template <class Pair>
void swapped(Pair&& pair, std::vector<Touch>& touches) {
  const std::size_t start = touches.size();
  pair();
  for (std::size_t i = start; i < touches.size(); ++i) touches[i].normal = -touches[i].normal;
}

}  // namespace narrow_parts

void convex_convex(const btConvexShape& a, const btTransform& at, const btConvexShape& b, const btTransform& bt,
                   double reach, std::vector<Touch>& touches) {
  using namespace narrow_parts;
  const int kind_a = a.getShapeType(), kind_b = b.getShapeType();
  constexpr int kSphere = SPHERE_SHAPE_PROXYTYPE, kCapsule = CAPSULE_SHAPE_PROXYTYPE, kBox = BOX_SHAPE_PROXYTYPE;
  if (kind_a == kSphere) {
    if (kind_b == kSphere) {
      const double ra = radius_of(a), rb = radius_of(b);
      return balls(from_bullet(at.getOrigin()), ra, from_bullet(bt.getOrigin()), rb, 1 / ra + 1 / rb, reach, 0,
                   touches);
    }
    if (kind_b == kBox) return sphere_box(a, at, b, bt, reach, touches);
    if (kind_b == kCapsule) return sphere_capsule(a, at, b, bt, reach, touches);
  } else if (kind_b == kSphere && (kind_a == kBox || kind_a == kCapsule)) {
    return swapped([&] { convex_convex(b, bt, a, at, reach, touches); }, touches);
  } else if (kind_a == kCapsule && kind_b == kCapsule) {
    return capsule_capsule(a, at, b, bt, reach, touches);
  }
  general(a, at, b, bt, reach, touches);
}

void plane_convex(const btTransform& plane, const btConvexShape& b, const btTransform& bt, double reach,
                  std::vector<Touch>& touches) {
  const Vector3 n = from_bullet(plane.getBasis().getColumn(2)), origin = from_bullet(plane.getOrigin());
  const Vector3 centre = from_bullet(bt.getOrigin());
  const double height = n.dot(centre - origin);
  const auto add = [&](const Vector3& arm, double radius, double curvature, std::uint64_t feature) {
    const double gap = height + n.dot(arm) - radius;
    if (gap < reach) touches.push_back({centre + arm - (radius + gap / 2) * n, n, gap, curvature, feature});
  };
  if (b.getShapeType() == SPHERE_SHAPE_PROXYTYPE) {
    const double radius = narrow_parts::radius_of(b);
    return add(Vector3::Zero(), radius, 1 / radius, 0);
  }
  Matrix3 R;
  for (int i = 0; i < 3; ++i) R.col(i) = from_bullet(bt.getBasis().getColumn(i));
  if (const auto* flat = static_cast<const Polyhedron*>(b.getUserPointer())) {
    const double radius =
        b.getShapeType() == CAPSULE_SHAPE_PROXYTYPE ? static_cast<const btCapsuleShape&>(b).getRadius() : 0;
    for (std::size_t c = 0; c < flat->corners.size(); ++c)
      add(R * flat->corners[c], radius, radius > 0 ? 1 / radius : 0, c);
    return;
  }
  // Rims by four points each, the lowest and those a quarter round: they move without a jump as it tilts.
  thread_local Solid round;
  round.set(b, Vector3::Zero(), R);
  const Vector3 wide = n.dot(round.axis) * round.axis - n;
  const double width = wide.norm();
  const Vector3 down = width > 1e-9 ? Vector3(wide / width) : round.across, aside = round.axis.cross(down);
  const double curvature = round.cone ? 0 : 0.5 / round.rim * (width > M_SQRT1_2 ? 1 : 0);
  for (int end : {0, 1}) {
    const Vector3 middle = (end - 0.5) * 2 * round.half_length * round.axis;
    if (end == 1 && round.cone) {
      add(middle, 0, 0, 4);
      break;
    }
    const std::array<Vector3, 4> arms{down, aside, -down, -aside};
    for (int k = 0; k < 4; ++k) add(middle + round.rim * arms[k], 0, curvature, 4 * end + k);
  }
}

}  // namespace lithe::narrow
