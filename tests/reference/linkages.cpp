#include "tests/reference/linkages.h"

#include "joints/cylindrical_joint.h"
#include "joints/point_on_line_joint.h"
#include "joints/prismatic_joint.h"
#include "joints/revolute_joint.h"
#include "joints/spherical_joint.h"
#include "joints/universal_joint.h"

namespace lithe::test {
namespace {

const Vector3 kStill = Vector3::Zero();
Vector3 turned(const Vector3& r, double rate) { return rate * Vector3(-r.y(), r.x(), 0); }

/// Where circles about a and b meet, on the left of a -> b.
Vector3 meet(const Vector3& a, double from_a, const Vector3& b, double from_b) {
  const Vector3 d = b - a;
  const double l = d.norm(), x = (l * l + from_a * from_a - from_b * from_b) / (2 * l);
  const double y = std::sqrt(from_a * from_a - x * x);
  return a + x * d / l + y * Vector3(-d.y(), d.x(), 0) / l;
}

}  // namespace

std::string Drawing::name() const {
  std::string text;
  for (HingeAs h : hinges) text += "RCUS"[static_cast<int>(h)];
  text += '_';
  for (SlideAs s : slides) text += "PCL"[static_cast<int>(s)];
  return text;
}

Linkage slider_crank() {
  const double r = 0.15, l = 0.35, start = 0.6, speed = 9;
  const Vector3 O(0, 0, 0), P(r * std::cos(start), r * std::sin(start), 0);
  const Vector3 B(P.x() + std::sqrt(l * l - P.y() * P.y()), 0, 0);
  const Vector3 v = turned(P, speed), u(v.x() + v.y() * P.y() / (B.x() - P.x()), 0, 0);
  return {"slider-crank",
          {{"crank", O, P, 1, kStill, v}, {"rod", P, B, 1, v, u}, {"slider", B, B, 2, u, u}},
          {{-1, 0, O}, {0, 1, P}, {1, 2, B}},
          {{2, B, {1, 0, 0}}},
          1.6};
}

Linkage four_bar() {
  const double crank = 0.2, coupler = 0.5, rocker = 0.45, start = 0.8, speed = 9;
  const Vector3 O(0, 0, 0), D(0.55, 0, 0), P(crank * std::cos(start), crank * std::sin(start), 0);
  const Vector3 C = meet(P, coupler, D, rocker);
  return {"four-bar",
          {{"crank", O, P, 1, kStill, turned(P, speed)},
           {"coupler", P, C, 1, turned(P, speed), kStill},
           {"rocker", C, D, 1, kStill, kStill}},
          {{-1, 0, O}, {0, 1, P}, {1, 2, C}, {2, -1, D}},
          {},
          1.8};
}

Linkage scott_russell() {
  const double a = 0.3, start = 0.7, speed = 8;
  const Vector3 O(0, 0, 0), C(a * std::cos(start), a * std::sin(start), 0), A(2 * C.x(), 0, 0), B(0, 2 * C.y(), 0);
  const Vector3 vC = turned(C, speed), vA(2 * vC.x(), 0, 0), vB(0, 2 * vC.y(), 0);
  return {"scott-russell",
          {{"crank", O, C, 1, kStill, vC}, {"link", A, B, 1, vA, vB}, {"slider", A, A, 1, vA, vA}},
          {{-1, 0, O}, {0, 1, C}, {1, 2, A}},
          {{2, A, {1, 0, 0}}},
          1.7};
}

Linkage parallelogram() {
  const double start = 0.9, speed = 8, r = 0.25;
  const Vector3 O(0, 0, 0), D(0.6, 0, 0), r1(r * std::cos(start), r * std::sin(start), 0), v = turned(r1, speed);
  return {"parallelogram",
          {{"left", O, r1, 1, kStill, v}, {"coupler", r1, D + r1, 1, v, v}, {"right", D + r1, D, 1, v, kStill}},
          {{-1, 0, O}, {0, 1, r1}, {1, 2, D + r1}, {2, -1, D}},
          {},
          1.8};
}

/// Two crossed pairs above each other; its lower right foot slides.
Linkage scissor() {
  const double l = 0.4, start = 0.7;
  const double w = l * std::cos(start), h = l * std::sin(start);
  const Vector3 A(0, 0, 0), B(w, 0, 0), C(0, h, 0), D(w, h, 0), E(0, 2 * h, 0), F(w, 2 * h, 0);
  const Vector3 m1 = (A + D) / 2, m2 = (C + F) / 2;
  return {"scissor",
          {{"lower right", A, D, 1, kStill, kStill},
           {"lower left", B, C, 1, kStill, kStill},
           {"upper right", C, F, 1, kStill, kStill},
           {"upper left", D, E, 1, kStill, kStill}},
          {{-1, 0, A}, {0, 1, m1}, {1, 2, C}, {0, 3, D}, {2, 3, m2}},
          {{1, B, {1, 0, 0}}},
          0.15};
}

/// Four bars in space, opposite ones alike: lengths and twists with sin α / a = sin β / b (Bennett 1903). Consecutive
/// common normals meet on the hinges; tan(θ1/2) tan(θ2/2) = sin((β + α)/2) / sin((β - α)/2).
Linkage bennett() {
  const double a = 0.3, b = 0.4, alpha = 0.6, beta = std::asin(b * std::sin(alpha) / a), theta = 2, speed = 9;
  const double other = 2 * std::atan(std::sin((beta + alpha) / 2) / std::sin((beta - alpha) / 2) / std::tan(theta / 2));
  const double turns[] = {theta, other, -theta, -other};
  const double lengths[] = {a, b, a, b}, twists[] = {alpha, beta, alpha, beta};
  Matrix3 axes = rotation_about({1, 0, 0}, 0.5);
  std::vector<Vector3> P{Vector3::Zero()}, z;
  for (int i = 0; i < 4; ++i) {
    z.push_back(axes.col(2));
    axes = axes * about_z(turns[i]);
    P.push_back(P[i] + lengths[i] * axes.col(0));
    axes = axes * rotation_about({1, 0, 0}, twists[i]);
  }
  const Vector3 v = speed * z[0].cross(P[1] - P[0]);
  return {"bennett",
          {{"crank", P[0], P[1], 1, kStill, v},
           {"coupler", P[1], P[2], 1, v, kStill},
           {"rocker", P[2], P[3], 1, kStill, kStill}},
          {{-1, 0, P[0], z[0]}, {0, 1, P[1], z[1]}, {1, 2, P[2], z[2]}, {2, -1, P[3], z[3]}},
          {},
          1.6};
}

/// Six hinges on the edges of a cube, each across the next (R04); it falls.
Linkage bricard() {
  const Vector3 P[] = {{0, 0, 0}, {1, 0, 0}, {1, -1, 0}, {1, -1, 1}, {0, -1, 1}, {0, 0, 1}};
  const Vector3 axes[] = {Vector3::UnitY(), Vector3::UnitZ(), Vector3::UnitX()};
  Linkage linkage{"bricard", {}, {}, {}, 2};
  for (int i = 0; i < 5; ++i)
    linkage.links.push_back({"rod " + std::to_string(i + 1), P[i], P[i + 1], 1, kStill, kStill});
  for (int i = 0; i < 6; ++i) linkage.hinges.push_back({i - 1, i < 5 ? i : -1, P[i], axes[i % 3]});
  return linkage;
}

int freedoms_added(const Drawing& drawing) {
  int count = 0;
  for (HingeAs h : drawing.hinges) count += h == HingeAs::revolute ? 0 : h == HingeAs::spherical ? 2 : 1;
  for (SlideAs s : drawing.slides) count += s == SlideAs::prismatic ? 0 : s == SlideAs::cylindrical ? 1 : 3;
  return count;
}

std::vector<Drawing> all_drawings(const Linkage& linkage) {
  std::vector<Drawing> out{{}};
  for (std::size_t i = 0; i < linkage.hinges.size(); ++i) {
    std::vector<Drawing> longer;
    for (const Drawing& d : out)
      for (HingeAs h : {HingeAs::revolute, HingeAs::cylindrical, HingeAs::universal, HingeAs::spherical}) {
        longer.push_back(d);
        longer.back().hinges.push_back(h);
      }
    out = longer;
  }
  for (const auto& slide : linkage.slides) {
    // The end of a link that turns as it slides is on a line; a block may be held in all ways.
    const auto& link = linkage.links[slide.link];
    std::vector<SlideAs> ways{SlideAs::on_line};
    if (link.a == link.b) ways = {SlideAs::prismatic, SlideAs::cylindrical, SlideAs::on_line};
    std::vector<Drawing> longer;
    for (const Drawing& d : out)
      for (SlideAs s : ways) {
        longer.push_back(d);
        longer.back().slides.push_back(s);
      }
    out = longer;
  }
  return out;
}

Scene draw(const Linkage& linkage, const Drawing& drawing, const Matrix3& turn,
           const std::vector<Vector6>& velocities) {
  return Scene(turn * Vector3(0, -9.81, 0), [&](SystemGraph& graph) {
    std::vector<Part> parts;
    for (std::size_t i = 0; i < linkage.links.size(); ++i) {
      const auto& link = linkage.links[i];
      const Vector3 d = link.b - link.a, middle = turn * (link.a + link.b) / 2;
      Matrix3 R = Matrix3::Identity();
      Vector3 inertia = Vector3::Constant(link.mass * 1e-3);
      if (d.norm() > 0) {
        const Vector3 across = std::hypot(d.x(), d.y()) > 0 ? Vector3(-d.y(), d.x(), 0) : Vector3(0, 1, 0);
        R.col(0) = d.normalized(), R.col(1) = across.normalized(), R.col(2) = R.col(0).cross(R.col(1));
        const double spin = link.mass * d.squaredNorm() / 300, swing = link.mass * d.squaredNorm() / 12;
        inertia = {spin, swing, swing};
      }
      const Vector6 V = velocities.empty() ? Vector6::Zero().eval() : velocities[i];
      Vector3 v = V.head<3>(), w = V.tail<3>();
      if (velocities.empty()) {
        v = (link.va + link.vb) / 2;
        if (d.norm() > 0) w = d.cross(link.vb - link.va) / d.squaredNorm();
      }
      parts.emplace_back(graph, link.name, link.mass, inertia, middle, turn * R, turn * v, turn * w);
    }
    const auto marker = [&](int link, const Vector3& at, const Matrix3& axes) {
      return link < 0 ? graph.ground().marker(turn * at, turn * axes) : parts[link].at(turn * at, turn * axes);
    };
    for (std::size_t i = 0; i < linkage.hinges.size(); ++i) {
      const auto& h = linkage.hinges[i];
      const std::string name = "hinge " + std::to_string(i + 1);
      // A universal joint turns about x_A and y_B: x_A lies along the hinge, y_B across, not alike in any two.
      const Matrix3 frame = h.axis == Vector3::UnitZ() ? about_z(0) : axes_with_z(h.axis);
      const Vector3 shaft = frame * (about_z(0.4 + static_cast<double>(i)) * Vector3(1, 0, 0));
      const Matrix3 axes = drawing.hinges[i] == HingeAs::universal ? axes_with_z(shaft, h.axis) : frame;
      const Marker A = marker(h.A, h.at, axes), B = marker(h.B, h.at, axes);
      switch (drawing.hinges[i]) {
        case HingeAs::revolute:
          graph.add<RevoluteJoint>(name, {A, B});
          break;
        case HingeAs::cylindrical:
          graph.add<CylindricalJoint>(name, {A, B});
          break;
        case HingeAs::universal:
          graph.add<UniversalJoint>(name, {A, B});
          break;
        case HingeAs::spherical:
          graph.add<SphericalJoint>(name, {A, B});
          break;
      }
    }
    for (std::size_t i = 0; i < linkage.slides.size(); ++i) {
      const auto& s = linkage.slides[i];
      const std::string name = "slide " + std::to_string(i + 1);
      const Matrix3 axes = axes_with_z(s.direction, {0, 0, 1});
      const Marker A = marker(-1, s.at, axes), B = marker(s.link, s.at, axes);
      switch (drawing.slides[i]) {
        case SlideAs::prismatic:
          graph.add<PrismaticJoint>(name, {A, B});
          break;
        case SlideAs::cylindrical:
          graph.add<CylindricalJoint>(name, {A, B});
          break;
        case SlideAs::on_line:
          graph.add<PointOnLineJoint>(name, {A, B});
          break;
      }
    }
  });
}

std::vector<Vector6> start_velocities(const Linkage& linkage) {
  const Scene scene = draw(linkage, all_drawings(linkage).front(), Matrix3::Identity(), {});
  std::vector<Vector6> out;
  for (const auto& slice : scene.system.layout().bodies()) {
    const Vector4 e = scene.state.q.segment<4>(slice.q + 3);
    Vector6 V;
    V << scene.state.v.segment<3>(slice.v), rotation_matrix(e) * scene.state.v.segment<3>(slice.v + 3);
    out.push_back(V);
  }
  return out;
}

}  // namespace lithe::test
