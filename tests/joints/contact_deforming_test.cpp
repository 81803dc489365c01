// Deforming surfaces: where they touch, by which nodes, and how many of those are looked at.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>

#include "tests/joints/contact_grounds.h"

namespace lithe::test::contact_deforming_test {
namespace {

/// Colliders at known places; the nodes of the surfaces are wherever they are put.
class Placed final : public ContactPoses {
 public:
  struct Body {
    MarkerKinematics k;
    std::vector<Vector3> nodes;
    std::vector<double> eta;
  };
  std::vector<Body> bodies;
  mutable int asked = 0;

  int add(const Vector3& p, const Matrix3& R = Matrix3::Identity()) {
    Body& body = bodies.emplace_back();
    body.k.p = p, body.k.R = R;
    return static_cast<int>(bodies.size()) - 1;
  }
  const MarkerKinematics& collider(int i) const override { return bodies[i].k; }
  void node(int i, int marker, MarkerKinematics& out) const override {
    ++asked;
    out.p = bodies[i].nodes.at(static_cast<std::size_t>(marker - 100));
  }
  std::span<const double> deformation(int i) const override { return bodies[i].eta; }

  /// Where a side says that it is touched.
  Vector3 place(const ContactSide& side) const {
    Vector3 x = Vector3::Zero();
    for (int k = 0; k < side.node_count; ++k)
      x += side.weights[k] * bodies[side.collider].nodes.at(side.nodes[k] - 100);
    return x;
  }
};

/// A flat block with a fine top, that bends along x by u_z = η x².
struct Slab {
  Shape shape;
  std::vector<Vector3> points;

