#include <BulletCollision/CollisionShapes/btTriangleShape.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkEpa2.h>

#include "joints/contact/solid_internal.h"

namespace lithe::narrow {

void Solid::set(const btConvexShape& shape, const Vector3& position, const Matrix3& orientation) {
  radius = 0;
  flat = static_cast<const Polyhedron*>(shape.getUserPointer());
  switch (shape.getShapeType()) {
    case SPHERE_SHAPE_PROXYTYPE:
      radius = static_cast<const btSphereShape&>(shape).getRadius();
      break;
    case CAPSULE_SHAPE_PROXYTYPE:
      radius = static_cast<const btCapsuleShape&>(shape).getRadius();
      break;
    case TRIANGLE_SHAPE_PROXYTYPE: {
      const auto& t = static_cast<const btTriangleShape&>(shape);
      set_triangle(from_bullet(t.m_vertices1[0]), from_bullet(t.m_vertices1[1]), from_bullet(t.m_vertices1[2]),
                   triangle_);
      flat = &triangle_;
      break;
    }
    case CYLINDER_SHAPE_PROXYTYPE: {
      const btVector3 half = static_cast<const btCylinderShape&>(shape).getHalfExtentsWithoutMargin();
      cone = false, rim = half.x(), half_length = half.z();
      break;
    }
    case CONE_SHAPE_PROXYTYPE: {
      const auto& c = static_cast<const btConeShape&>(shape);
      cone = true, rim = c.getRadius(), half_length = c.getHeight() / 2;
      break;
    }
    default:
      break;
  }
  if (flat == nullptr) {
    centre = position, axis = orientation.col(2), across = orientation.col(0);
    size = 2 * std::max(rim, half_length);
    return;
  }
  size = flat->size;
  corners.resize(flat->corners.size());
  for (std::size_t i = 0; i < corners.size(); ++i) corners[i] = position + orientation * flat->corners[i];
  normals.resize(flat->normals.size());
  for (std::size_t i = 0; i < normals.size(); ++i) normals[i] = orientation * flat->normals[i];
}

double Solid::support(const Vector3& n) const {
  if (flat != nullptr) {
    double most = n.dot(corners[0]);
    for (std::size_t i = 1; i < corners.size(); ++i) most = std::max(most, n.dot(corners[i]));
    return most;
  }
  const double along = n.dot(axis), wide = rim * (n - along * axis).norm();
  if (cone) return n.dot(centre) + std::max(half_length * along, wide - half_length * along);
  return n.dot(centre) + half_length * std::abs(along) + wide;
}

Vector3 Solid::extreme(const Vector3& n) const {
  if (flat != nullptr) {
    std::size_t most = 0;
    for (std::size_t i = 1; i < corners.size(); ++i)
      if (n.dot(corners[i]) > n.dot(corners[most])) most = i;
    return corners[most];
  }
  const double along = n.dot(axis);
  const Vector3 wide = n - along * axis;
  const double width = wide.norm();
  const Vector3 side = width > 0 ? Vector3(rim / width * wide) : Vector3::Zero();
  if (cone) return 2 * half_length * along > rim * width ? tip() : Vector3(centre - half_length * axis + side);
  return centre + (along > 0 ? half_length : -half_length) * axis + side;
}

Vector3 Solid::middle() const {
  if (flat == nullptr) return centre;
  Vector3 sum = Vector3::Zero();
  for (const Vector3& c : corners) sum += c;
  return sum / static_cast<double>(corners.size());
}

namespace separation_parts {

/// Whether the arcs a1 a2 and -b1 -b2 on the unit sphere cross: only such edges can be what separates (Gregorius 2013).
/// `a` = a2 × a1.
bool arcs_cross(const Vector3& a, const Vector3& a1, const Vector3& a2, const Vector3& b1, const Vector3& b2) {
  const double cba = -b1.dot(a), dba = -b2.dot(a);
  if (cba * dba >= 0) return false;
  const Vector3 b = b2.cross(b1);
  const double adc = a1.dot(b), bdc = a2.dot(b);
  return adc * bdc < 0 && cba * bdc > 0;
}

/// A point of the first line where it is nearest to the second.
Vector3 nearest_on_line(const Vector3& p, const Vector3& along, const Vector3& q, const Vector3& other) {
  const double aa = along.dot(along), ab = along.dot(other), bb = other.dot(other), det = aa * bb - ab * ab;
  if (!(det > 0)) return p;
  const Vector3 d = q - p;
  return p + along * ((d.dot(along) * bb - d.dot(other) * ab) / det);
}

/// Where a shape is sharp or round around a direction n: there its support is n·point + radius |n across the axis|
/// (rim), or n is bound to n·axis = slope (line).
struct Feature {
  enum Kind { corner, line, rim } kind;
  Vector3 point, axis;
  double slope = 0, radius = 0;  // of a line: around it
};

/// Unit vector at right angles to the axis towards d; twice, for d may be nearly along it.
Vector3 square_to(const Vector3& axis, const Vector3& d) {
  const Vector3 once = (d - d.dot(axis) * axis).normalized();
  return (once - once.dot(axis) * axis).normalized();
}

struct Features {
  std::array<Feature, 48> at;
  int count = 0;
  void add(const Feature& f) {
    if (count < static_cast<int>(at.size())) at[count++] = f;
  }
};

Feature side_of(const Solid& s) {
  if (s.cone) return {Feature::line, s.tip(), s.axis, s.sin_side()};
  return {Feature::line, s.centre, s.axis, 0, s.rim};
}

/// Features of a core that can be what touches where its outward normal is about n.
void find_features(const Solid& s, const Vector3& n, double tolerance, Features& found) {
  found.count = 0;
  if (s.flat == nullptr) {
    const Vector3 end = s.half_length * s.axis;
    found.add(side_of(s));
    if (s.cone)
      found.add({Feature::corner, s.tip(), s.axis});
    else
      found.add({Feature::rim, s.centre + end, s.axis, 0, s.rim});
    found.add({Feature::rim, s.centre - end, s.axis, 0, s.rim});
    return;
  }
  const double most = s.support(n);
  double level = most - tolerance;
  const auto near = [&] { return std::ranges::count_if(s.corners, [&](const auto& c) { return n.dot(c) >= level; }); };
  for (int i = 0; i < 30 && near() > 10; ++i) level = (most + level) / 2;  // of fine hulls the nearest few
  for (const Vector3& c : s.corners)
    if (n.dot(c) >= level) found.add({Feature::corner, c, Vector3::Zero()});
  for (const Polyhedron::Edge& e : s.flat->edges) {
    const Vector3 &p = s.corners[e.ends[0]], &q = s.corners[e.ends[1]];
    if (n.dot(p) >= level && n.dot(q) >= level) found.add({Feature::line, p, (q - p).normalized()});
  }
}

/// D(n) = d·n - Σ r |n across axis| of up to two rims, and what Newton's method needs of it.
struct RimDistance {
  Vector3 d;
  std::array<const Feature*, 2> rims;
  double value(const Vector3& n, Vector3& gradient, Matrix3& hessian) const {
    double value = d.dot(n);
    gradient = d;
    hessian.setZero();
    for (const Feature* f : rims) {
      if (f == nullptr) continue;
      const Vector3 wide = n - n.dot(f->axis) * f->axis;
      const double length = std::max(wide.norm(), 1e-12);
      const Vector3 side = f->axis.cross(wide) / length;
      value -= f->radius * length;
      gradient -= f->radius / length * wide;
      hessian -= f->radius / length * side * side.transpose();
    }
    return value;
  }
};

/// Largest D over unit vectors, or over those with n·axis = slope of a line; from a start near it.
Vector3 farthest(const RimDistance& D, const Feature* line, double slope, Vector3 n) {
  if (line != nullptr) {
    n = slope * line->axis + std::sqrt(1 - slope * slope) * square_to(line->axis, n);
  }
  Vector3 gradient;
  Matrix3 hessian;
  for (int i = 0; i < 12; ++i) {
    const double value = D.value(n, gradient, hessian);
    const Vector3 u = line != nullptr ? Vector3(line->axis.cross(n).normalized()) : n.unitOrthogonal();
    const Vector3 w = n.cross(u);
    Vector3 turn;
    if (line != nullptr) {
      // On the circle n' = u c, n'' towards its centre: c n'' = -(n - slope axis).
      const double c = std::sqrt(1 - slope * slope);
      const double g = c * gradient.dot(u), h = c * c * u.dot(hessian * u) - gradient.dot(n - slope * line->axis);
      turn = std::clamp(-g / std::min(h, -1e-3 * std::abs(h) - 1e-300), -0.3, 0.3) * c * u;
    } else {
      const double gu = gradient.dot(u), gw = gradient.dot(w);
      const double a = u.dot(hessian * u) - value, b = u.dot(hessian * w), c = w.dot(hessian * w) - value;
      const double det = a * c - b * b;
      turn = a + c < 0 && det > 0 ? Vector3((-(c * gu - b * gw) * u - (a * gw - b * gu) * w) / det)
                                  : Vector3((gu * u + gw * w) / (std::abs(a) + std::abs(c) + 1e-300));
      const double length = turn.norm();
      if (length > 0.3) turn *= 0.3 / length;
    }
    if (!(turn.squaredNorm() > 1e-32)) break;
    // Never downhill: a long step may pass the top.
    Vector3 next = n;
    for (int half = 0; half < 8; ++half, turn /= 2) {
      next = (n + turn).normalized();
      if (line != nullptr) next = slope * line->axis + std::sqrt(1 - slope * slope) * square_to(line->axis, next);
      if (turn.squaredNorm() < 1e-12 || D.value(next, gradient, hessian) >= value) break;
    }
    n = next;
  }
  return n;
}

/// Offers the directions in which these two features can be what is nearest.
void offer_features(const Solid& A, const Solid& B, const Feature& f, const Feature& g, const Vector3& start,
                    Separation& best) {
  const Vector3 d = g.point - f.point;
  const double slope_f = f.slope, slope_g = -g.slope;  // of n, which points out of A and into B
  const auto on_rim = [](const Feature& rim, const Vector3& outward) {
    return Vector3(rim.point + rim.radius * (outward - outward.dot(rim.axis) * rim.axis).normalized());
  };
  if (f.kind == Feature::corner && g.kind == Feature::corner) {
    best.offer(A, B, d.normalized(), f.point);
  } else if (f.kind == Feature::corner && g.kind == Feature::line) {
    const Vector3 n = slope_g * g.axis + std::sqrt(1 - slope_g * slope_g) * square_to(g.axis, d);
    best.offer(A, B, n, f.point);
  } else if (f.kind == Feature::line && g.kind == Feature::corner) {
    const Vector3 n = slope_f * f.axis + std::sqrt(1 - slope_f * slope_f) * square_to(f.axis, d);
    best.offer(A, B, n, g.point - n * (-B.support(-n) - A.support(n)));
  } else if (f.kind == Feature::line && g.kind == Feature::line) {
    const double c = f.axis.dot(g.axis), det = 1 - c * c;
    if (det < 1e-16) return;
    const double x = (slope_f - c * slope_g) / det, y = (slope_g - c * slope_f) / det;
    const double rest = 1 - (x * x + y * y + 2 * x * y * c);
    if (rest < 0) return;
    const Vector3 normal = f.axis.cross(g.axis) / std::sqrt(det);
    for (double sign : {-1.0, 1.0}) {
      const Vector3 n = (x * f.axis + y * g.axis + sign * std::sqrt(rest) * normal).normalized();
      // The line that touches: of a cylinder or cone the one that faces n.
      const auto touching = [&](const Feature& line, const Solid& s, const Vector3& out, Vector3& p, Vector3& along) {
        const Vector3 side = (out - out.dot(line.axis) * line.axis).normalized();
        p = line.point + line.radius * side;
        along = s.flat == nullptr && s.cone ? Vector3(s.rim * side - 2 * s.half_length * s.axis) : line.axis;
      };
      Vector3 p, q, along_p, along_q;
      touching(f, A, n, p, along_p), touching(g, B, -n, q, along_q);
      best.offer(A, B, n, nearest_on_line(p, along_p, q, along_q));
    }
  } else if (f.kind == Feature::corner || g.kind == Feature::corner) {  // and a rim
    const Feature &rim = f.kind == Feature::rim ? f : g, &corner = f.kind == Feature::rim ? g : f;
    const Vector3 p = on_rim(rim, corner.point - rim.point);
    const Vector3 n = (corner.point - p).normalized() * (&rim == &f ? 1 : -1);
    best.offer(A, B, n, &rim == &f ? p : corner.point);
  } else {
    const Feature* line = f.kind == Feature::line ? &f : g.kind == Feature::line ? &g : nullptr;
    const RimDistance D{d, {f.kind == Feature::rim ? &f : nullptr, g.kind == Feature::rim ? &g : nullptr}};
    const Vector3 n = farthest(D, line, line == &f ? slope_f : slope_g, start);
    if (f.kind == Feature::rim)
      best.offer(A, B, n, on_rim(f, n));
    else
      best.offer(A, B, n, on_rim(g, -n) - n * (-B.support(-n) - A.support(n)));
  }
}

}  // namespace separation_parts

Separation separation_of_faces(const Solid& a, const Solid& b, double enough) {
  using namespace separation_parts;
  Separation best;
  const double lead = 1e-12 * std::max(a.size, b.size);  // a tie goes to the earlier: faces before edges
  const Vector3 nowhere = Vector3::Constant(NAN);        // faces touch in patches
  for (const Vector3& n : a.normals) {
    if (a.flat == nullptr) break;
    best.offer(a, b, n, nowhere, lead);
    if (best.distance > enough) return best;
  }
  for (const Vector3& n : b.normals) {
    if (b.flat == nullptr) break;
    best.offer(a, b, -n, nowhere, lead);
    if (best.distance > enough) return best;
  }
  if (a.flat == nullptr || b.flat == nullptr) {
    for (const Solid* s : {&a, &b}) {
      if (s->flat != nullptr) continue;
      if (!s->cone || s == &b) best.offer(a, b, s->axis, nowhere, lead);
      if (!s->cone || s == &a) best.offer(a, b, -s->axis, nowhere, lead);
    }
    if (a.flat == nullptr && b.flat == nullptr) offer_features(a, b, side_of(a), side_of(b), nowhere, best);
    return best;
  }
  const bool solids = a.normals.size() > 2 && b.normals.size() > 2;
  for (const Polyhedron::Edge& e : a.flat->edges) {
    const Vector3 arc = solids ? Vector3(a.normals[e.faces[1]].cross(a.normals[e.faces[0]])) : nowhere;
    for (const Polyhedron::Edge& f : b.flat->edges) {
      if (solids &&
          !arcs_cross(arc, a.normals[e.faces[0]], a.normals[e.faces[1]], b.normals[f.faces[0]], b.normals[f.faces[1]]))
        continue;
      const Vector3 &p = a.corners[e.ends[0]], &q = b.corners[f.ends[0]];
      const Vector3 along_a = a.corners[e.ends[1]] - p, along_b = b.corners[f.ends[1]] - q;
      const Vector3 cross = along_a.cross(along_b);
      const double length = cross.norm();
      if (!(length > 1e-8 * std::sqrt(along_a.squaredNorm() * along_b.squaredNorm()))) continue;
      Vector3 n = cross / length;
      if (solids) {
        if (n.dot(a.normals[e.faces[0]] + a.normals[e.faces[1]]) < 0) n = -n;
        // Of edges nearly side by side n is not exact: how far it separates is asked of all corners.
        if (n.dot(q - p) > best.distance + lead) best.offer(a, b, n, nearest_on_line(p, along_a, q, along_b), lead);
      } else {
        const Vector3 on_a = nearest_on_line(p, along_a, q, along_b);
        best.offer(a, b, n, on_a, lead);
        best.offer(a, b, -n, on_a, lead);
      }
      if (best.distance > enough) return best;
    }
  }
  return best;
}

void refine_separation(const btConvexShape& a, const btConvexShape& b, const btTransform& b_in_a, const Solid& A,
                       const Solid& B, Separation& best) {
  using namespace separation_parts;
  const double size = std::max(A.size, B.size);
  const Vector3 apart = B.middle() - A.middle();
  const btTransform origin = btTransform::getIdentity();
  const bool flat = A.flat != nullptr && B.flat != nullptr;
  // From some starts Bullet fails, or says less than there is: what it says is checked, and others are tried.
  const std::array<btVector3, 3> guesses{to_bullet(apart), to_bullet(best.normal), btVector3(0.3, -0.5, 0.8)};
  btGjkEpaSolver2::sResults result;
  const auto along = [&](const Vector3& n) { return -B.support(-n) - A.support(n); };
  const auto nearest = [&](const btTransform& at, Vector3& n) {
    for (const btVector3& guess : guesses) {
      if (!btGjkEpaSolver2::Distance(&a, origin, &b, at, guess, result)) continue;
      const Vector3 between = from_bullet(result.witnesses[1] - result.witnesses[0]);
      const double length = between.norm(), moved = (at.getOrigin() - b_in_a.getOrigin()).length();
      if (!(length > 0) || along(between / length) < length - moved - 1e-3 * size) continue;
      n = between / length;
      return length;
    }
    return 0.0;
  };
  Vector3 start = best.normal;
  if (!(nearest(b_in_a, start) > (flat ? 1e-10 : 1e-6) * size)) {
    // Overlapping, just touching or hardly apart. Where they just touch EPA may give any direction, a little apart the
    // direction is nearly the same, and deep only EPA sees one: what separates most is nearest to the answer.
    double most = along(start);
    const auto try_start = [&](const Vector3& n) {
      const double distance = along(n);
      if (std::abs(n.squaredNorm() - 1) < 1e-6 && distance > most) most = distance, start = n;
    };
    for (const btVector3& guess : guesses) {
      if (flat || !btGjkEpaSolver2::Penetration(&a, origin, &b, b_in_a, guess, result, /*usemargins=*/false)) continue;
      for (double sign : {-1.0, 1.0}) try_start(sign * from_bullet(result.normal).normalized());
    }
    btTransform shifted = b_in_a;
    shifted.setOrigin(b_in_a.getOrigin() + to_bullet(apart) * (1e-3 * size / std::max(apart.norm(), 1e-9 * size)));
    Vector3 n = start;
    nearest(shifted, n);
    try_start(n);
  }
  if (!(std::abs(start.squaredNorm() - 1) < 1e-6)) return;
  const Separation before = best;
  const Vector3 first = start;
  Features of_a, of_b;
  // The start may be off by some hundredths of a radian, or more: where the answer is elsewhere, features are looked up
  // again about that.
  for (int round = 0; round < 4; ++round) {
    const double tolerance = (flat && round > 0 ? 1e-4 : 0.03) * size;
    find_features(A, start, tolerance, of_a);
    find_features(B, -start, tolerance, of_b);
    for (int i = 0; i < of_a.count; ++i)
      for (int j = 0; j < of_b.count; ++j) offer_features(A, B, of_a.at[i], of_b.at[j], start, best);
    if ((!flat || round > 0) && (best.normal - start).squaredNorm() < 4e-4) break;
    start = best.normal;
  }
  best.offer(A, B, first, A.extreme(first), 1e-14 * size);  // features are exact: this may not win by rounding
  if (flat && best.distance < before.distance + 1e-12 * size) best = before;  // rounding is no direction
}

}  // namespace lithe::narrow
