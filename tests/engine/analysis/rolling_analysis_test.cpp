// Rows that restrict velocities alone: rolling. The rolling disc of textbooks, and the bicycle of Meijaard,
// Papadopoulos, Ruina & Schwab (2007), R16 of the benchmarks.
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <vector>

#include "bodies/rigid_body.h"
#include "engine/analysis/linearization.h"
#include "engine/assembly/batch_of.h"
#include "joints/revolute_joint.h"

namespace lithe::test::rolling_analysis_test {

namespace {

constexpr double kGravity = 9.81;
const Matrix3 kAxisY = rotation_about({1, 0, 0}, -M_PI / 2);  // marker z along world y

}  // namespace

namespace {

/// A thin disc of radius r (its axis: z of the marker) that rolls on the plane z = 0 without slipping. The contact lies
/// at c = -r u, u the steepest direction in the disc; the material point there stands still:  v + ω × c = 0.
/// Row 3 is holonomic (the disc touches), rows 1 and 2 are not.
class RollingDisc final : public Joint</*markers=*/1, /*rows=*/3> {
 public:
  struct Parameters {
    double radius = 1;
  };
  explicit RollingDisc(Parameters parameters) : r_(parameters.radius) {}
  void evaluate(double, std::span<const MarkerView> markers, ConstraintRows& rows) const override {
    const MarkerView& A = markers[0];
    const Vector3 n = A.z(), n_dot = A.w.cross(n), up(0, 0, 1);
    const double s = std::sqrt(1 - n.z() * n.z()), s_dot = -n.z() * n_dot.z() / s;
    const Vector3 u = (up - n.z() * n) / s, u_dot = (-n_dot.z() * n - n.z() * n_dot - s_dot * u) / s;
    const Vector3 c = -r_ * u, c_dot = -r_ * u_dot;
    for (int axis = 0; axis < 3; ++axis) {
      const Vector3 e = Vector3::Unit(axis);
      const double bias = c_dot.cross(e).dot(A.w);
      if (axis == 2)
        rows.add(A.p.z() - r_ * s, {{e, c.cross(e)}}, bias);
      else
        rows.add_velocity({{e, c.cross(e)}}, bias);
    }
  }