  explicit Slab(int n = 10, bool known_reach = true) : shape(make(n, known_reach)), points(shape.data().points) {}
  static Shape make(int n, bool known_reach) {
    const Shape block = table({0.5, 0.2, 0.02}, n);
    static const char body = 0;  // only its address counts
    std::vector<Marker> nodes;
    for (std::size_t i = 0; i < block.data().points.size(); ++i)
      nodes.push_back({reinterpret_cast<const Body*>(&body), static_cast<int>(i) + 100});
    const auto& points = block.data().points;
    return shape::surface(nodes, points, block.data().triangles,
                          known_reach ? VectorX(VectorX::Constant(1, 0.25)) : VectorX());
  }
  int add_to(Placed& world, const Vector3& p, const Matrix3& R, double eta) const {
    const int i = world.add(p, R);
    for (const Vector3& x : points) world.bodies[i].nodes.push_back(p + R * (x + eta * x[0] * x[0] * Vector3::UnitZ()));
    world.bodies[i].eta = {eta};
    return i;
  }
};

std::vector<ContactPoint> points_of(const Placed& world, int surface, const Slab& slab, int other, const Shape& shape,
                                    double reach) {
  std::vector<ContactPoint> points;
  narrow::surface_contacts(world, surface, slab.shape.data(), other, shape.data(), reach, points);
  std::set<std::uint64_t> names;
  for (const ContactPoint& p : points) {
    EXPECT_EQ(p.A.collider, std::min(surface, other));
    EXPECT_EQ(p.B.collider, std::max(surface, other));
    EXPECT_LT(p.gap, reach);
    EXPECT_TRUE(names.insert(p.feature).second);
    // The place that the weights tell is the place on the surface.
    for (const ContactSide& side : {p.A, p.B}) {
      if (side.node_count == 0) continue;
      double sum = 0;
      for (int k = 0; k < side.node_count; ++k) {
        sum += side.weights[k];
        EXPECT_GE(side.weights[k], 0);
      }
      EXPECT_NEAR(sum, 1, 1e-14);
      const Vector3 on_surface = p.position + (side.collider == p.A.collider ? -0.5 : 0.5) * p.gap * p.normal;
      EXPECT_LT((world.place(side) - on_surface).norm(), 1e-13);
    }
  }
  return points;
}

TEST(DeformingSurfaces, nodes_of_a_bent_slab_touch_the_ground_each_by_its_depth) {
  for (bool known : {true, false})
    for (bool surface_first : {true, false}) {
      const Slab slab(10, known);
      Placed world;
      const Matrix3 ground_axes = rotation_about({0, 1, 0}, 0.3);
      int ground = -1;
      if (!surface_first) ground = world.add({0, 0, 0}, ground_axes);
      const Matrix3 R = ground_axes * rotation_about({0, 0, 1}, 0.5);
      const int body = slab.add_to(world, ground_axes * Vector3(0.2, 0.1, 0.0212), R, -0.04);
      if (surface_first) ground = world.add({0, 0, 0}, ground_axes);
      const auto points = points_of(world, body, slab, ground, shape::half_space(), 1e-3);
      std::size_t expected = 0;
      for (const Vector3& x : world.bodies[body].nodes) expected += ground_axes.col(2).dot(x) < 1e-3;
      EXPECT_GT(expected, 20u);
      EXPECT_EQ(points.size(), expected);
      for (const ContactPoint& p : points) {
        const ContactSide& side = surface_first ? p.A : p.B;
        EXPECT_NEAR(p.gap, ground_axes.col(2).dot(world.place(side)), 1e-15);
        EXPECT_LT((p.normal - (surface_first ? -1 : 1) * ground_axes.col(2)).norm(), 1e-15);
        EXPECT_EQ(side.node_count, 1);
      }
    }
}

TEST(DeformingSurfaces, a_ball_touches_a_bent_slab_where_it_is_nearest_now) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> along(-0.45, 0.45), across(-0.18, 0.18);
  int leaning = 0;
  for (bool known : {true, false}) {
    const Slab slab(10, known);
    for (int k = 0; k < 100; ++k) {
      const double eta = k % 2 ? -0.2 : 0.15, x = along(random);
      Placed world;
      const int body = slab.add_to(world, kPlace, kTilt, eta);
      const Vector3 c = kPlace + kTilt * Vector3(x, across(random), 0.02 + eta * x * x + 0.04);
      const int ball = world.add(c);
      double least = 1e300;
      const auto& nodes = world.bodies[body].nodes;
      for (const auto& t : slab.shape.data().triangles)
        least = std::min(least, distance_to_triangle(c, nodes[t[0]], nodes[t[1]], nodes[t[2]]));
      const auto points = points_of(world, body, slab, ball, shape::sphere(0.041), 2e-3);
      ASSERT_FALSE(points.empty());
      double gap = 1;
      for (const ContactPoint& p : points) {
        gap = std::min(gap, p.gap);
        EXPECT_LT((p.position + (0.041 + 0.5 * p.gap) * p.normal - c).norm(), 1e-13);
        leaning += std::abs(p.normal.dot(kTilt.col(2))) < 0.9999;
      }
      EXPECT_NEAR(gap, least - 0.041, 1e-13);
    }
  }
  EXPECT_GT(leaning, 50);
}

TEST(DeformingSurfaces, a_box_is_carried_by_the_nodes_and_faces_of_a_slab) {
  const Slab slab;
  Placed world;
  const int box = world.add({0.03, 0.02, 0.02 + 0.05 - 1e-4}, rotation_about({0, 0, 1}, 0.2));
  const int body = slab.add_to(world, {0, 0, 0}, Matrix3::Identity(), 0);
  const auto points = points_of(world, body, slab, box, shape::box({0.3, 0.14, 0.1}), 1e-3);
  int corners = 0;
  for (const ContactPoint& p : points) {
    EXPECT_LT((p.normal + Vector3::UnitZ()).norm(), 1e-12);  // out of the box
    EXPECT_NEAR(p.gap, -1e-4, 1e-14);
    corners += p.B.node_count == 3 && p.B.weights[0] < 0.999 && p.B.weights[1] < 0.999 && p.B.weights[2] < 0.999;
  }
  EXPECT_EQ(corners, 4);
  EXPECT_GT(points.size(), 10u);
  // Bent upwards in the middle of its length, it touches there alone.
  Placed bent;
  const int other = bent.add({0, 0, 0.02 + 0.05 - 1e-4});
  const int arch = slab.add_to(bent, {0, 0, 0}, Matrix3::Identity(), -0.3);
  for (const ContactPoint& p : points_of(bent, arch, slab, other, shape::box({0.3, 0.14, 0.1}), 0)) {
    EXPECT_LT(std::abs(p.position[0]), 0.02);
    EXPECT_NEAR(p.gap, -1e-4, 1e-12);
  }
}

TEST(DeformingSurfaces, slabs_and_meshes_meet_node_on_face_and_edge_across_edge) {
  const Slab slab;
  for (double eta : {0.0, -0.1}) {
    // Above another slab, turned by a right angle: both bend.
    Placed world;
    const int lower = slab.add_to(world, kPlace, kTilt, eta);
    const int upper = slab.add_to(world, kPlace + kTilt * Vector3(0.013, 0.017, 0.04 - 5e-4),
                                  kTilt * rotation_about({0, 0, 1}, M_PI / 2), -eta);
    std::vector<ContactPoint> points;
    for (const auto& [first, second] : {std::pair{lower, upper}, {upper, lower}}) {
      points = points_of(world, first, slab, second, slab.shape, 1e-3);
      int below = 0, on_faces = 0, crossings = 0;
      for (const ContactPoint& p : points) {
        const int nodes = p.A.node_count + p.B.node_count;
        EXPECT_TRUE(nodes == 4 || nodes == 6) << nodes;
        ++(nodes == 4 ? on_faces : crossings);
        EXPECT_GT(p.normal.dot(kTilt.col(2)), 0.98);  // up, out of the lower
        EXPECT_NEAR(p.normal.dot(world.place(p.B) - world.place(p.A)), p.gap, 1e-14);
        EXPECT_NEAR(p.gap, -5e-4, eta == 0 ? 1e-14 : 2e-3);
        below += p.gap < 0;
      }
      EXPECT_GT(below, 3);
      EXPECT_GT(on_faces, 8) << eta;
      if (eta == 0) {  // the edges of bent ones bend apart
        EXPECT_GT(crossings, 0);
      }
    }
  }
  // On a peak of stiff ground the mesh's own corner touches.
  const Shape peak = terrain(4, [](double x, double y) { return std::hypot(x, y) < 0.01 ? 0.03 : 0.0; });
  Placed world;
  const int ground = world.add(kPlace, kTilt);
  const int body = slab.add_to(world, kPlace + kTilt * Vector3(0.012, 0.013, 0.05 - 1e-3), kTilt, 0);
  const auto points = points_of(world, body, slab, ground, peak, 1e-4);
  ASSERT_EQ(points.size(), 1u);
  EXPECT_NEAR(points[0].gap, -1e-3, 1e-14);
  EXPECT_LT((points[0].normal - kTilt.col(2)).norm(), 1e-13);
  EXPECT_EQ(points[0].B.node_count, 3);
  // Flat ground carries it by its nodes.
  Placed flat;
  const int floor = flat.add(kPlace, kTilt);
  const int plate = slab.add_to(flat, kPlace + kTilt * Vector3(0, 0, 0.02 - 1e-3), kTilt, 0);
  const auto on_floor = points_of(flat, plate, slab, floor, terrain(16, [](double, double) { return 0.0; }), 1e-4);
  EXPECT_GE(on_floor.size(), 121u);
  for (const ContactPoint& p : on_floor) {
    EXPECT_NEAR(p.gap, -1e-3, 1e-14);
    EXPECT_LT((p.normal - kTilt.col(2)).norm(), 1e-13);
  }
}

TEST(DeformingSurfaces, only_nodes_that_may_be_near_are_looked_at) {
  const Slab coarse(10), fine(60);
  for (const Slab* slab : {&coarse, &fine}) {
    Placed world;
    const int body = slab->add_to(world, kPlace, kTilt, 1e-3);
    const int far = world.add(kPlace + kTilt * Vector3(0, 0, 0.1), kTilt);
    const int near = world.add(kPlace + kTilt * Vector3(0.01, 0.01, 0.0205), kTilt);
    world.asked = 0;
    for (const Shape& other : {shape::sphere(0.05), shape::box({0.1, 0.1, 0.1})})
      EXPECT_TRUE(points_of(world, body, *slab, far, other, 1e-3).empty());
    Placed::Body& floor = world.bodies[far];
    floor.k.p = kPlace - kTilt * Vector3(0, 0, 0.03);
    EXPECT_TRUE(points_of(world, body, *slab, far, shape::half_space(), 1e-3).empty());
    EXPECT_TRUE(points_of(world, body, *slab, far, terrain(16, [](double, double) { return 0.0; }), 1e-3).empty());
    EXPECT_EQ(world.asked, 0);
    EXPECT_FALSE(points_of(world, body, *slab, near, shape::sphere(0.0006), 1e-4).empty());
    EXPECT_LT(world.asked, 30);
  }
}

}  // namespace
}  // namespace lithe::test::contact_deforming_test
