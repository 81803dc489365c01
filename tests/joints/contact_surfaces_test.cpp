#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>

#include "tests/joints/contact_grounds.h"

namespace lithe::test::contact_surfaces_test {
namespace {

using narrow::Touch;

std::vector<Touch> touches_of(const Shape& mesh, const Shape& other, const Vector3& p, const Matrix3& R, double reach,
                              const Vector3& at = Vector3::Zero(), const Matrix3& turn = Matrix3::Identity()) {
  std::vector<Touch> touches;
  narrow::mesh_convex(mesh.data(), to_bullet(at, turn), *other.data().convex, to_bullet(p, R), reach, touches);
  return touches;
}
std::vector<Touch> touches_of(const Shape& mesh, const Shape& other, const Vector3& p, double reach) {
  return touches_of(mesh, other, p, Matrix3::Identity(), reach);
}

TEST(ContactSurfaces, a_ball_on_a_flat_mesh_feels_a_plane_over_faces_edges_and_corners) {
  const Shape ground = terrain(8, [](double, double) { return 0.0; }), ball = shape::sphere(0.13);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> across(-0.3, 0.3), part(0, 1);
  std::set<std::uint64_t> names;
  for (int k = 0; k < 400; ++k) {
    Vector3 c{across(random), across(random), 0.13 + 0.02 * (part(random) - 0.8)};
    if (k % 4 == 1) c[0] = 0.1 * std::round(10 * c[0]);                                      // over an edge
    if (k % 4 == 2) c[1] = c[0];                                                             // over a diagonal
    if (k % 4 == 3) c[0] = 0.1 * std::round(10 * c[0]), c[1] = 0.1 * std::round(10 * c[1]);  // over a corner
    if (k % 20 == 3) c[2] = -0.05;                                                           // deep
    for (bool tilted : {false, true}) {
      const Matrix3 R = tilted ? kTilt : Matrix3::Identity();
      const Vector3 p = tilted ? kPlace : Vector3(Vector3::Zero());
      const auto touches = touches_of(ground, ball, p + R * c, R, 0.01, p, R);
      ASSERT_EQ(touches.size(), 1u) << c.transpose();
      EXPECT_LT((touches[0].normal - R.col(2)).norm(), 1e-14);
      EXPECT_NEAR(touches[0].gap, c[2] - 0.13, 1e-15);
      const Vector3 place = R.transpose() * (touches[0].position - p);
      EXPECT_LT((place - Vector3(c[0], c[1], 0.5 * (c[2] - 0.13))).norm(), 1e-15);
      EXPECT_NEAR(touches[0].curvature, 1 / 0.13, 1e-12);
      names.insert(touches[0].feature);
    }
  }
  EXPECT_EQ(names.size(), 1u);  // it rolls on: one point
}

TEST(ContactSurfaces, a_ball_on_bumpy_ground_touches_where_the_ground_is_nearest) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> bump(-0.06, 0.06), across(-0.3, 0.3), up(-0.02, 0.25);
  const Shape ground = terrain(8, [&](double, double) { return bump(random); });
  const Shape::Data& data = ground.data();
  const double radius = 0.12;
  int several = 0, leaning = 0, below = 0;
  for (int k = 0; k < 2000; ++k) {
    const Vector3 c{across(random), across(random), up(random)};
    double least = 1e300, height = 0;  // of the ground under the centre
    for (const auto& t : data.triangles) {
      const Vector3 &a = data.points[t[0]], &b = data.points[t[1]], &d = data.points[t[2]];
      least = std::min(least, distance_to_triangle(c, a, b, d));
      const Vector3 n = (b - a).cross(d - a);
      const Vector3 foot{c[0], c[1], a[2] - (n[0] * (c[0] - a[0]) + n[1] * (c[1] - a[1])) / n[2]};
      if (distance_to_triangle(foot, a, b, d) < 1e-12) height = foot[2];
    }
    const double gap = (c[2] < height ? -least : least) - radius;
    const auto touches = touches_of(ground, shape::sphere(radius), c, 0.01);
    ASSERT_EQ(touches.empty(), gap >= 0.01) << c.transpose();
    if (touches.empty()) continue;
    const auto nearest =
        std::min_element(touches.begin(), touches.end(), [](const Touch& a, const Touch& b) { return a.gap < b.gap; });
    EXPECT_NEAR(nearest->gap, gap, 1e-12) << c.transpose();
    std::set<std::uint64_t> names;
    for (const Touch& touch : touches) {
      EXPECT_NEAR(touch.normal.norm(), 1, 1e-12);
      EXPECT_GT(touch.normal[2], 0);  // out of the ground
      // The centre lies over the point by radius and gap.
      EXPECT_LT((touch.position + (radius + 0.5 * touch.gap) * touch.normal - c).norm(), 1e-12);
      EXPECT_GE(touch.gap, gap - 1e-12);
      names.insert(touch.feature);
    }
    EXPECT_EQ(names.size(), touches.size());
    several += touches.size() > 1;
    below += c[2] < height;
    const double lean = nearest->normal.dot(Vector3::UnitZ());
    leaning += lean < 0.999;
  }
  EXPECT_GT(several, 100);
  EXPECT_GT(leaning, 100);
  EXPECT_GT(below, 30);
}

TEST(ContactSurfaces, a_ball_that_rolls_over_a_ridge_turns_round_its_edge) {
  // Roof of 30 degrees either side along y.
  const double slope = std::tan(M_PI / 6);
  const Shape roof = terrain(8, [&](double x, double) { return -slope * std::abs(x); });
  for (double angle = -0.9; angle <= 0.9; angle += 0.05) {  // of the centre about the ridge, from the vertical
    const Vector3 c = 0.2 * Vector3(std::sin(angle), 0, std::cos(angle)) + Vector3(0, 0.03, 0);
    const auto touches = touches_of(roof, shape::sphere(0.2), c, 0.01);
    const double over = std::abs(angle) - M_PI / 6;  // beyond the edge: on the slope
    ASSERT_EQ(touches.size(), 1u) << angle;
    const double lean = over > 0 ? std::copysign(M_PI / 6, angle) : angle;
    EXPECT_LT((touches[0].normal - Vector3(std::sin(lean), 0, std::cos(lean))).norm(), 1e-13) << angle;
    EXPECT_NEAR(touches[0].gap, over > 0 ? 0.2 * std::cos(over) - 0.2 : 0, 1e-14);
  }
}

TEST(ContactSurfaces, a_box_lies_on_its_four_corners_on_a_flat_mesh) {
  const Shape ground = terrain(8, [](double, double) { return 0.0; }), box = shape::box({0.33, 0.21, 0.1});
  for (double depth : {-2e-3, 1e-4, 0.03, 0.07}) {
    const Matrix3 turn = rotation_about({0, 0, 1}, 0.4);
    const Vector3 c{0.013, -0.021, 0.05 - depth};
    const auto touches = touches_of(ground, box, kPlace + kTilt * c, kTilt * turn, 0.01, kPlace, kTilt);
    if (depth < 0.05) {
      ASSERT_EQ(touches.size(), 4u) << depth;
    }
    std::set<std::uint64_t> names;
    for (double sx : {-1.0, 1.0})
      for (double sy : {-1.0, 1.0}) {
        const Vector3 corner = c + turn * Vector3(sx * 0.165, sy * 0.105, -0.05);
        const auto there = std::find_if(touches.begin(), touches.end(), [&](const Touch& t) {
          const Vector3 place = kTilt.transpose() * (t.position - kPlace);
          return (place - Vector3(corner[0], corner[1], 0.5 * corner[2])).norm() < 1e-14;
        });
        ASSERT_NE(there, touches.end()) << depth;
        EXPECT_NEAR(there->gap, -depth, 1e-15);
        EXPECT_LT((there->normal - kTilt.col(2)).norm(), 1e-14);
        names.insert(there->feature);
      }
    EXPECT_EQ(names.size(), 4u);
  }
}

TEST(ContactSurfaces, a_box_that_hangs_over_a_table_is_held_up_and_not_pushed_aside) {
  for (int cells : {1, 4}) {
    const Shape top = table({0.5, 0.4, 0.05}, cells), box = shape::box({0.4, 0.2, 0.1});
    for (double depth : {-1e-5, 1e-5, 5e-3})
      for (double angle : {0.0, 0.3}) {
        const Vector3 c{0.48, 0.03, 0.1 - depth};
        const auto touches = touches_of(top, box, c, rotation_about({0, 0, 1}, angle), 1e-3);
        double least = 1, most = -1;
        for (const Touch& t : touches) {
          EXPECT_LT((t.normal - Vector3::UnitZ()).norm(), 1e-12) << cells << ' ' << depth << ' ' << angle;
          EXPECT_NEAR(t.gap, -depth, 1e-14);
          least = std::min(least, t.position[0]), most = std::max(most, t.position[0]);
        }
        EXPECT_GE(touches.size(), 4u);
        EXPECT_NEAR(most, 0.5, 1e-12);  // over the edge of the table
        EXPECT_LT(least, 0.33);
      }
  }
}

TEST(ContactSurfaces, edges_of_a_box_and_a_mesh_cross_in_one_point) {
  const double slope = 0.8;
  const Shape roof = terrain(2, [&](double x, double) { return -slope * std::abs(x); });
  const Shape box = shape::box({0.3, 0.3, 0.3});
  // The box stands on an edge across the ridge; its other edges are far.
  for (double angle : {0.0, 0.2, 0.9})
    for (double depth : {-1e-3, 1e-6, 2e-3}) {
      const Matrix3 R = rotation_about({0, 0, 1}, angle) * rotation_about({1, 0, 0}, M_PI / 4);  // edge along own x
      const Vector3 c{0, 0.02, 0.15 * std::sqrt(2.0) - depth};
      const auto touches = touches_of(roof, box, c, R, 5e-3);
      ASSERT_EQ(touches.size(), 1u) << angle;
      EXPECT_LT((touches[0].normal - Vector3::UnitZ()).norm(), 1e-12);
      EXPECT_NEAR(touches[0].gap, -depth, 1e-14);
    }
}

TEST(ContactSurfaces, round_bodies_lie_and_stand_on_a_flat_mesh) {
  const Shape ground = terrain(8, [](double, double) { return 0.0; });
  const Matrix3 lying = rotation_about({0, 1, 0}, M_PI / 2);
  struct Case {
    Shape shape;
    Vector3 p;
    Matrix3 R;
    std::size_t least;
  };
  const double slant = std::atan2(0.1, 0.3);
  for (const Case& c : {Case{shape::cylinder(0.1, 0.3), {0.02, 0.01, 0.099}, lying, 2},
                        Case{shape::cylinder(0.1, 0.3), {0.02, 0.01, 0.149}, Matrix3::Identity(), 4},
                        Case{shape::capsule(0.1, 0.3), {0.02, 0.01, 0.099}, lying, 2},
                        Case{shape::capsule(0.1, 0.3), {0.02, 0.01, 0.249}, Matrix3::Identity(), 1},
                        Case{shape::cone(0.1, 0.3), {0.02, 0.01, 0.149}, Matrix3::Identity(), 4},
                        Case{shape::cone(0.1, 0.3),
                             {0.02, 0.01, 0.15 * std::sin(slant) - 1e-3},
                             rotation_about({0, 1, 0}, M_PI / 2 + slant),
                             2}}) {
    const auto touches = touches_of(ground, c.shape, c.p, c.R, 1e-3);
    EXPECT_GE(touches.size(), c.least);
    double deepest = 1;
    for (const Touch& t : touches) {
      EXPECT_LT((t.normal - Vector3::UnitZ()).norm(), 1e-14);
      EXPECT_LT(t.gap, 1e-3);
      deepest = std::min(deepest, t.gap);
    }
    EXPECT_NEAR(deepest, -1e-3, 1e-9);
  }
}

/// How far a box may fall straight down before it meets a height field: corners over triangles, corners under faces,
/// edges that cross as seen from above.
double clearance(const Shape& box, const Vector3& p, const Matrix3& R, const Shape::Data& ground) {
  const Polyhedron& body = *box.data().polyhedron;
  std::vector<Vector3> corners;
  for (const Vector3& c : body.corners) corners.push_back(p + R * c);
  double least = 1e300;
  const auto cross = [](const Vector3& a, const Vector3& b) { return a[0] * b[1] - a[1] * b[0]; };
  for (const auto& t : ground.triangles) {
    const Vector3 x[3] = {ground.points[t[0]], ground.points[t[1]], ground.points[t[2]]};
    const Vector3 n = (x[1] - x[0]).cross(x[2] - x[0]);
    for (const Vector3& c : corners) {
      bool over = true;
      for (int i = 0; i < 3; ++i) over = over && cross(x[(i + 1) % 3] - x[i], c - x[i]) >= 0;
      if (over) least = std::min(least, n.dot(c - x[0]) / n[2]);
    }
    for (int i = 0; i < 3; ++i) {
      double low = -1e300, high = 1e300;  // of the box above this corner of the ground
      for (std::size_t f = 0; f < body.normals.size(); ++f) {
        const Vector3 m = R * body.normals[f], on = corners[body.loop(static_cast<int>(f))[0]];
        const double z = x[i][2] + (m.dot(on - x[i])) / m[2];
        (m[2] < 0 ? low : high) = m[2] < 0 ? std::max(low, z) : std::min(high, z);
      }
      if (low <= high) least = std::min(least, low - x[i][2]);
      const Vector3 along = x[(i + 1) % 3] - x[i];
      for (const auto& edge : body.edges) {
        const Vector3 start = corners[edge.ends[0]], across = corners[edge.ends[1]] - start;
        const double s = cross(start - x[i], across) / cross(along, across);
        const double u = cross(start - x[i], along) / cross(along, across);
        if (s >= 0 && s <= 1 && u >= 0 && u <= 1)
          least = std::min(least, start[2] + u * across[2] - x[i][2] - s * along[2]);
      }
    }
  }
  return least;
}

TEST(ContactSurfaces, a_falling_box_meets_bumpy_ground_when_it_must_and_never_before) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int k = 0; k < 600; ++k) {
    const double rough = k % 2 ? 0.05 : 0.005;
    const Shape ground = terrain(8, [&](double, double) { return rough * unit(random); });
    const Shape box =
        k % 3 == 0 ? shape::convex_hull(
                         {{0.1, 0, 0}, {-0.1, 0, 0}, {0, 0.12, 0}, {0, -0.12, 0}, {0.02, 0, 0.1}, {0, 0.02, -0.13}})
                   : shape::box({0.22, 0.17, 0.13});
    const Matrix3 R =
        rotation_exp(Vector3{k % 5 ? 3 * unit(random) : 1e-3, k % 5 ? 3 * unit(random) : 0, unit(random)});
    Vector3 p{0.1 * unit(random), 0.1 * unit(random), 0.5};
    p[2] -= clearance(box, p, R, ground.data());
    for (double height : {1e-7, -1e-7, -2e-4}) {
      const Vector3 at = p + height * Vector3::UnitZ();
      const auto touches = touches_of(ground, box, at, R, 1e-5);
      ASSERT_FALSE(touches.empty()) << k << ' ' << height;
      double least = 1, fall = 1;  // gap; the same straight down
      std::set<std::uint64_t> names;
      for (const Touch& t : touches) {
        EXPECT_GT(t.normal[2], 0) << k;
        least = std::min(least, t.gap), fall = std::min(fall, t.gap / t.normal[2]);
        names.insert(t.feature);
      }
      EXPECT_EQ(names.size(), touches.size());
      if (height > -1e-4) {
        EXPECT_NEAR(fall, height, 1e-12) << k;
      } else {
        EXPECT_LT(least, -2e-6) << k;
        EXPECT_GT(least, 2 * height) << k;
      }
    }
  }
}

