#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "engine/base/error.h"
#include "tests/joints/contact_pairs.h"

namespace lithe::test::contact_shapes_test {
namespace {

const Vector3 kX = Vector3::UnitX(), kZ = Vector3::UnitZ();

const ContactPoint& deepest(const std::vector<ContactPoint>& points) {
  return *std::ranges::min_element(points, {}, &ContactPoint::gap);
}

std::set<std::uint64_t> features(const std::vector<ContactPoint>& points) {
  std::set<std::uint64_t> names;
  for (const ContactPoint& p : points) names.insert(p.feature);
  return names;
}

bool same(const std::vector<ContactPoint>& a, const std::vector<ContactPoint>& b) {
  return std::ranges::equal(a, b, [](const ContactPoint& p, const ContactPoint& q) {
    return p.A.collider == q.A.collider && p.B.collider == q.B.collider && p.position == q.position &&
           p.normal == q.normal && p.gap == q.gap && p.curvature == q.curvature && p.feature == q.feature;
  });
}

/// Every pair of convex shapes in 400 poses 10 m from the origin, either of them first: depth and gap to 5e-15 m of the
/// construction, the normal to 1e-14 where the shapes overlap or face each other, none missed.
TEST(Contact, OfConvexShapesIsAsDeepAndAsDirectedAsGeometryHasIt) {
  Random random(3);
  for (const ContactPair& pair : contact_pairs())
    for (bool swapped : {false, true}) {
      SCOPED_TRACE(pair.name + (swapped ? ", swapped" : ""));
      ContactScene scene({swapped ? pair.b : pair.a, swapped ? pair.a : pair.b});
      scene.reach = {0.1, 0.05};
      for (int i = 0; i < 200; ++i) {
        double depth = std::pow(10.0, uniform(random, -6, -1));
        if (i % 4 == 0) depth = std::pow(10.0, uniform(random, -16, -6));
        if (i % 8 == 0) depth = 0;
        if (depth > pair.deepest || i % 2 == 0) depth = -std::max(depth, pair.deepest == 0 ? 1e-6 : 0);
        ContactPose a, b;
        const Vector3 touch = pair.place(depth, random, a, b);
        const ContactPose common = random_pose(random, 10);
        scene.poses.set(swapped, common * a);
        scene.poses.set(!swapped, common * b);
        ASSERT_FALSE(scene.find().empty()) << "depth " << depth;
        const ContactPoint& p = deepest(scene.points);
        const Vector3 truth = (swapped ? -1 : 1) * common.R.col(2);
        EXPECT_NEAR(p.gap, -depth, 8e-15);
        // Where corners are apart their distance gives the normal.
        EXPECT_NEAR(scene.detector->gap(scene.poses, 0, 1, 0.15), p.gap, 0);
        const double slack = 2e-14 + (pair.deepest == 0 ? 1e-14 / std::abs(depth) : 0);
        EXPECT_LT((p.normal - truth).norm(), slack) << "depth " << depth;
        if (touch.allFinite()) {
          const Vector3 off = p.position - common.p - common.R * touch;
          EXPECT_LT((off - off.dot(truth) * truth).norm(), slack) << "depth " << depth;
        }
        for (const ContactPoint& q : scene.points) EXPECT_LT(q.gap, 0.15);
        if (HasFailure()) return;
      }
    }
}

/// Of two convex bodies: the distance, and the least depth, change no faster than they move; whichever is named first.
TEST(Contact, GapChangesNoFasterThanShapesMove) {
  Random random(9);
  std::vector<Vector3> cloud;
  for (int i = 0; i < 30; ++i) cloud.push_back(random_pose(random, 0.4).p.cwiseProduct(Vector3(1, 0.7, 1.3)));
  const std::vector<Shape> shapes{shape::sphere(0.3),        shape::box({0.8, 0.6, 1}), shape::convex_hull(cloud),
                                  shape::capsule(0.15, 0.6), shape::cylinder(0.3, 0.7), shape::cone(0.4, 0.8)};
  const double step = 4e-3;
  for (std::size_t i = 0; i < shapes.size(); ++i)
    for (std::size_t j = i; j < shapes.size(); ++j)
      for (int way = 0; way < 4; ++way) {
        SCOPED_TRACE(std::to_string(i) + ", " + std::to_string(j));
        ContactScene scene({shapes[i], shapes[j]}), swapped({shapes[j], shapes[i]});
        const ContactPose a = random_pose(random, 0.1), direction = random_pose(random, 1);
        ContactPose b = random_pose(random, 0.25);
        double last = NAN;
        for (double along = -1.2; along < 1.2; along += step) {
          const ContactPose at{b.p + along * direction.p, b.R};
          scene.poses.set(0, a), scene.poses.set(1, at);
          swapped.poses.set(1, a), swapped.poses.set(0, at);
          const double gap = scene.detector->gap(scene.poses, 0, 1, 0.5);
          EXPECT_NEAR(gap, swapped.detector->gap(swapped.poses, 0, 1, 0.5), 1e-12);
          EXPECT_FALSE(std::abs(gap - last) > step + 1e-12) << "at " << along << ", gap " << gap << " after " << last;
          last = gap;
          if (HasFailure()) break;
        }
      }
}

TEST(Contact, OfABoxAtRestIsItsFourCornersWhetherJustApartOrJustIn) {
  const Shape cube = shape::box({1, 1, 1}), small = shape::box({0.5, 0.4, 0.3}), slab = shape::box({4, 4, 1});
  std::vector<Vector3> corners;
  for (int i = 0; i < 8; ++i) corners.emplace_back(i & 1 ? .25 : -.25, i & 2 ? .2 : -.2, i & 4 ? .15 : -.15);
  for (const Shape& upper : {small, shape::convex_hull(corners)})
    for (const Shape& lower : {cube, slab, shape::half_space()}) {
      const double top = lower.kind() == Shape::Kind::half_space ? 0 : 0.5;
      ContactScene scene({lower, upper});
      scene.reach = {1e-3, 1e-3};
      std::set<std::uint64_t> names;
      for (double gap : {0.0, 1e-16, -1e-16, 1e-12, -1e-12, 1e-6, -1e-6, 1e-3, -1e-3})
        for (double lean : {0.0, 1e-15, -1e-12, 1e-6}) {
          scene.poses.set(0, {});
          scene.poses.set(1, turned(kX, lean, {0.1, 0.2, top + 0.15 + gap}));
          ASSERT_EQ(scene.find().size(), 4u) << gap << ' ' << lean;
          Vector3 middle = Vector3::Zero();
          for (const ContactPoint& p : scene.points) {
            const double arm = p.position.y() - 0.2;
            EXPECT_NEAR(p.gap, gap + lean * arm, 1e-15 + lean * lean);
            EXPECT_EQ((p.normal - kZ).norm() <= 2 * std::abs(lean), true);
            EXPECT_NEAR(std::abs(p.position.x() - 0.1), 0.25, 1e-6);
            EXPECT_EQ(p.curvature, 0);
            middle += p.position / 4;
          }
          EXPECT_LT((middle - Vector3(0.1, 0.2, top + gap / 2)).norm(), 1e-6);
          if (names.empty()) names = features(scene.points);
          EXPECT_EQ(names, features(scene.points));
        }
    }
}

TEST(Contact, OfEqualBoxesStackedFlushIsTheirFourCorners) {
  const Shape cube = shape::box({1, 1, 1});
  ContactScene scene({cube, cube});
  scene.reach = {1e-3, 1e-3};
  Random random(5);
  std::set<std::uint64_t> names;
  for (int i = 0; i < 100; ++i) {
    scene.poses.set(0, {});
    scene.poses.set(1, turned(kZ, uniform(random, -1e-9, 1e-9), Vector3(uniform(random, -1e-9, 1e-9), 0, 1)));
    ASSERT_EQ(scene.find().size(), 4u);
    if (i == 0) names = features(scene.points);
    EXPECT_EQ(names, features(scene.points));
    for (const ContactPoint& p : scene.points) EXPECT_NEAR(p.gap, 0, 1e-15);
  }
}

TEST(Contact, OfBoxesTurnedByAnEighthIsTheOctagonTheyShare) {
  const Shape cube = shape::box({1, 1, 1});
  ContactScene scene({cube, cube});
  scene.reach = {1e-3, 1e-3};
  scene.poses.set(0, {});
  scene.poses.set(1, turned(kZ, M_PI / 4, {0, 0, 1 - 1e-4}));
  ASSERT_EQ(scene.find().size(), 8u);
  for (const ContactPoint& p : scene.points) {
    EXPECT_NEAR(p.gap, -1e-4, 1e-15);
    EXPECT_NEAR(p.position.head<2>().norm(), 0.5 / std::cos(M_PI / 8), 1e-15);
  }
  const auto names = features(scene.points);
  EXPECT_EQ(names.size(), 8u);
  scene.poses.set(1, turned(kZ, M_PI / 4 + 0.01, {0.01, 0.02, 1 - 1e-4}));
  scene.find();
  EXPECT_EQ(features(scene.points), names);
}

TEST(Contact, OfACylinderIsAtItsRimWhereItStandsAndAtItsEndsWhereItLies) {
  for (const Shape& lower : {shape::half_space(), shape::box({4, 4, 1})}) {
    const double top = lower.kind() == Shape::Kind::half_space ? 0 : 0.5;
    ContactScene scene({lower, shape::cylinder(0.2, 1)});
    scene.reach = {1e-3, 1e-3};
    scene.poses.set(0, {});
    scene.poses.set(1, {{0.3, 0, top + 0.5}});
    ASSERT_GE(scene.find().size(), 4u);
    Vector3 middle = Vector3::Zero();
    for (const ContactPoint& p : scene.points) {
      EXPECT_NEAR(p.gap, 0, 1e-15);
      EXPECT_NEAR((p.position - Vector3(0.3, 0, top)).norm(), 0.2, 1e-15);
      middle += p.position / scene.points.size();
    }
    EXPECT_LT((middle - Vector3(0.3, 0, top)).norm(), 1e-15);

    scene.poses.set(1, turned(Vector3::UnitY(), M_PI / 2, {0.3, 0, top + 0.2}));
    ASSERT_EQ(scene.find().size(), 2u);
    for (const ContactPoint& p : scene.points) {
      EXPECT_NEAR(p.gap, 0, 1e-15);
      EXPECT_NEAR(std::abs(p.position.x() - 0.3), 0.5, 1e-14);
      EXPECT_EQ(p.curvature, 2.5);  // mean of 1/0.2 and 0
    }
  }
}

/// Depths of a cylinder's four points on a plane change by no more than the motion.
TEST(Contact, OfATiltingCylinderHasNoJump) {
  ContactScene scene({shape::half_space(), shape::cylinder(0.2, 1)});
  scene.reach = {2, 2};
  scene.poses.set(0, {});
  const auto gaps_at = [&](double tilt) {
    scene.poses.set(1, turned(Vector3(1, 0.3, 0).normalized(), tilt, {0, 0, 0.5}));
    std::vector<double> gaps;
    for (const ContactPoint& p : scene.find()) gaps.push_back(p.gap);
    return gaps;
  };
  std::vector<double> last = gaps_at(-0.1);
  ASSERT_EQ(last.size(), 8u);
  for (int i = 1; i <= 2000; ++i) {
    const std::vector<double> now = gaps_at(-0.1 + 1e-3 * i);
    ASSERT_EQ(now.size(), 8u);
    for (std::size_t k = 0; k < 8; ++k) EXPECT_NEAR(now[k], last[k], 1e-3);
    last = now;
  }
}

TEST(Contact, OfCapsulesSideBySideIsAtBothEndsOfWhatTheyShare) {
  const Shape rod = shape::capsule(0.2, 1);
  ContactScene scene({rod, rod});
  scene.reach = {0.01, 0.01};
  scene.poses.set(0, {});
  scene.poses.set(1, {{0.4 - 1e-3, 0, 0.25}});
  ASSERT_EQ(scene.find().size(), 2u);
  EXPECT_NEAR(scene.points[0].position.z(), -0.25, 1e-15);
  EXPECT_NEAR(scene.points[1].position.z(), 0.5, 1e-15);
  for (const ContactPoint& p : scene.points) EXPECT_NEAR(p.gap, -1e-3, 1e-15);
}

TEST(Contact, CurvatureIsTheSumOfThoseOfBothSurfaces) {
  ContactScene scene({shape::sphere(0.5), shape::sphere(0.25), shape::box({1, 1, 1}), shape::capsule(0.1, 1)});
  scene.reach = {10, 10, 10, 10};
  scene.poses.set(0, {});
  scene.poses.set(1, {{2, 0, 0}});
  scene.poses.set(2, {{4, 0, 0}});
  scene.poses.set(3, {{6, 0, 0}});
  for (const ContactPoint& p : scene.find()) {
    const std::pair pair{p.A.collider, p.B.collider};
    const double least =
        pair == std::pair{2, 3} ? 5 : 0;  // box: flat; capsule: half of 1/r on its side, 1/r at its ends
    const std::map<std::pair<int, int>, double> sum{{{0, 1}, 6}, {{0, 2}, 2}, {{0, 3}, 7}, {{1, 2}, 4}, {{1, 3}, 9}};
    if (sum.contains(pair)) {
      EXPECT_DOUBLE_EQ(p.curvature, sum.at(pair));
    } else {
      EXPECT_GE(p.curvature, least);
    }
  }
}

TEST(Contact, PartsOfACompoundAreFoundWhereTheyArePlaced) {
  const Shape ball = shape::sphere(0.1);
  const Shape dumbbell = shape::compound({{{.position = {0.5, 0, 0}}, ball}, {{.position = {-0.5, 0, 0}}, ball}});
  ContactScene scene({shape::half_space(), dumbbell, shape::compound({{{.position = {0, 0, 0.7}}, dumbbell}})});
  scene.reach = {1e-3, 1e-3, 1e-3};
  scene.poses.set(0, {});
  scene.poses.set(1, {{1, 2, 0.1}});
  scene.poses.set(2, {{1, 2, -0.4 - 1e-4}});
  ASSERT_EQ(scene.find().size(), 4u);  // two balls on the plane, two on two
  EXPECT_NE(scene.points[0].feature, scene.points[1].feature);
  EXPECT_NE(scene.points[2].feature, scene.points[3].feature);
  for (const ContactPoint& p : scene.points) {
    EXPECT_NEAR(std::abs(p.position.x() - 1), 0.5, 1e-15);
    EXPECT_NEAR(p.gap, p.A.collider == 0 ? 0 : -1e-4, 1e-15);
  }
}

/// Corners in any number and order, flat faces and points inside among them.
TEST(Contact, OfAHullIsThatOfTheSolidItsPointsEnclose) {
  Random random(11);
  std::vector<Vector3> points;
  for (int i = 0; i <= 4; ++i)
    for (int j = 0; j <= 4; ++j)
      for (int k = 0; k <= 4; ++k) points.emplace_back(i / 4.0 - .5, j / 4.0 - .5, k / 4.0 - .5);
  std::ranges::shuffle(points, random);
  ContactScene scene({shape::half_space(), shape::convex_hull(points), shape::box({1, 1, 1})});
  scene.reach = {0.01, 0.01, 0.01};
  scene.poses.set(0, {});
  scene.poses.set(1, {{0, 0, 0.5}});
  scene.poses.set(2, {{0.2, 0.1, 1.5}});
  scene.find();
  EXPECT_EQ(scene.points.size(), 8u);
  for (const ContactPoint& p : scene.points) EXPECT_NEAR(p.gap, 0, 1e-15);
}

TEST(Contact, OfManyBallsByTheTreeIsThatOfEachPairAlone) {
  Random random(2);
  const int n = 60;  // more pairs than are looked at one by one
  std::vector<Shape> shapes{shape::half_space()};
  std::vector<double> radius{0};
  for (int i = 1; i < n; ++i) {
    radius.push_back(uniform(random, 0.05, 0.2));
    shapes.push_back(shape::sphere(radius[i]));
  }
  ContactScene scene(shapes);
  std::ranges::fill(scene.reach, 0.01);
  scene.poses.set(0, {});
  std::vector<Vector3> at(n), speed(n);
  for (int i = 1; i < n; ++i) {
    at[i] = {uniform(random, 0, 1), uniform(random, 0, 1), uniform(random, 0, 1)};
    speed[i] = {uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1)};
  }
  for (int step = 0; step < 100; ++step) {
    std::set<std::pair<int, int>> meet;
    for (int i = 1; i < n; ++i) {
      at[i] += 0.01 * speed[i];
      scene.poses.set(i, {at[i]});
      if (at[i].z() - radius[i] < 0.02) meet.insert({0, i});
      for (int j = 1; j < i; ++j)
        if ((at[i] - at[j]).norm() - radius[i] - radius[j] < 0.02) meet.insert({j, i});
    }
    std::set<std::pair<int, int>> found;
    std::pair<int, int> last{-1, -1};
    for (const ContactPoint& p : scene.find()) {
      const std::pair pair{p.A.collider, p.B.collider};
      EXPECT_LT(last, pair);
      found.insert(last = pair);
    }
    ASSERT_EQ(found, meet);
  }
  // A detector that has not seen the way here says the same.
  ContactScene fresh(shapes);
  fresh.reach = scene.reach;
  for (int i = 0; i < n; ++i) fresh.poses.set(i, i == 0 ? ContactPose{} : ContactPose{at[i]});
  EXPECT_TRUE(same(scene.find(), fresh.find()));
}

TEST(Contact, IsTheSameToTheLastBitWhateverWasAskedBefore) {
  const std::vector<ContactPair> pairs = contact_pairs();
  Random random(4);
  for (const ContactPair& pair : pairs) {
    ContactScene scene({pair.a, pair.b}), other({pair.a, pair.b});
    scene.reach = other.reach = {0.1, 0.1};
    for (int i = 0; i < 10; ++i) {
      ContactPose a, b;
      pair.place(pair.deepest > 0 ? 1e-3 : -1e-3, random, a, b);
      other.poses.set(0, a), other.poses.set(1, b);
      scene.poses.set(0, a), scene.poses.set(1, b);
      other.find();
      EXPECT_TRUE(same(other.points, scene.find())) << pair.name;
      other.poses.set(1, random_pose(random, 0.3));
      other.find();
    }
  }
}

TEST(Contact, KeepsTheNamesOfItsPointsAsShapesMoveALittle) {
  const std::vector<ContactPair> pairs = contact_pairs();
  Random random(6);
  for (const ContactPair& pair : pairs) {
    if (pair.deepest == 0) continue;
    ContactScene scene({pair.a, pair.b});
    scene.reach = {1e-4, 1e-4};
    for (int i = 0; i < 20; ++i) {
      ContactPose a, b;
      pair.place(1e-3, random, a, b);
      scene.poses.set(0, a), scene.poses.set(1, b);
      scene.find();
      const std::uint64_t name = deepest(scene.points).feature;
      b.p += 1e-9 * Vector3(uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1));
      scene.poses.set(1, b);
      scene.find();
      EXPECT_TRUE(features(scene.points).contains(name)) << pair.name;
    }
  }
}

