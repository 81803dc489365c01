// F08: the elastic beam of the IVP Test Set (E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, IV.1):
// 40 rigid segments without mass, their ends heavy, hinged to each other with springs, a load on the free end that
// turns off at t = pi.
#include <gtest/gtest.h>

#include <cmath>

#include "bodies/rigid_body.h"
#include "joints/forces/coordinate_spring.h"
#include "joints/forces/user_force.h"
#include "joints/revolute_joint.h"
#include "tests/reference/benchmark.h"

namespace lithe::test::f08_ivp_beam_test {
namespace {

constexpr int kSegments = 40;
constexpr double kLength = 1.0 / kSegments;
constexpr double kNoInertia = 1e-11;  // of a segment about its end, where its mass is: 1e-6 of m l²

/// v_l = n⁴ (θ_l-1 - 2 θ_l + θ_l+1) over n³: springs of n, and of 2 n at the clamp, where θ_0 = -θ_1.
Scene cantilever() {
  return Scene({0, 0, 0}, [](SystemGraph& graph) {
    Marker before = graph.ground().marker();
    for (int l = 0; l < kSegments; ++l) {
      const std::string number = std::to_string(l + 1);
      const bool last = l == kSegments - 1;
      auto& end = graph.add<RigidBody>("end" + number, {.mass = last ? 0.5 * kLength : kLength,
                                                        .inertia = {kNoInertia, kNoInertia, kNoInertia},
                                                        .position = {(l + 1) * kLength, 0, 0}});
      auto& hinge = graph.add<RevoluteJoint>("hinge" + number, {before, end.marker({-kLength, 0, 0})});
      graph.add<CoordinateSpring>("spring" + number, {hinge.angle()}, {.stiffness = (l == 0 ? 2.0 : 1.0) * kSegments});
      before = end.marker();
      if (last)
        graph.add<UserForce>("load", {before}, {[](double t, const MarkerView&) {
                               const double size = t < M_PI ? 1.5 * std::pow(std::sin(t), 2) : 0;
                               return Wrench{{-size, size, 0}, {0, 0, 0}};
                             }});
    }
  });
}

TEST(F08IvpBeam, EndsAtTheAnglesOfTheTestSet) {
  const Table table = reference("F08_ivp_beam/reference.csv");
  Scene scene = cantilever();
  const Method method = radau(1e-6);
  scene.run(*method, M_PI);
  scene.run(*method, 5);
  double angles = 0, rates = 0;
  for (int l = 0; l < kSegments; ++l) {
    const double* q = scene.state.q.data() + 7 * l;
    const double angle = 2 * std::atan2(q[6], q[3]);
    angles = std::max(angles, std::abs(angle - table.at(l, 1)));
    rates = std::max(rates, std::abs(scene.state.v[6 * l + 5] - table.at(kSegments + l, 1)));
  }
  expect_below("F08, angles at 5 s (rad; mark 1e-4)", angles, 1e-4);
  expect_below("F08, rates at 5 s (rad/s)", rates, 1e-2);
}

}  // namespace
}  // namespace lithe::test::f08_ivp_beam_test
