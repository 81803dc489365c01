#include "joints/gears/sprocket_pair.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "engine/analysis/equilibrium.h"
#include "engine/observe/recorder.h"
#include "engine/run/simulation.h"
#include "joints/coordinate_drive.h"
#include "joints/fixed_joint.h"
#include "joints/forces/coordinate_spring.h"
#include "joints/forces/point_force.h"
#include "tests/joints/mechanisms.h"
#include "tests/support/joint_checks.h"
#include "tests/support/pairs.h"

namespace lithe::test::sprocket_pair_test {
namespace {

TEST(SprocketPair, PullsByWhatItsPotentialLosesOnAllBodies) {
  for (const bool polygon : {true, false})
    for (const Pair& pair : pairs()) {
      SCOPED_TRACE(pair.name + (polygon ? " chain" : " belt"));
      SystemGraph graph{{.gravity = Vector3::Zero()}};
      const std::vector<Marker> markers = pair.draw(graph, {12, 9, 0});
      check_force(graph,
                  graph.add<SprocketPair>("chain", markers,
                                          {.teeth_A = 9,
                                           .teeth_B = 15,
                                           .pitch = 2,
                                           .axial_stiffness = 100,
                                           .damping = 0.5,
                                           .pretension = 40,
                                           .polygon = polygon}),
                  {.tolerance = 1e-6, .difference = 2e-5});
    }
}

/// Length of the hull of all joints of both sprockets: that of a taut chain.
double hull_length(const std::vector<Vector3>& points) {
  std::vector<Vector3> p = points, hull;
  std::sort(p.begin(), p.end(),
            [](const auto& a, const auto& b) { return std::pair(a.x(), a.y()) < std::pair(b.x(), b.y()); });
  for (int half = 0; half < 2; ++half, std::reverse(p.begin(), p.end())) {  // Andrew's monotone chain
    const std::size_t first = hull.size();
    for (const Vector3& next : p) {
      while (hull.size() >= first + 2 && (hull.back() - hull[hull.size() - 2]).cross(next - hull.back()).z() <= 0)
        hull.pop_back();
      hull.push_back(next);
    }
    hull.pop_back();
  }
  double length = 0;
  for (std::size_t i = 0; i < hull.size(); ++i) length += (hull[(i + 1) % hull.size()] - hull[i]).norm();
  return length;
}

struct Drive {
  explicit Drive(const SprocketPair::Parameters& parameters) {
    A = draw_shaft(graph, "A", 1e-3), B = draw_shaft(graph, "B", 1e-3, {kApart, 0, 0});
    chain = &graph.add<SprocketPair>("chain", {A.body->marker(), B.body->marker()}, parameters);
  }
  static constexpr double kApart = 0.2;
  SystemGraph graph{{.gravity = {0, 0, 0}}};
  Shaft A, B;
  SprocketPair* chain;
};

constexpr int kTeethA = 9, kTeethB = 14;
constexpr double kPitch = 12.7e-3, kStiffness = 1e6;

SprocketPair::Parameters drive(double pretension, bool polygon) {
  return {.teeth_A = kTeethA,
          .teeth_B = kTeethB,
          .pitch = kPitch,
          .axial_stiffness = kStiffness,
          .damping = 300,
          .pretension = pretension,
          .polygon = polygon};
}

/// Both sprockets turned by any angles: the stretch of both spans together is that of the taut chain around both
/// polygons; a whole tooth on both changes nothing.
TEST(SprocketPair, StretchesAsTheTautChainAroundItsPolygons) {
  const double T = 2e4;
  Drive scene(drive(T, true));
  const System system = assemble(scene.graph);
  Evaluator evaluator(system);
  const auto tensions = [&](double a, double b) {
    VectorX turned = VectorX::Zero(system.layout().v_count()), q = system.initial_state().q;
    turned[5] = a, turned[11] = b;
    system.layout().retract(system.initial_state().q, turned, q);
    evaluator.evaluate(0, q, 0 * turned, Level::velocity);
    return Eigen::Vector2d(evaluator.workspace().tension);
  };
  const auto taut = [&](double a, double b) {
    std::vector<Vector3> joints;
    const auto add = [&](int teeth, double angle, double x) {
      for (int i = 0; i < teeth; ++i)
        joints.push_back(Vector3(x, 0, 0) + rotation_about({0, 0, 1}, angle + 2 * kPi * i / teeth) *
                                                Vector3(0.5 * kPitch / std::sin(kPi / teeth), 0, 0));
    };
    add(kTeethA, a, 0), add(kTeethB, b, Drive::kApart);
    return hull_length(joints);
  };
  // k of both spans: that of the drawing's straight part.
  const double k = (tensions(0.1, 0.02).sum() - 2 * T) / (taut(0.1, 0.02) - taut(0, 0));
  EXPECT_NEAR(k, kStiffness / Drive::kApart, 0.08 * k);  // the straight part is shorter than the line of centres
  double least = 1e9, most = 0;
  for (double a = -0.5; a < 0.5; a += 0.07) {
    const double b = a * kTeethA / kTeethB + 0.01, sum = tensions(a, b).sum();
    EXPECT_NEAR(sum, 2 * T + k * (taut(a, b) - taut(0, 0)), 1e-6 * T) << a;
    least = std::min(least, sum), most = std::max(most, sum);
  }
  EXPECT_GT(most - least, 0.05 * T);  // the polygon effect
  EXPECT_LT((tensions(2 * kPi / kTeethA, 2 * kPi / kTeethB) - tensions(0, 0)).norm(), 1e-9 * T);
}

/// A held, B under a torque: the tight span alone carries it, T = M/R; the other one is slack.
TEST(SprocketPair, CarriesATorqueInItsTightSpan) {
  for (const double way : {1.0, -1.0}) {
    Drive scene(drive(100, false));
    const double M = 30, R = 0.5 * kPitch * kTeethB / kPi;
    scene.graph.add<FixedJoint>("hold", {scene.graph.ground().marker(), scene.A.body->marker()});
    scene.graph.add<PointForce>("torque", {scene.B.body->marker()}, {.torque = {0, 0, way * M}});
    const System system = assemble(scene.graph);
    const State rest = find_equilibrium(system, system.initial_state()).state;
    Evaluator evaluator(system);
    evaluator.evaluate(0, rest.q, rest.v, Level::velocity);
    const VectorX& tension = evaluator.workspace().tension;
    EXPECT_NEAR(tension.maxCoeff(), M / R, 1e-6 * M / R);
    EXPECT_EQ(tension.minCoeff(), 0);
  }
}

/// Driven at constant speed against a torque over two turns of A: B follows in the mean by z_A/z_B, its speed in the
/// rhythm of the teeth.
TEST(SprocketPair, TurnsByTheRatioOfTeethWithPolygonEffect) {
  for (const bool polygon : {true, false}) {
    SprocketPair::Parameters parameters = drive(polygon ? 0 : 500, polygon);
    if (polygon) parameters.slack = 2e-3;  // more than polygons take up: one span pulls
    Drive scene(parameters);
    const double speed = 5;
    scene.graph.add<CoordinateDrive>("motor", {scene.A.angle()}, {.motion = ramp(0, speed)});
    scene.graph.add<CoordinateSpring>("brake", {scene.B.angle()}, {.damping = 0.2});
    const System system = assemble(scene.graph);
    State state = system.initial_state();
    Method method = radau(1e-7);
    Recorder recorder{{coordinate(scene.B.angle(), "angle"), coordinate_rate(scene.B.angle(), "rate")}};
    Simulation simulation{system, *method};
    simulation.run(state, 0.5);
    simulation.observe(recorder, every(2 * kPi / kTeethA / speed / 40));
    simulation.run(state, 0.5 + 4 * kPi / speed);
    const std::vector<double> angle = recorder.table().column("angle"), rate = recorder.table().column("rate");
    const double mean = speed * kTeethA / kTeethB;
    // Nine teeth pass in a turn of A: after two, the polygons of A stand as before and those of B by four teeth on.
    EXPECT_NEAR(angle.back() - angle.front(), 4 * kPi * kTeethA / kTeethB, 1e-4);
    const auto [least, most] = std::minmax_element(rate.begin(), rate.end());
    const double ripple = (*most - *least) / mean;
    if (polygon) {
      // Arms from R cos(π/z) to R on either sprocket, in any rhythm to each other.
      const double of_A = 1 - std::cos(kPi / kTeethA), of_B = 1 - std::cos(kPi / kTeethB);
      EXPECT_GT(ripple, 0.9 * (of_A - of_B));
      EXPECT_LT(ripple, 1.1 * (of_A + of_B));
    } else {
      EXPECT_LT(ripple, 1e-4);
    }
  }
}

}  // namespace
}  // namespace lithe::test::sprocket_pair_test
