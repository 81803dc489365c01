#include "engine/model/joint_coordinate.h"

#include <gtest/gtest.h>

#include "tests/support/motion.h"

namespace lithe::test::joint_coordinate_test {
namespace {

using Kind = JointCoordinate::Kind;

/// A frame that moves: pose at time t.
struct MovingFrame {
  Vector3 p, v, a, phi, w;  // p + v t + ½ a t², R = exp(w t) exp(phi), world axes

  MarkerKinematics at(double t) const {
    MarkerKinematics k;
    k.p = p + t * v + 0.5 * t * t * a;
    k.v = v + t * a;
    k.R = rotation_exp(t * w) * rotation_exp(phi);
    k.w = w;
    return k;
  }
};

TEST(JointCoordinates, RateAndBiasAreTheDerivativesAlongAMotion) {
  RandomNumbers random(5);
  for (int run = 0; run < 10; ++run) {
    const auto frame = [&] {
      return MovingFrame{random.vector3(), random.vector3(2), random.vector3(3), random.vector3(0.5),
                         random.vector3(2)};
    };
    const MovingFrame A = frame(), B = frame();
    const auto measured = [&](Kind kind, int axis, double t) {
      const MarkerKinematics a = A.at(t), b = B.at(t);
      return measure(kind, axis, MarkerView(a, 0), MarkerView(b, 1));
    };
    for (const Kind kind : {Kind::angle, Kind::bearing, Kind::displacement, Kind::distance})
      for (int axis = 0; axis < 3; ++axis) {
        SCOPED_TRACE(std::to_string(static_cast<int>(kind)) + " about " + std::to_string(axis));
        const MeasuredCoordinate x = measured(kind, axis, 0);
        const double h = 1e-5;
        const double rate = derivative(
            [&](double t) { return std::remainder(measured(kind, axis, t).value - x.value, 2 * std::numbers::pi); }, h);
        const double second = derivative([&](double t) { return measured(kind, axis, t).rate; }, h);
        // V_dot = (a, 0) of each frame
        const double by_W =
            x.on_A.force.dot(A.v) + x.on_A.torque.dot(A.w) + x.on_B.force.dot(B.v) + x.on_B.torque.dot(B.w);
        EXPECT_NEAR(x.rate, rate, 1e-7 * (1 + std::abs(rate)));
        EXPECT_NEAR(x.rate, by_W, 1e-11 * (1 + std::abs(rate)));
        EXPECT_NEAR(x.on_A.force.dot(A.a) + x.on_B.force.dot(B.a) + x.bias, second, 1e-6 * (1 + std::abs(second)));
        // No force or moment from nowhere: the wrenches balance.
        const Vector3 d = B.p - A.p;
        EXPECT_LT((x.on_A.force + x.on_B.force).norm(), 1e-12 * (1 + x.on_B.force.norm()));
        EXPECT_LT((x.on_A.torque + x.on_B.torque + d.cross(x.on_B.force)).norm(), 1e-11 * (1 + x.on_A.torque.norm()));
      }
  }
}

TEST(JointCoordinates, MeasureWhatTheyName) {
  MarkerKinematics a{}, b{};
  a.p = Vector3(1, 0, 0), a.R = rotation_about({0, 0, 1}, std::numbers::pi / 2);
  b.p = Vector3(1, 2, 3), b.R = rotation_about({0, 0, 1}, std::numbers::pi / 2 + 0.3);
  a.v = a.w = b.v = b.w = Vector3::Zero();
  const MarkerView A(a, 0), B(b, 1);
  EXPECT_NEAR(measure(Kind::angle, 2, A, B).value, 0.3, 1e-14);
  EXPECT_NEAR(measure(Kind::angle, 2, B, A).value, -0.3, 1e-14);
  EXPECT_NEAR(measure(Kind::displacement, 0, A, B).value, 2, 1e-14);  // x of A is y of the world
  EXPECT_NEAR(measure(Kind::displacement, 2, A, B).value, 3, 1e-14);
  EXPECT_NEAR(measure(Kind::distance, 2, A, B).value, std::sqrt(13), 1e-14);
  EXPECT_NEAR(measure(Kind::bearing, 2, A, B).value, 0, 1e-14);                 // along x of A
  EXPECT_NEAR(measure(Kind::bearing, 1, A, B).value, std::atan2(2, 3), 1e-14);  // about y, from z towards x
}

/// The quarter turns that the engine remembers grow with the angle; near them the angle is told to the turn.
TEST(AngleMemory, AddsTheTurnsThatItRemembers) {
  for (double angle = -40; angle < 40; angle += 0.37) {
    for (double stale : {-1.4, -0.3, 0.0, 0.3, 1.4}) {  // remembered a step ago
      const double quarter_turns = (angle + stale) * 2 / std::numbers::pi;
      AngleMemory memory;
      memory.recall(&quarter_turns);
      EXPECT_NEAR(memory.wound(0, std::remainder(angle, 2 * std::numbers::pi)), angle, 1e-12);
    }
  }
  EXPECT_EQ(AngleMemory{}.wound(0, 1.5), 1.5);
}

}  // namespace
}  // namespace lithe::test::joint_coordinate_test
