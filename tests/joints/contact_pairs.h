#pragma once

#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "bodies/rigid_body.h"
#include "engine/model/ground.h"
#include "engine/model/system_graph.h"
#include "joints/contact/bullet_detector.h"
#include "joints/contact/contact.h"

/// Pairs of shapes in poses whose contact is known by construction.
namespace lithe::test {

struct ContactPose {
  Vector3 p = Vector3::Zero();
  Matrix3 R = Matrix3::Identity();
};
inline ContactPose operator*(const ContactPose& a, const ContactPose& b) { return {a.p + a.R * b.p, a.R * b.R}; }
inline ContactPose turned(const Vector3& axis, double angle, const Vector3& p = Vector3::Zero()) {
  return {p, Eigen::AngleAxisd(angle, axis).toRotationMatrix()};
}

/// Poses as a simulation would give them.
class GivenPoses final : public ContactPoses {
 public:
  explicit GivenPoses(int count) : markers_(count) {}
  void set(int collider, const ContactPose& pose) {
    markers_[collider].p = pose.p, markers_[collider].R = pose.R;
    markers_[collider].r.setZero();
  }
  const MarkerKinematics& collider(int collider) const override { return markers_[collider]; }
  void node(int, int, MarkerKinematics&) const override {}
  std::span<const double> deformation(int) const override { return {}; }

 private:
  std::vector<MarkerKinematics> markers_;
};

/// Shapes on bodies of their own, and what finds their contacts.
class ContactScene {
 public:
  explicit ContactScene(const std::vector<Shape>& shapes)
      : poses(static_cast<int>(shapes.size())),
        reach(shapes.size(), 0),
        contact(colliders(graph_, shapes), {.law = Sensing{}}),
        detector(make_bullet_detector(contact)) {}
  const std::vector<ContactPoint>& find() {
    points.clear();
    detector->find(poses, reach, points);
    return points;
  }

 private:
  static std::vector<Collider> colliders(SystemGraph& graph, const std::vector<Shape>& shapes) {
    std::vector<Collider> result;
    for (std::size_t i = 0; i < shapes.size(); ++i)
      result.push_back({graph.add<RigidBody>("body " + std::to_string(i)).marker(), shapes[i]});
    return result;
  }
  SystemGraph graph_;