TEST(Contact, WithAPoseThatIsNoNumberFindsNothingAndReturns) {
  for (const ContactPair& pair : contact_pairs()) {
    ContactScene scene({pair.a, pair.b});
    scene.reach = {0.1, 0.1};
    scene.poses.set(0, {});
    for (int which : {0, 1}) {
      scene.poses.set(which, {Vector3(NAN, 0, 0)});
      EXPECT_TRUE(scene.find().empty()) << pair.name;
      scene.poses.set(which, {Vector3(0, 0, 0.1), Matrix3::Constant(NAN)});
      scene.find();
      scene.poses.set(which, {});
    }
  }
}

TEST(Contact, IsBetweenGroupsThatAgree) {
  SystemGraph graph;
  const auto ball = [&](const char* name, int group, std::uint32_t meets) {
    return Collider{graph.add<RigidBody>(name).marker(), shape::sphere(1), group, meets};
  };
  const Contact contact({ball("a", 0, groups({1})), ball("b", 1, groups({0, 2})), ball("c", 2, groups({0}))}, {});
  const auto detector = make_bullet_detector(contact);
  GivenPoses poses(3);
  for (int i = 0; i < 3; ++i) poses.set(i, {{0.1 * i, 0, 0}});
  std::vector<ContactPoint> points;
  detector->find(poses, std::vector<double>(3, 0.0), points);
  ASSERT_EQ(points.size(), 1u);
  EXPECT_EQ(points[0].A.collider, 0);
  EXPECT_EQ(points[0].B.collider, 1);
}