TEST(ContactSurfaces, round_bodies_hang_over_edges) {
  // A cylinder across a ridge: the distance of two lines that cross.
  const Shape roof = terrain(4, [&](double x, double) { return -0.7 * std::abs(x); });
  const Shape cylinder = shape::cylinder(0.05, 0.3), capsule = shape::capsule(0.05, 0.3);
  for (double depth : {-1e-3, 1e-3})
    for (double angle : {0.0, 0.5}) {
      const Matrix3 R = rotation_about({0, 0, 1}, angle) * rotation_about({0, 1, 0}, M_PI / 2);
      for (const Shape& shape : {cylinder, capsule}) {
        const auto touches = touches_of(roof, shape, {0.01, 0.03, 0.05 - depth}, R, 3e-3);
        ASSERT_EQ(touches.size(), 1u) << angle;
        EXPECT_NEAR(touches[0].gap, -depth, 1e-7);
        EXPECT_LT((touches[0].normal - Vector3::UnitZ()).norm(), 1e-4);
      }
    }
  // Standing half over the edge of a table: held up, not pushed aside.
  const Shape top = table({0.5, 0.5, 0.05}, 3);
  for (const Shape& shape : {cylinder, shape::cone(0.05, 0.3)}) {
    const auto touches = touches_of(top, shape, {0.49, 0.01, 0.2 - 1e-4}, 1e-3);
    EXPECT_GE(touches.size(), 4u);
    for (const Touch& t : touches) {
      EXPECT_LT((t.normal - Vector3::UnitZ()).norm(), 1e-6);
      EXPECT_NEAR(t.gap, -1e-4, 1e-8);
    }
  }
}