 public:
  GivenPoses poses;
  std::vector<double> reach;
  Contact contact;
  std::unique_ptr<ContactDetector> detector;
  std::vector<ContactPoint> points;
};

using Random = std::mt19937_64;
inline double uniform(Random& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}
inline ContactPose random_pose(Random& random, double distance) {
  std::normal_distribution<double> normal;
  const Eigen::Quaterniond q(normal(random), normal(random), normal(random), normal(random));
  ContactPose pose{Vector3::Zero(), q.normalized().toRotationMatrix()};
  pose.p = pose.R * Vector3(distance, 0, 0);
  return pose;
}

/// A below B: the normal is +z. `place` fills the poses for a depth (negative: a gap) and tells where they touch (x and
/// y count); NaN: in a patch.
struct ContactPair {
  std::string name;
  Shape a, b;
  double deepest;  // for which `place` is right, m
  std::function<Vector3(double depth, Random&, ContactPose& a, ContactPose& b)> place;
};

inline std::vector<ContactPair> contact_pairs() {
  const Vector3 X = Vector3::UnitX(), Y = Vector3::UnitY(), Z = Vector3::UnitZ(), patch = Vector3::Constant(NAN);
  const Shape ball = shape::sphere(0.3), cube = shape::box(Vector3::Ones()), rod = shape::capsule(0.2, 1.0),
              drum = shape::cylinder(0.2, 1.0), cone = shape::cone(0.2, 1.0), plane = shape::half_space();
  std::vector<Vector3> corners;
  for (int i = 0; i < 8; ++i) corners.emplace_back(i & 1 ? .5 : -.5, i & 2 ? .5 : -.5, i & 4 ? .5 : -.5);
  const Shape hull = shape::convex_hull(corners);
  const ContactPose lying = turned(Y, M_PI / 2);  // axis z to x

  const auto beside = [](Random& r) { return Vector3(uniform(r, -.1, .1), uniform(r, -.1, .1), 0); };
  const auto above = [=](double height) {
    return [=](double depth, Random& r, ContactPose& a, ContactPose& b) {
      a = {}, b = {};
      b.p = beside(r) + (height - depth) * Z;
      return b.p;
    };
  };
  const auto face = [=](double height, const ContactPose& upper) {
    return [=](double depth, Random& r, ContactPose& a, ContactPose& b) {
      a = {};
      b = turned(Z, uniform(r, 0, 6), beside(r) + (height - depth) * Z) * upper;
      return patch;
    };
  };
  const auto crossed = [=](double height, const ContactPose& lower) {  // two lines, the lower along x
    return [=](double depth, Random& r, ContactPose& a, ContactPose& b) {
      const double turn = uniform(r, 0.5, 2.5);
      const Vector3 p = beside(r);
      a = lower, b = turned(Z, turn, p + (height - depth) * Z) * lying;
      return Vector3(p[0] - p[1] * std::cos(turn) / std::sin(turn), 0, 0);
    };
  };
  // Lowest corner of a tilted cube onto z = height.
  const auto corner_down = [=](double height) {
    return [=](double depth, Random& r, ContactPose& a, ContactPose& b) {
      a = {}, b = random_pose(r, 0);
      Vector3 lowest = Vector3::Zero();
      for (const Vector3& c : corners)
        if ((b.R * c).z() < lowest.z()) lowest = b.R * c;
      const Vector3 touch = beside(r) + (height - depth) * Z;
      b.p = touch - lowest;
      return touch;
    };
  };
  const auto edges = [=](double depth, Random& r, ContactPose& a, ContactPose& b) {
    const double turn = uniform(r, -.5, .5);
    const Vector3 p = beside(r);
    a = turned(X, M_PI / 4);
    b = turned(Z, turn, p + (std::sqrt(2.0) - depth) * Z) * turned(Y, M_PI / 4);
    return Vector3(p[0] + p[1] * std::tan(turn), 0, 0);
  };
  // The +x end of something along its z axis dips; `low`: of a tilt, the lowest point.
  const auto dipped = [=](double height, const ContactPose& lower, double wide, bool round, double least, double most,
                          double turn = 3) {
    return [=](double depth, Random& r, ContactPose& a, ContactPose& b) {
      const double tilt = uniform(r, least, most), s = std::sin(tilt), c = std::cos(tilt);
      const Vector3 low(0.5 * c - (round ? 0 : wide * s), 0, -0.5 * s - (round ? wide : wide * c));
      const ContactPose spin = turned(Z, uniform(r, -turn, turn));
      const Vector3 touch = (height == 0.5 ? beside(r) : Vector3(uniform(r, -.1, .1), 0, 0)) + (height - depth) * Z;
      a = lower;
      b = ContactPose{touch - spin.R * low, spin.R} * turned(Y, tilt) * lying;
      return touch;
    };
  };
  const auto ridge = [=](double height, const ContactPose& lower) {
    return [=](double depth, Random& r, ContactPose& a, ContactPose& b) {
      a = lower, b = {};
      b.p = Vector3(uniform(r, -.1, .1), 0, height - depth);
      return b.p;
    };
  };
  const auto on_top = [=](double height) {
    return [=](double depth, Random&, ContactPose& a, ContactPose& b) {
      a = {}, b = {};
      b.p.z() = height - depth;
      return b.p;
    };
  };
  const auto on_tip = [=](double depth, Random& r, ContactPose& a, ContactPose& b) {
    a = {}, b = {};
    b.p = beside(r) + (1 - depth) * Z;
    return Vector3(Vector3::Zero());
  };
  const auto cone_rim = [=](double height) {  // its tip along +x and up
    return [=](double depth, Random& r, ContactPose& a, ContactPose& b) {
      const double tilt = uniform(r, .1, 1.4);
      const ContactPose spin = turned(Z, uniform(r, 0, 6));
      const Vector3 touch = beside(r) + (height - depth) * Z;
      const ContactPose up = turned(Y, -tilt) * lying;
      a = {}, b = ContactPose{touch, spin.R} * up;
      b.p -= b.R * Vector3(.2, 0, -.5);
      return touch;
    };
  };
  // The cone's side is level: its tip points along +x, its rim is as low.
  const auto cone_side = [=](double height) {
    return [=](double depth, Random& r, ContactPose& a, ContactPose& b) {
      const double half = std::atan2(0.2, 1.0);
      a = {};
      b = turned(Z, uniform(r, 0, 6), beside(r)) * turned(Y, half) * lying;
      const double low = std::min((b.R * Vector3(0, 0, 0.5)).z(), 0.0);
      b.p.z() = height - depth - low;
      return patch;
    };
  };
  const auto corner_up = [=](const ContactPose& lower, double height) {  // a cube's corner down on what is pointed
    return [=](double depth, Random& r, ContactPose& a, ContactPose& b) {
      const double level = std::acos(1 / std::sqrt(3.0));
      a = lower;
      b = turned(Z, uniform(r, 0, 6), Vector3(0, 0, height + std::sqrt(0.75) - depth)) *
          turned(Vector3(1, -1, 0).normalized(), level);
      return Vector3(Vector3::Zero());
    };
  };
  const ContactPose ridge_up = turned(X, M_PI / 4),
                    tip_up = turned(Vector3(1, -1, 0).normalized(), std::acos(1 / std::sqrt(3.0)));
  const double edge = std::sqrt(0.5), tip = std::sqrt(0.75);
  return {
      {"plane, sphere", plane, ball, .1, above(0.3)},
      {"sphere, sphere", ball, ball, .1, on_top(0.6)},
      {"plane, box corner", plane, cube, .1, corner_down(0)},
      {"plane, hull corner", plane, hull, .1, corner_down(0)},
      {"plane, capsule", plane, rod, .1, dipped(0, {}, .2, true, .1, 1.4)},
      {"plane, cylinder rim", plane, drum, .1, dipped(0, {}, .2, false, .1, 1.4)},
      {"plane, cone rim", plane, cone, .1, cone_rim(0)},
      {"box face, cone rim", cube, cone, .1, cone_rim(0.5)},
      {"box face, sphere", cube, ball, .1, above(0.8)},
      {"hull face, sphere", hull, ball, .1, above(0.8)},
      {"capsule, sphere", rod, ball, .1, ridge(0.5, lying)},
      {"cylinder side, sphere", drum, ball, .1, ridge(0.5, lying)},
      {"capsule, capsule", rod, rod, .1, crossed(0.4, lying)},
      {"cylinder, cylinder crossed", drum, drum, .1, crossed(0.4, lying)},
      {"box face, box face", cube, cube, .1, face(1, {})},
      {"hull face, hull face", hull, hull, .1, face(1, {})},
      {"box face, box corner", cube, cube, .1, corner_down(0.5)},
      {"box edge, box edge", cube, cube, .1, edges},
      {"hull edge, hull edge", hull, hull, .1, edges},
      {"box corner, box corner apart", cube, cube, 0, corner_up(tip_up, tip)},
      {"box edge, box corner apart", cube, cube, 0, corner_up(ridge_up, edge)},
      {"box face, capsule end", cube, rod, .1, dipped(0.5, {}, .2, true, .1, 1.4)},
      {"box edge, capsule", cube, rod, .1, crossed(edge + .2, ridge_up)},
      {"box face, cylinder rim", cube, drum, .1, dipped(0.5, {}, .2, false, .1, 1.4)},
      {"box face, cylinder standing", cube, drum, .1, face(1, {})},
      {"box face, cylinder lying", cube, drum, .1, face(0.7, lying)},
      {"box edge, cylinder side", cube, drum, .05, crossed(edge + .2, ridge_up)},
      {"box edge, cylinder rim", cube, drum, .01, dipped(edge, ridge_up, .2, false, .5, 1.0, .5)},
      {"cylinder side, cylinder rim", drum, drum, .01, dipped(.2, lying, .2, false, .5, 1.0, .5)},
      {"cylinder side, box corner", drum, cube, .05, corner_up(lying, .2)},
      {"cone tip, box face", cone, cube, .05, on_tip},
      {"box face, cone side", cube, cone, .05, cone_side(0.5)},
      {"cone tip, box corner apart", cone, cube, 0, corner_up({}, .5)},
  };
}

}  // namespace lithe::test
