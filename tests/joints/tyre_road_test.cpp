#include "joints/tyre/tyre_road.h"

#include <gtest/gtest.h>

#include "joints/orientation_joint.h"
#include "joints/revolute_joint.h"
#include "tests/joints/mechanisms.h"
#include "tests/joints/tyre_scenes.h"
#include "tests/support/message_of.h"
#include "tests/support/scenes.h"

namespace lithe::test::tyre_road_test {
namespace {

constexpr double kGravity = 9.81;

/// Waves of 2 cm over 4 and 3 m.
double wave(double x, double y) { return 0.02 * std::sin(2 * kPi * x / 4) * std::cos(2 * kPi * y / 3); }

TyreTerrain::Parameters terrain(const std::function<double(double, double)>& height, int n = 121,
                                double spacing = 0.1) {
  TyreTerrain::Parameters p{.x = -2, .y = -3, .spacing_x = spacing, .spacing_y = spacing, .heights = MatrixX(n, n)};
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) p.heights(i, j) = height(-2 + i * spacing, -3 + j * spacing);
  return p;
}

TEST(TyreTerrain, PassesThroughItsHeightsWithContinuousSlopes) {
  const TyreTerrain road(terrain(wave));
  double worst = 0;
  for (double x = -1.5; x < 8; x += 0.137)
    for (double y = -2.5; y < 8; y += 0.171) {
      const auto h = road.height(x, y);
      worst = std::max(worst, std::abs(h.value - wave(x, y)));
      const double d = 1e-6;
      ASSERT_NEAR(h.by_x, (road.height(x + d, y).value - road.height(x - d, y).value) / (2 * d), 1e-8);
      ASSERT_NEAR(h.by_y, (road.height(x, y + d).value - road.height(x, y - d).value) / (2 * d), 1e-8);
    }
  expect_below("bicubic heights against the wave, m", worst, 1e-4);
  EXPECT_NEAR(road.height(0.5, 0.3).value, wave(0.5, 0.3), 1e-15);  // a point of the grid
  for (const double side : {-1e-9, 1e-9})                           // across a line of the grid
    EXPECT_NEAR(road.height(0.5 + side, 0.33).by_x, road.height(0.5, 0.33).by_x, 1e-7);
  EXPECT_EQ(road.height(-9, 0.3).value, road.height(-2, 0.3).value);
  EXPECT_EQ(road.height(-9, 0.3).by_x, 0);
}

/// The wheel touches where its rim comes closest to the road: searched for apart, point by point.
TEST(TyreTerrain, IsTouchedWhereItIsClosestToTheWheel) {
  const TyreTerrain road(terrain(wave));
  const Vector3 axle = Vector3(0.3, 0.9, 0.1).normalized(), centre(1.3, 0.4, 0.3);
  const TyreRoad::Plane plane = road.plane_below(centre, axle, Vector3::UnitX());
  const Vector3 down = (plane.normal - plane.normal.dot(axle) * axle).normalized();
  const double loaded = plane.normal.dot(centre - plane.point) / plane.normal.dot(down);
  const Vector3 at = centre - loaded * down;
  EXPECT_NEAR(at.z(), road.height(at.x(), at.y()).value, 1e-11);
  EXPECT_NEAR((plane.point - at).norm(), 0, 1e-11);
  double closest = 1;
  const Vector3 along = axle.cross(Vector3::UnitZ()).normalized(), across = along.cross(axle);
  for (double angle = -0.5; angle < 0.5; angle += 1e-4) {
    const Vector3 ray = std::sin(angle) * along - std::cos(angle) * across;
    double r = 0.3;
    for (int k = 0; k < 60; ++k) {  // to the road along the ray
      const Vector3 p = centre + r * ray;
      r -= (p.z() - road.height(p.x(), p.y()).value) / ray.z();
    }
    closest = std::min(closest, r);
  }
  EXPECT_NEAR(loaded, closest, 1e-9);
}

/// On a terrain that is a tilted plane, all is as on that plane; a slippery wheel keeps its energy over waves.
TEST(TyreTerrain, HasAPotential) {
  TyreCoefficients slippery = even_tyre();
  slippery.lmux = slippery.lmuy = slippery.lkx = slippery.lky = 1e-9, slippery.ltr = slippery.ls = slippery.lmx = 0;
  slippery.vertical_damping = 0, slippery.q_v1 = slippery.q_v2 = 0;
  const auto road = std::make_shared<const TyreTerrain>(terrain(wave));
  const Tyre* tyre;
  Scene scene({0, 0, -kGravity}, [&](SystemGraph& graph) {
    auto& wheel = graph.add<RigidBody>("wheel", {.mass = 300,
                                                 .inertia = {20, 20, 30},
                                                 .position = {0, 0.4, 0.305},
                                                 .orientation = axle_left(0.2),
                                                 .velocity = {3, 0.5, 0}});
    tyre = &draw_tyre(graph, "tyre", graph.ground().marker(), wheel.marker(), {.coefficients = slippery, .road = road});
  });
  const double start = scene.energy(), drawn = scene.position(0).z();
  double least = drawn;
  const Method method = radau(1e-9);
  for (double time = 0.05; time < 0.5; time += 0.05) {
    scene.run(*method, time);
    EXPECT_NEAR(scene.energy(), start, 2e-6 * start);
    least = std::min(least, scene.position(0).z());
  }
  EXPECT_LT(least, drawn - 0.002);

  const Vector3 normal = Vector3(-0.1, 0.05, 1).normalized();
  const TyreTerrain tilted(terrain([](double x, double y) { return 0.1 * x - 0.05 * y; }));
  const TyreRoad::Plane plane = tilted.plane_below({1, 1, 0.4}, Vector3::UnitY(), Vector3::UnitX());
  EXPECT_LT((plane.normal - normal).norm(), 1e-12);
  EXPECT_NEAR(plane.normal.dot(plane.point), 0, 1e-12);
}

/// A step of 6 cm: Z against a search over the cam's points.
TEST(TyreProfile, CamsRollOverEdges) {
  const TyreProfile road({.x = {-1, 1, 1, 2, 2.5}, .heights = {0, 0, 0.06, 0.06, 0}, .radius = 0.313});
  const double a = 1.05 * 0.313, b = 1.1 * 0.313;
  const auto height = [](double x) { return x < 1 ? 0 : x < 2 ? 0.06 : x < 2.5 ? 0.06 - 0.12 * (x - 2) : 0; };
  for (double x = -0.5; x < 3.5; x += 0.0437) {
    double highest = -1;
    for (double s = -1; s <= 1; s += 1e-4)
      highest = std::max(highest, height(x + s * a) - b + b * std::pow(1 - std::pow(std::abs(s), 1.8), 1 / 1.8));
    EXPECT_NEAR(road.cam_height(x), highest, 5e-5) << x;
    EXPECT_GE(road.cam_height(x), highest - 1e-12) << x;
  }
  EXPECT_EQ(road.cam_height(0), 0);
  EXPECT_NEAR(road.cam_height(1), 0.06, 1e-15);
  // Up the edge the plane rises in front of the wheel, whichever way it heads.
  const auto up = road.plane_below({0.9, 0, 0.3}, Vector3::UnitY(), Vector3::UnitX());
  EXPECT_LT(up.normal.x(), -0.1);
  EXPECT_NEAR(up.normal.y(), 0, 1e-15);
  EXPECT_LT((road.plane_below({0.9, 0, 0.3}, -Vector3::UnitY(), -Vector3::UnitX()).normal - up.normal).norm(), 1e-15);
}

/// A wheel below a load that keeps upright rolls over a curb of 5 cm: it ends that much higher, after a blow.
TEST(TyreProfile, WheelClimbsACurb) {
  TyreCoefficients t = even_tyre();
  t.vertical_damping = 4000, t.q_v1 = t.q_v2 = 0;  // its rest does not depend on its speed
  const auto curb =
      std::make_shared<const TyreProfile>(TyreProfile::Parameters{.x = {1, 1}, .heights = {0, 0.05}, .radius = 0.313});
  const Tyre* tyre;
  const double rest = 0.313 - sag(t, 400 * kGravity);
  Scene scene({0, 0, -kGravity}, [&](SystemGraph& graph) {
    auto& load = graph.add<RigidBody>(
        "load", {.mass = 385, .position = {0, 0, rest}, .orientation = axle_left(), .velocity = {5, 0, 0}});
    auto& wheel = graph.add<RigidBody>("wheel", {.mass = 15,
                                                 .inertia = {0.5, 0.5, 0.9},
                                                 .position = {0, 0, rest},
                                                 .orientation = axle_left(),
                                                 .velocity = {5, 0, 0},
                                                 .angular_velocity = {0, 0, 5 / 0.306}});
    graph.add<OrientationJoint>("upright", {graph.ground().marker({}, axle_left()), load.marker()});
    graph.add<RevoluteJoint>("hub", {load.marker(), wheel.marker()});
    tyre = &draw_tyre(graph, "tyre", graph.ground().marker(), wheel.marker(), {.coefficients = t, .road = curb});
  });
  const Method method = radau(1e-7);
  double most = 0;
  for (double time = 0.005; time < 3; time += 0.005) {
    scene.run(*method, time);
    most = std::max(most, read(scene, tyre_contact(*tyre), 6));
  }
  EXPECT_GT(most, 1.3 * 400 * kGravity);
  EXPECT_GT(scene.position(0).x(), 10);
  EXPECT_NEAR(scene.position(0).z(), rest + 0.05, 1e-4);
  EXPECT_LT(scene.state.v[0], 5);
}

TEST(TyreRoad, RefusesWhatIsNoRoad) {
  const auto terrain_with = [](auto&& change) {
    TyreTerrain::Parameters p = terrain(wave, 5);
    change(p);
    return message_of<SceneError>([&] { TyreTerrain{p}; });
  };
  EXPECT_EQ(terrain_with([](auto&) {}), "");
  expect_says(terrain_with([](auto& p) { p.heights.resize(1, 3); }), {"1 x 3", "two rows"});
  expect_says(terrain_with([](auto& p) { p.heights(1, 2) = NAN; }), {"heights"});
  expect_says(terrain_with([](auto& p) { p.spacing_y = 0; }), {"spacing_y"});
  const auto profile = [](TyreProfile::Parameters p) { return message_of<SceneError>([&] { TyreProfile{p}; }); };
  expect_says(profile({}), {"0 places"});
  expect_says(profile({.x = {0, 1}, .heights = {0}}), {"2 places", "1 heights"});
  expect_says(profile({.x = {1, 0}, .heights = {0, 0}}), {"falls", "corner 1"});
  expect_says(profile({.x = {0}, .heights = {NAN}}), {"heights"});
  expect_says(profile({.x = {0}, .heights = {0}, .radius = -1}), {"radius"});
  expect_says(message_of<SceneError>([] {
                TyreTerrain(terrain([](double x, double) { return 0.02 * std::sin(20 * x); })).require_passable(0.3);
              }),
              {"radius of 0.1", "TyreProfile"});
}

}  // namespace
}  // namespace lithe::test::tyre_road_test