TEST(ContactSurfaces, a_ball_in_a_corner_feels_floor_and_walls) {
  // The inside of a box: its triangles turned about.
  const Shape outside = table({0.5, 0.5, 0.5}, 2);
  auto triangles = outside.data().triangles;
  for (auto& t : triangles) std::swap(t[1], t[2]);
  const Shape room = shape::mesh(outside.data().points, triangles);
  const auto touches = touches_of(room, shape::sphere(0.2), Vector3(0.301, 0.299, -0.302), 5e-3);
  ASSERT_EQ(touches.size(), 3u);
  Vector3 gaps;
  for (const Touch& t : touches) {
    int axis;
    EXPECT_NEAR(t.normal.cwiseAbs().maxCoeff(&axis), 1, 1e-15);
    gaps[axis] = t.gap;
  }
  EXPECT_LT((gaps - Vector3(-1e-3, 1e-3, -2e-3)).norm(), 1e-15);
}

TEST(ContactSurfaces, a_mesh_lies_on_a_plane_by_its_corners) {
  const Shape block = table({0.3, 0.2, 0.1}, 5);
  const btTransform plane = to_bullet(kPlace, kTilt);
  for (double depth : {-5e-4, 0.01, 0.15}) {
    std::vector<Touch> touches;
    narrow::mesh_plane(plane, block.data(), to_bullet(kPlace + kTilt * Vector3(1, 2, 0.1 - depth), kTilt), 1e-3,
                       touches);
    std::size_t expected = 0;
    for (const Vector3& x : block.data().points) expected += x[2] + 0.1 - depth < 1e-3;
    EXPECT_EQ(touches.size(), expected);
    double least = 1;
    for (const Touch& t : touches) {
      least = std::min(least, t.gap);
      EXPECT_LT((t.normal - kTilt.col(2)).norm(), 1e-14);
    }
    EXPECT_NEAR(least, -depth, 1e-14);
  }
  std::vector<Touch> none;
  narrow::mesh_plane(plane, block.data(), to_bullet(kPlace + kTilt * Vector3(0, 0, 0.2), kTilt), 1e-3, none);
  EXPECT_TRUE(none.empty());
}

}  // namespace
}  // namespace lithe::test::contact_surfaces_test
