#include <gtest/gtest.h>

#include "bodies/integral_state.h"
#include "bodies/rigid_body.h"
#include "engine/assembly/evaluator.h"
#include "joints/forces/bushing.h"
#include "joints/forces/coordinate_motor.h"
#include "joints/forces/coordinate_spring.h"
#include "joints/forces/coordinate_stop.h"
#include "joints/forces/distributed_load.h"
#include "joints/forces/pid_controller.h"
#include "joints/forces/spring_damper.h"
#include "joints/forces/user_force.h"
#include "tests/support/joint_checks.h"
#include "tests/support/motion.h"
#include "tests/support/pairs.h"

/// The checks that every force owes, between every pairing of bodies.
namespace lithe::test::coordinate_force_test {
namespace {

using Kind = JointCoordinate::Kind;

/// Angles bend more than the difference formulas of the checks resolve.
constexpr double kCurved = 1e-6, kFine = 3e-5;

template <class T>
void check_on_coordinates(const typename T::Parameters& parameters, const ForceExpectation& expected) {
  for (const Pair& pair : pairs())
    for (const Kind kind : {Kind::angle, Kind::bearing, Kind::displacement, Kind::distance}) {
      SCOPED_TRACE(pair.name + ", coordinate " + std::to_string(static_cast<int>(kind)));
      SystemGraph graph{{.gravity = Vector3::Zero()}};
      const std::vector<Marker> m = pair.draw(graph, {0.3, -0.4, 0.6});
      auto& force = graph.add<T>("force", {JointCoordinate{kind, m[0], m[1], kind == Kind::angle ? 0 : 2}}, parameters);
      check_force(graph, force, expected);
    }
}

/// σ = 3 x + x³ + 0.2 ẋ³
Tension hardening(double x, double v) {
  return {3 * x + x * x * x + 0.2 * v * v * v, 3 + 3 * x * x, 0.6 * v * v, 1.5 * x * x + 0.25 * x * x * x * x};
}

TEST(CoordinateSpring, PullsByWhatItsPotentialLosesOnAnyCoordinate) {
  check_on_coordinates<CoordinateSpring>({.stiffness = 40, .damping = 3, .free_value = 0.2, .preload = 2},
                                         {.tolerance = kCurved, .difference = kFine});
  check_on_coordinates<CoordinateSpring>({.stiffness = 4, .law = hardening},
                                         {.tolerance = kCurved, .difference = kFine});
}

TEST(SpringDamper, FollowsALawOfItsOwn) {
  for (const Pair& pair : pairs()) {
    SCOPED_TRACE(pair.name);
    SystemGraph graph{{.gravity = Vector3::Zero()}};
    auto& spring = graph.add<SpringDamper>("spring", pair.draw(graph, {0.3, -0.4, 0.6}),
                                           {.stiffness = 5, .natural_length = 0.4, .law = hardening});
    check_force(graph, spring, {.tolerance = kCurved, .difference = kFine});
  }
}

TEST(CoordinateMotor, TellsNewtonItsSlopes) {
  check_on_coordinates<CoordinateMotor>(
      {[](double t, double x, double v) { return 5 + t - 2 * std::sin(x) - 0.3 * v - 0.01 * v * v * v; }},
      {.conservative = false, .tolerance = kCurved, .difference = kFine});
}

TEST(CoordinateStop, PushesBackByItsPotentialAndDampsAlone) {
  // Within the travel it does nothing; so that all states push, the travel lies far off.
  for (double sign : {1.0, -1.0})
    check_on_coordinates<CoordinateStop>(sign > 0 ? CoordinateStop::Parameters{.upper = -9, .stiffness = 3}
                                                  : CoordinateStop::Parameters{.lower = 9, .stiffness = 3},
                                         {.tolerance = kCurved, .difference = kFine});
  check_on_coordinates<CoordinateStop>({.upper = -9, .stiffness = 3, .exponent = 1, .dissipation = 0.02},
                                       {.tolerance = kCurved, .difference = kFine});
}

Matrix6 random_semidefinite(unsigned seed, int rank, double size) {
  RandomNumbers random(seed);
  Matrix6 sum = Matrix6::Zero();
  for (int i = 0; i < rank; ++i) {
    const VectorX x = random.vector(6);
    sum += size * x * x.transpose();
  }
  return sum;
}

TEST(Bushing, PullsByWhatItsFullMatricesSay) {
  for (const Pair& pair : pairs())
    for (const bool as_drawn : {true, false}) {
      SCOPED_TRACE(pair.name);
      SystemGraph graph{{.gravity = Vector3::Zero()}};
      auto& bushing = graph.add<Bushing>("bushing", pair.draw(graph, {0.1, -0.05, 0.2}),
                                         {.stiffness = random_semidefinite(1, 6, 30),
                                          .damping = random_semidefinite(2, 3, 2),
                                          .relaxed_as_drawn = as_drawn});
      // The compliant rows hold the damping of the linear law; the turn of rows with velocity is left to Newton.
      check_force(graph, bushing, {.tolerance = kCurved, .difference = kFine});
    }
}

/// At a small displacement from rest M v̇ = -K e, and D ė beside it, as the given matrices say.
TEST(Bushing, GivesTheMatricesBackAtSmallDisplacements) {
  const Matrix6 K = random_semidefinite(3, 6, 100), D = random_semidefinite(4, 6, 5);
  const double size = 1e-6;
  for (int i = 0; i < 6; ++i) {
    const Vector6 e = size * Vector6::Unit(i), e_dot = size * Vector6::Unit((i + 2) % 6);
    SystemGraph graph{{.gravity = Vector3::Zero()}};
    auto& body = graph.add<RigidBody>("body", {.mass = 2,
                                               .inertia = {2, 2, 2},
                                               .position = Vector3(e.head<3>()),
                                               .orientation = rotation_exp(e.tail<3>()),
                                               .velocity = Vector3(e_dot.head<3>()),
                                               .angular_velocity = Vector3(e_dot.tail<3>())});
    graph.add<Bushing>("bushing", {graph.ground().marker(), body.marker()},
                       {.stiffness = K, .damping = D, .relaxed_as_drawn = false});
    const System system = assemble(graph);
    const Vector6 expected = -(K * e + D * e_dot) / 2;
    EXPECT_LT((system.initial_state().v_dot - expected).norm(), 1e-5 * expected.norm()) << i;
  }
}

TEST(PidController, TellsNewtonItsSlopesByTheCoordinate) {
  for (const Pair& pair : pairs()) {
    SCOPED_TRACE(pair.name);
    SystemGraph graph{{.gravity = Vector3::Zero()}};
    const std::vector<Marker> m = pair.draw(graph, {0.3, -0.4, 0.6});
    auto& memory = graph.add<IntegralState>("memory");
    auto& servo =
        graph.add<PidController>("servo", {{Kind::displacement, m[0], m[1]}, memory.coordinate()},
                                 {.target = harmonic(1, 2), .proportional = 8, .integral = 3, .derivative = 2});
    check_force(graph, servo, {.conservative = false, .tolerance = kCurved, .difference = kFine});
  }
}

TEST(DistributedLoad, IsDeadInTheWorldOrFollowsTheBody) {
  for (const auto axes : {DistributedLoad::Axes::world, DistributedLoad::Axes::body})
    for (const Pair& pair : pairs()) {
      SCOPED_TRACE(pair.name);
      SystemGraph graph{{.gravity = Vector3::Zero()}};
      auto& load = graph.add<DistributedLoad>("load", pair.draw(graph, {0.3, -0.4, 0.6}),
                                              {.forces = {Vector3(1, 2, 3), Vector3(-2, 0.5, 1)}, .axes = axes});
      check_force(graph, load, {.conservative = axes == DistributedLoad::Axes::world});
    }
}

TEST(UserForce, TellsNewtonItsSlopes) {
  for (const Pair& pair : pairs()) {
    SCOPED_TRACE(pair.name);
    SystemGraph graph{{.gravity = Vector3::Zero()}};
    const Marker marker = pair.draw(graph, {0.3, -0.4, 0.6})[1];
    if (marker.body == &graph.ground()) continue;
    auto& drag = graph.add<UserForce>("drag", {marker}, {[](double, const MarkerView& m) {
                                        return Wrench{Vector3(-m.v * m.v.norm() - m.p), Vector3(-0.3 * m.w)};
                                      }});
    check_force(graph, drag, {.conservative = false, .tolerance = kCurved, .difference = kFine});
  }
}

}  // namespace
}  // namespace lithe::test::coordinate_force_test
