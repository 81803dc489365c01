// Meshes on meshes: where two surfaces of triangles touch, against boxes as boxes and by construction.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "tests/joints/contact_pairs.h"
#include "tests/support/mesh_shapes.h"

namespace lithe::test::contact_meshes_test {
namespace {

const Vector3 Z = Vector3::UnitZ();

/// Points of two shapes, the second at `b`; names are unique, normals unit.
std::vector<ContactPoint> points_between(ContactScene& scene, const ContactPose& a, const ContactPose& b) {
  scene.poses.set(0, a), scene.poses.set(1, b);
  const auto points = scene.find();
  std::set<std::uint64_t> names;
  for (const ContactPoint& p : points) {
    EXPECT_TRUE(names.insert(p.feature).second);
    EXPECT_NEAR(p.normal.norm(), 1, 1e-14);
  }
  return points;
}
const ContactPoint& deepest(const std::vector<ContactPoint>& points) {
  return *std::ranges::min_element(points, {}, &ContactPoint::gap);
}

TEST(ContactMeshes, boxes_of_triangles_touch_where_boxes_do) {
  const Vector3 one(1, 0.8, 0.6), two(0.5, 0.9, 0.7);
  ContactScene boxes({shape::box(one), shape::box(two)}), meshes({box_mesh(one), box_mesh(two)});
  boxes.reach = {2, 2}, meshes.reach = {1e-4, 1e-4};
  Random random(1);
  int crossed = 0, several = 0;
  for (int k = 0; k < 1000; ++k) {
    const ContactPose a = random_pose(random, 0.2);
    ContactPose b = a * random_pose(random, 1);
    if (k % 4 == 0)  // face on face
      b = a * turned(Z, uniform(random, 0, 6), {uniform(random, -.2, .2), uniform(random, -.2, .2), 1});
    for (const double depth : {-1e-5, 1e-7, 1e-5}) {
      for (int round = 0; round < 4; ++round) {  // along their normal to that depth
        const ContactPoint near = deepest(points_between(boxes, a, b));
        b.p -= (near.gap + depth) * near.normal;
        // Aside from where corners are nearest to corners and edges.
        if (round == 0) b.p += near.normal.cross(Vector3(uniform(random, -.1, .1), uniform(random, -.1, .1), 0.03));
      }
      const ContactPoint expected = deepest(points_between(boxes, a, b));
      ASSERT_NEAR(expected.gap, -depth, 1e-12);
      const auto found = points_between(meshes, a, b);
      // Apart, corners nearest to edges and corners have no point: they do not touch before they overlap.
      if (found.empty() && depth < 0) continue;
      ASSERT_FALSE(found.empty()) << k << ' ' << depth;
      // Apart, normals of edges near to corners are those of faces: 1e-5 of a distance, a hundredth of a direction.
      EXPECT_NEAR(deepest(found).gap, -depth, depth < 0 ? 1e-11 : 1e-12) << k;
      int touching = 0;
      for (const ContactPoint& p : found) {
        if (p.gap > std::abs(depth)) continue;
        EXPECT_LT((p.normal - expected.normal).norm(), depth < 0 ? 1e-2 : 1e-9) << k << ' ' << depth << ' ' << p.gap;
        ++touching;
      }
      crossed += touching == 1, several += touching > 2;
    }
  }
  EXPECT_GT(crossed, 300);
  EXPECT_GT(several, 200);
}

TEST(ContactMeshes, a_box_lies_on_its_four_corners_and_hangs_over_an_edge) {
  ContactScene scene({box_mesh({1, 0.8, 0.1}), box_mesh({0.4, 0.2, 0.1})});
  scene.reach = {1e-4, 1e-4};
  const ContactPose place{{0.3, -0.2, 0.5}, Eigen::AngleAxisd(0.7, Vector3(1, 2, 0.5).normalized()).matrix()};
  for (const double depth : {-1e-5, 1e-9, 1e-5, 1e-3})
    for (const double angle : {0.0, 0.4})
      for (const double x : {0.02, 0.3, 0.45}) {  // inside; flush with the edge, or over it; over it
        const ContactPose upper = turned(Z, angle, {x, 0.03, 0.1 - depth});
        const auto points = points_between(scene, place, place * upper);
        double least_x = 1, most_x = -1, least_y = 1, most_y = -1;
        for (const ContactPoint& p : points) {
          EXPECT_LT((p.normal - place.R.col(2)).norm(), 1e-12) << depth << ' ' << angle << ' ' << x;
          EXPECT_NEAR(p.gap, -depth, 1e-14);
          const Vector3 local = place.R.transpose() * (p.position - place.p);
          least_x = std::min(least_x, local.x()), most_x = std::max(most_x, local.x());
          least_y = std::min(least_y, local.y()), most_y = std::max(most_y, local.y());
        }
        EXPECT_GE(points.size(), 4u) << depth << ' ' << angle << ' ' << x;
        // The patch reaches as far as the box, or to the edge.
        const double half_x = 0.2 * std::cos(angle) + 0.1 * std::sin(angle);
        EXPECT_NEAR(least_x, x - half_x, 1e-12);
        EXPECT_NEAR(most_x, std::min(0.5, x + half_x), 1e-12);
        EXPECT_NEAR(most_y - least_y, 0.2 * std::cos(angle) + 0.4 * std::sin(angle), x + half_x > 0.5 ? 0.1 : 1e-12);
      }
  // On one of its own size: corner on corner.
  ContactScene twins({box_mesh({1, 1, 1}), box_mesh({1, 1, 1})});
  for (const double depth : {1e-9, 1e-5, 1e-3}) {
    const auto points = points_between(twins, place, place * ContactPose{{0, 0, 1 - depth}});
    EXPECT_EQ(points.size(), 4u);
    for (const ContactPoint& p : points) {
      EXPECT_LT((p.normal - place.R.col(2)).norm(), 1e-12);
      EXPECT_NEAR(p.gap, -depth, 1e-14);
    }
  }
}

TEST(ContactMeshes, what_overlaps_by_little_upwards_is_not_pushed_aside) {
  // A tenth of their faces over each other: edges lie across each other by 0.1 m sideways, by `depth` upwards.
  ContactScene scene({box_mesh({1, 1, 1}), box_mesh({1, 1, 1})});
  for (const double depth : {1e-9, 1e-5, 1e-3})
    for (const double turn : {0.0, 0.02}) {
      const auto points = points_between(scene, {}, turned(Z, turn, {0.9, 0.9, 1 - depth}));
      EXPECT_GE(points.size(), 3u);
      for (const ContactPoint& p : points) {
        EXPECT_LT((p.normal - Z).norm(), 1e-12) << depth << ' ' << turn << ' ' << p.gap;
        EXPECT_NEAR(p.gap, -depth, 1e-14);
      }
    }
}

TEST(ContactMeshes, edges_cross_in_one_point_each) {
  ContactScene tetrahedra({tetrahedron_mesh(1, 0.6), tetrahedron_mesh(1, 0.6, true)}),
      ridges({ridges_mesh(4), ridges_mesh(4)});
  tetrahedra.reach = ridges.reach = {1e-3, 1e-3};
  for (const double depth : {-1e-3, 1e-7, 2e-3}) {
    for (const double turn : {0.3, 1.2, M_PI / 2, 2.5}) {
      const auto points = points_between(tetrahedra, {}, turned(Z, turn, {0.1, 0.05, -depth}));
      ASSERT_EQ(points.size(), 1u) << depth << ' ' << turn;
      EXPECT_LT((points[0].normal - Z).norm(), 1e-14);
      EXPECT_NEAR(points[0].gap, -depth, 1e-15);
      // Where the lines cross from above: (s, 0) = (0.1, 0.05) + r (cos, sin).
      EXPECT_NEAR(points[0].position.x(), 0.1 - 0.05 / std::tan(turn), 1e-13);
      EXPECT_NEAR(points[0].position.y(), 0, 1e-13);
    }
    // Two ridges upside down on two ridges: four crossings, the valleys stay apart.
    const ContactPose down = turned(Z, M_PI / 2, {0, 0, -depth}) * turned(Vector3::UnitX(), M_PI);
    const auto points = points_between(ridges, {}, down);
    ASSERT_EQ(points.size(), 4u) << depth;
    for (const ContactPoint& p : points) {
      EXPECT_LT((p.normal - Z).norm(), 1e-14);
      EXPECT_NEAR(p.gap, -depth, 1e-14);
      EXPECT_NEAR(std::abs(p.position.x()), 1, 1e-13);
      EXPECT_NEAR(std::abs(p.position.y()), 1, 1e-13);
    }
  }
}

}  // namespace
}  // namespace lithe::test::contact_meshes_test