 private:
  const double r_;
};

}  // namespace

TEST(linearization, a_rolling_disc_stays_upright_above_its_critical_speed) {
  // Lean φ and heading ψ: (Jd + m r²) φ̈ = m g r φ - (Jp + m r²) Ω ψ̇ …, Jd ψ̈ = -Jp Ω φ̇ up to signs:
  //   ω² = ((Jp + m r²) Jp Ω²/Jd - m g r)/(Jd + m r²); a uniform disc stands while Ω² > g/3r.
  const double m = 3, r = 0.4, Jp = 0.5 * m * r * r, Jd = 0.5 * Jp, rolling = m * r * r;
  const double critical = std::sqrt(kGravity / (3 * r));
  for (double speed : {0.5 * critical, 0.95 * critical, 1.05 * critical, 3 * critical}) {
    SystemGraph graph;
    const Matrix3 A = rotation_about({1, 0, 0}, -M_PI / 2);  // axis along y
    auto& disc = graph.add<RigidBody>("disc", {.mass = m,
                                               .inertia = {Jd, Jd, Jp},
                                               .position = Vector3(0, 0, r),
                                               .orientation = A,
                                               .velocity = Vector3(r * speed, 0, 0),
                                               .angular_velocity = Vector3(0, 0, speed)});
    graph.add<RollingDisc>("contact", {disc.marker()}, {.radius = r});
    const System system = assemble(graph);
    const Linearization small = linearize(system, system.initial_state(), {.axes = PerturbationAxes::world});
    EXPECT_EQ(small.position_basis.cols(), 5);
    EXPECT_EQ(small.velocity_basis.cols(), 3);
    EXPECT_LT(small.unsteadiness, 1e-6);
    const double squared = ((Jp + rolling) * Jp * speed * speed / Jd - m * kGravity * r) / (Jd + rolling);
    if (squared > 0)
      EXPECT_NEAR(small.modes.back().eigenvalue.imag(), std::sqrt(squared), 1e-6) << speed;
    else
      EXPECT_NEAR(small.largest_growth(), std::sqrt(-squared), 1e-6) << speed;
  }
}

namespace {

/// Upright and straight ahead at a speed; x forward, z up (the paper's z points down, so its I_xz changes sign).
Linearization bicycle(double speed) {
  constexpr double w = 1.02, trail = 0.08, tilt = M_PI / 10, rear_radius = 0.3, front_radius = 0.35;
  const auto inertia = [](double xx, double yy, double zz, double xz) {
    Matrix3 J = Vector3(xx, yy, zz).asDiagonal();
    J(0, 2) = J(2, 0) = xz;
    return J;
  };
  const Vector3 forward(speed, 0, 0), rear_hub(0, 0, rear_radius), front_hub(w, 0, front_radius);
  SystemGraph graph;
  auto& rear = graph.add<RigidBody>("rear wheel", {.mass = 2,
                                                   .inertia = inertia(0.0603, 0.12, 0.0603, 0),
                                                   .position = rear_hub,
                                                   .velocity = forward,
                                                   .angular_velocity = Vector3(0, speed / rear_radius, 0)});
  auto& frame = graph.add<RigidBody>(
      "frame",
      {.mass = 85, .inertia = inertia(9.2, 11, 2.8, -2.4), .position = Vector3(0.3, 0, 0.9), .velocity = forward});
  auto& fork = graph.add<RigidBody>("fork", {.mass = 4,
                                             .inertia = inertia(0.05892, 0.06, 0.00708, 0.00756),
                                             .position = Vector3(0.9, 0, 0.7),
                                             .velocity = forward});
  auto& front = graph.add<RigidBody>("front wheel", {.mass = 3,
                                                     .inertia = inertia(0.1405, 0.28, 0.1405, 0),
                                                     .position = front_hub,
                                                     .velocity = forward,
                                                     .angular_velocity = Vector3(0, speed / front_radius, 0)});
  // The steering axis leans back and meets the ground a trail ahead of the contact.
  const Matrix3 steer = rotation_about({0, 1, 0}, -tilt);
  const Vector3 head = Vector3(w + trail, 0, 0) + 0.8 * steer.col(2);
  const auto at = [](RigidBody& body, const Vector3& point, const Matrix3& axes) {
    return body.marker(point - body.parameters().position, axes);
  };
  graph.add<RevoluteJoint>("rear axle", {at(frame, rear_hub, kAxisY), rear.marker({0, 0, 0}, kAxisY)});
  graph.add<RevoluteJoint>("head", {at(frame, head, steer), at(fork, head, steer)});
  graph.add<RevoluteJoint>("front axle", {at(fork, front_hub, kAxisY), front.marker({0, 0, 0}, kAxisY)});
  graph.add<RollingDisc>("rear contact", {rear.marker({0, 0, 0}, kAxisY)}, {.radius = rear_radius});
  graph.add<RollingDisc>("front contact", {front.marker({0, 0, 0}, kAxisY)}, {.radius = front_radius});
  const System system = assemble(graph);
  return linearize(system, system.initial_state(), {.axes = PerturbationAxes::world});
}

std::complex<double> nearest(const std::vector<Mode>& modes, std::complex<double> to) {
  std::complex<double> best = modes.front().eigenvalue;
  for (const Mode& mode : modes)
    if (std::abs(mode.eigenvalue - to) < std::abs(best - to)) best = mode.eigenvalue;
  return best;
}

}  // namespace

TEST(linearization, a_bicycle_has_the_eigenvalues_of_the_benchmark) {
  const std::vector<std::pair<double, std::vector<std::complex<double>>>> expected = {
      {0, {-5.53094371765393, -3.13164324790656, 3.13164324790656, 5.53094371765393}},
      {2, {-8.67387984831737, -3.07158645641514, {2.68234517512745, 1.68066296590676}}},
      {5, {-14.0783896927982, {-0.775341882195842, 4.46486771378823}, -0.322866429004087}},
      {8, {-20.2794089439457, {-2.69348683581095, 8.46037971396934}, 0.143278797657129}},
      {10, {-24.624596350174, {-3.72016840437288, 10.9068113947629}, 0.161053386531716}}};
  double worst = 0;
  for (const auto& [speed, eigenvalues] : expected) {
    const Linearization small = bicycle(speed);
    EXPECT_EQ(small.position_basis.cols(), 7);
    EXPECT_EQ(small.velocity_basis.cols(), 3);
    for (const auto& s : eigenvalues) worst = std::max(worst, std::abs(nearest(small.modes, s) - s) / std::abs(s));
  }
  EXPECT_LT(worst, 1e-6);
  std::printf("bicycle: relative error of eigenvalues %.1e\n", worst);
}

TEST(linearization, a_bicycle_stops_weaving_at_its_weave_speed) {
  const auto growth = [](double speed) { return nearest(bicycle(speed).modes, {0, 3.4}).real(); };
  double a = 4.2, b = 4.4, fa = growth(a), fb = growth(b);
  for (int i = 0; i < 6 && std::abs(b - a) > 1e-10; ++i) {
    const double c = b - fb * (b - a) / (fb - fa);
    a = b, fa = fb, b = c, fb = growth(c);
  }
  EXPECT_NEAR(b, 4.29238253634111, 1e-6);
  std::printf("weave speed: error %.1e m/s\n", b - 4.29238253634111);
}

}  // namespace lithe::test::rolling_analysis_test