TEST(Contact, RefusesShapesThatAreNone) {
  EXPECT_THROW(shape::sphere(0), SceneError);
  EXPECT_THROW(shape::sphere(NAN), SceneError);
  EXPECT_THROW(shape::box({1, -1, 1}), SceneError);
  EXPECT_THROW(shape::cylinder(1, 0), SceneError);
  EXPECT_THROW(shape::capsule(INFINITY, 1), SceneError);
  EXPECT_THROW(shape::cone(1, NAN), SceneError);
  EXPECT_THROW(shape::convex_hull({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}), SceneError);
  EXPECT_THROW(shape::convex_hull({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {0.5, 0.2, 0}}), SceneError);
  EXPECT_THROW(shape::convex_hull({{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}}), SceneError);
  EXPECT_THROW(shape::convex_hull({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, NAN}}), SceneError);
  const std::vector<Vector3> square{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  EXPECT_NO_THROW(shape::mesh(square, {{0, 1, 2}, {0, 2, 3}}));
  EXPECT_THROW(shape::mesh(square, {}), SceneError);
  EXPECT_THROW(shape::mesh(square, {{0, 1, 4}}), SceneError);
  EXPECT_THROW(shape::mesh(square, {{0, 1, 1}}), SceneError);
  EXPECT_THROW(shape::height_field(MatrixX::Zero(1, 3), 1, 1), SceneError);
  EXPECT_THROW(shape::height_field(MatrixX::Zero(3, 3), 1, 0), SceneError);
  EXPECT_THROW(shape::compound({}), SceneError);
  EXPECT_THROW(shape::compound({{{.orientation = 2 * Matrix3::Identity()}, shape::sphere(1)}}), SceneError);
  EXPECT_THROW(shape::surface({}, square, {{0, 1, 2}}), SceneError);
  EXPECT_THROW(ContactScene({shape::half_space(), shape::half_space()}), SceneError);
}

}  // namespace
}  // namespace lithe::test::contact_shapes_test
