// R16: the bicycle of Meijaard, Papadopoulos, Ruina & Schwab (2007), uncontrolled, from four bodies, three hinges and
// two rolling discs. Marks: eigenvalues within 1e-6 relative, weave and capsize speed within 1e-6 m/s.
#include <gtest/gtest.h>

#include <complex>
#include <fstream>
#include <nlohmann/json.hpp>
#include <unsupported/Eigen/MatrixFunctions>

#include "bodies/rigid_body.h"
#include "engine/analysis/linearization.h"
#include "joints/revolute_joint.h"
#include "joints/rolling_disc.h"
#include "tests/reference/accuracy.h"
#include "tests/support/json_file.h"
#include "tests/support/linear_algebra.h"

namespace lithe::test::r16_bicycle_test {
namespace {

using Complex = std::complex<double>;

constexpr double kWheelBase = 1.02, kTrail = 0.08, kTilt = M_PI / 10, kRearRadius = 0.3, kFrontRadius = 0.35;

nlohmann::json benchmark() {
  return read_json(std::string(LITHE_TEST_DATA) + "/benchmarks/R16_bicycle_linear/reference.json");
}
double number(const nlohmann::json& text) { return std::stod(text.get<std::string>()); }
Eigen::Matrix2d matrix2(const nlohmann::json& rows) {
  Eigen::Matrix2d m;
  for (int i = 0; i < 2; ++i)
    for (int j = 0; j < 2; ++j) m(i, j) = number(rows[i][j]);
  return m;
}

/// Upright and straight ahead at a speed, falling over its wheels' track at `lean_rate`. x forward, y left, z up (the
/// paper's z points down: its I_xz changes sign). Bodies: rear wheel, frame with rider, fork, front wheel.
Scene bicycle(double speed, double lean_rate = 0) {
  return Scene({0, 0, -9.81}, [&](SystemGraph& graph) {
    const Matrix3 axle = rotation_about({1, 0, 0}, -M_PI / 2);  // marker z along world y
    const Matrix3 head_axes = rotation_about({0, 1, 0}, -kTilt);
    const Vector3 rear_hub(0, 0, kRearRadius), front_hub(kWheelBase, 0, kFrontRadius);
    // The steering axis leans back and meets the ground a trail ahead of the front contact.
    const Vector3 head = Vector3(kWheelBase + kTrail, 0, 0) + 0.8 * head_axes.col(2);
    const Vector3 lean(lean_rate, 0, 0);
    const auto body = [&](Located name, double mass, const Vector3& moments, double xz, const Vector3& at,
                          double spin) -> RigidBody& {
      Matrix3 inertia = moments.asDiagonal();
      inertia(0, 2) = inertia(2, 0) = xz;
      return graph.add<RigidBody>(name, {.mass = mass,
                                         .inertia = inertia,
                                         .position = at,
                                         .velocity = Vector3(speed, 0, 0) + lean.cross(at),
                                         .angular_velocity = lean + Vector3(0, spin, 0)});
    };
    auto& rear = body("rear wheel", 2, {0.0603, 0.12, 0.0603}, 0, rear_hub, speed / kRearRadius);
    auto& frame = body("frame", 85, {9.2, 11, 2.8}, -2.4, {0.3, 0, 0.9}, 0);
    auto& fork = body("fork", 4, {0.05892, 0.06, 0.00708}, 0.00756, {0.9, 0, 0.7}, 0);
    auto& front = body("front wheel", 3, {0.1405, 0.28, 0.1405}, 0, front_hub, speed / kFrontRadius);
    const auto at = [](RigidBody& on, const Vector3& point, const Matrix3& axes) {
      return on.marker(point - on.parameters().position, axes);
    };
    graph.add<RevoluteJoint>("rear axle", {at(frame, rear_hub, axle), at(rear, rear_hub, axle)});
    graph.add<RevoluteJoint>("head", {at(frame, head, head_axes), at(fork, head, head_axes)});
    graph.add<RevoluteJoint>("front axle", {at(fork, front_hub, axle), at(front, front_hub, axle)});
    const Marker road = graph.ground().marker();
    graph.add<RollingDisc>("rear contact", {road, at(rear, rear_hub, axle)}, {.radius = kRearRadius});
    graph.add<RollingDisc>("front contact", {road, at(front, front_hub, axle)}, {.radius = kFrontRadius});
  });
}

Linearization linearized(double speed) {
  const Scene scene = bicycle(speed);
  EXPECT_EQ(scene.system.degrees_of_freedom(), 3);
  Linearization small = linearize(scene.system, scene.state, {.axes = PerturbationAxes::world});
  EXPECT_EQ(small.position_basis.cols(), 7);
  EXPECT_EQ(small.velocity_basis.cols(), 3);
  return small;
}

/// ẋ = A x of lean and steer alone. Place on the road, heading, the wheels' angles and the speed make a sixfold zero
/// with Jordan blocks: near it an eigenvalue of the whole keeps half its digits, so they are taken out, as the free
/// motions that they are. `leak`: how much of the others they drive (0).
MatrixX lean_and_steer_equations(const Linearization& small, double* leak = nullptr) {
  MatrixX free = MatrixX::Zero(24, 5);  // forward, sideways, heading, rear and front wheel's angle
  VectorX turned = VectorX::Zero(24);   // what a new heading does to velocities
  for (int body = 0; body < 4; ++body) {
    const Vector3 p = small.state.q.segment<3>(7 * body);
    free.block<3, 1>(6 * body, 0) = Vector3::UnitX();
    free.block<3, 1>(6 * body, 1) = Vector3::UnitY();
    free.block<6, 1>(6 * body, 2) << Vector3::UnitZ().cross(p), Vector3::UnitZ();
    for (int i = 6 * body; i < 6 * body + 6; i += 3)
      turned.segment<3>(i) = Vector3::UnitZ().cross(Vector3(small.state.v.segment<3>(i)));
  }
  free(6 * 0 + 4, 3) = free(6 * 3 + 4, 4) = 1;
  const VectorX faster = free.col(0) + free.col(3) / kRearRadius + free.col(4) / kFrontRadius;
  MatrixX neutral = MatrixX::Zero(10, 6);
  neutral.topLeftCorner(7, 5) = small.position_basis.transpose() * free;
  neutral.block<3, 1>(7, 2) = small.velocity_basis.transpose() * turned;
  neutral.bottomRightCorner(3, 1) = small.velocity_basis.transpose() * faster;
  const MatrixX rest = complement(neutral), A = solve(small.E, small.A);
  if (leak) *leak = product(rest.transpose(), product(A, complement(rest))).cwiseAbs().maxCoeff();
  return congruence(rest, A);
}

std::vector<Complex> lean_and_steer_eigenvalues(double speed) {
  const Eigen::VectorXcd values = eigenvalues(lean_and_steer_equations(linearized(speed)));
  return {values.begin(), values.end()};
}

Complex take_nearest(std::vector<Complex>& from, Complex to) {
  const auto nearest = std::min_element(from.begin(), from.end(),
                                        [&](Complex a, Complex b) { return std::abs(a - to) < std::abs(b - to); });
  const Complex found = *nearest;
  from.erase(nearest);
  return found;
}

TEST(R16Bicycle, HasTheEigenvaluesOfTheBenchmarkAtEverySpeed) {
  const auto data = benchmark();
  double worst = 0, whole = 0, leak = 0;
  for (const auto& [speed, expected] : data["eigenvalues"].items()) {
    const Linearization small = linearized(std::stod(speed));
    double leaks = 0;
    const Eigen::VectorXcd values = eigenvalues(lean_and_steer_equations(small, &leaks));
    std::vector<Complex> found(values.begin(), values.end()), modes;
    for (const Mode& mode : small.modes) modes.push_back(mode.eigenvalue);
    for (const auto& pair : expected) {
      const Complex s(number(pair[0]), number(pair[1]));
      worst = std::max(worst, std::abs(take_nearest(found, s) - s) / std::abs(s));
      if (s.imag() >= 0) whole = std::max(whole, std::abs(take_nearest(modes, s) - s));
    }
    leak = std::max(leak, leaks);
  }
  expect_below("R16, eigenvalues, v = 0 ... 10 m/s (relative; mark 1e-6)", worst, 1e-7);
  expect_below("R16, what place, heading and speed do to lean and steer", leak, 1e-7);
  expect_below("R16, eigenvalues as linearize() tells them, beside their sixfold zero (1/s)", whole, 1e-6);
}

/// Where growth(speed) changes sign between a and b: secants.
template <class Growth>
double critical_speed(double a, double b, Growth&& growth) {
  double at_a = growth(a), at_b = growth(b);
  for (int i = 0; i < 12 && std::abs(b - a) > 1e-9; ++i) {
    const double c = b - at_b * (b - a) / (at_b - at_a);
    a = b, at_a = at_b, b = c, at_b = growth(c);
  }
  return b;
}

TEST(R16Bicycle, StopsWeavingAndBeginsToCapsizeAtTheBenchmarksSpeeds) {
  const auto data = benchmark();
  const auto growth_near = [](Complex s) {
    return [s](double speed) {
      std::vector<Complex> all = lean_and_steer_eigenvalues(speed);
      return take_nearest(all, s).real();
    };
  };
  const double weave = critical_speed(4.2, 4.4, growth_near({0, 3.4}));
  const double capsize = critical_speed(5.9, 6.1, growth_near(0));
  expect_below("R16, weave speed (m/s; mark 1e-6)", std::abs(weave - number(data["weave_speed"])), 1e-7);
  expect_below("R16, capsize speed (m/s; mark 1e-6)", std::abs(capsize - number(data["capsize_speed"])), 1e-7);
}

/// Lean and steer angle, rad, positive to the right.
Eigen::Vector2d lean_and_steer(const Scene& scene) {
  const auto axes = [&](int body) { return rotation_matrix(scene.state.q.segment<4>(7 * body + 3)); };
  const Matrix3 frame = axes(1);
  const Vector3 head = rotation_about({0, 1, 0}, -kTilt).col(2);
  return {std::asin(frame(2, 1)), -head.dot(rotation_log(frame.transpose() * axes(2)))};
}

/// The linear equations of the paper from a lean rate, at t: lean and steer.
Eigen::Vector2d linear_motion(double speed, double lean_rate, double t) {
  const auto data = benchmark();
  const Eigen::Matrix2d M_inverse = matrix2(data["M"]).inverse();
  Eigen::Matrix4d A = Eigen::Matrix4d::Zero();
  A.topRightCorner<2, 2>().setIdentity();
  A.bottomLeftCorner<2, 2>() = -M_inverse * (9.81 * matrix2(data["K0"]) + speed * speed * matrix2(data["K2"]));
  A.bottomRightCorner<2, 2>() = -M_inverse * speed * matrix2(data["C1"]);
  return ((A * t).exp() * Eigen::Vector4d(0, 0, lean_rate, 0)).head<2>();
}

TEST(R16Bicycle, FollowsTheLinearEquationsAfterASmallPush) {
  constexpr double speed = 5, lean_rate = 1e-3;
  for (Method& run :
       std::array<Method, 5>{automatic(1e-6), runge_kutta(1e-10), index2(1e-3), index3(1e-3), ida(1e-10)}) {
    Scene scene = bicycle(speed, lean_rate);
    double worst = 0, largest = 0;
    for (int k = 1; k <= 30; ++k) {
      scene.run(*run, 0.1 * k);
      const Eigen::Vector2d expected = linear_motion(speed, lean_rate, 0.1 * k);
      worst = std::max(worst, (lean_and_steer(scene) - expected).norm());
      largest = std::max(largest, expected.norm());
    }
    expect_below("R16, a small push at 5 m/s, " + run->name() + ", lean and steer (relative)", worst / largest, 1e-4);
  }
}

struct Trial {
  Method method;
  double slip;  // bound, m/s; index 3 leaves the velocities of the holonomic rows alone
};

TEST(R16Bicycle, KeepsItsEnergyAndRightsItselfAfterALargePush) {
  Trial runs[] = {{automatic(1e-6), 1e-10},
                  {runge_kutta(1e-9), 1e-13},
                  {ida(1e-9), 1e-8},
                  {index3(1e-3), 1e-4},
                  {index2(1e-3), 1e-10}};
  for (Trial& run : runs) {
    Scene scene = bicycle(5, 0.5);
    const double start = scene.energy();
    double energy = 0, slip = 0, early = 0, late = 0;
    for (int k = 1; k <= 50; ++k) {
      scene.run(*run.method, 0.1 * k);
      energy = std::max(energy, std::abs(scene.energy() / start - 1));
      slip = std::max(slip, scene.violation(Level::velocity));
      double& lean = k <= 10 ? early : late;
      if (k <= 10 || k > 40) lean = std::max(lean, std::abs(lean_and_steer(scene)[0]));
    }
    const std::string name = "R16, a large push at 5 m/s, " + run.method->name();
    expect_below(name + ", energy (relative; mark 1e-6)", energy, 1e-6);
    expect_below(name + ", joints' and rolling rows' speed (m/s, rad/s)", slip, run.slip);
    expect_below(name + ", lean after 4 s as a part of the first second's", late / early, 0.2);
  }
}

}  // namespace
}  // namespace lithe::test::r16_bicycle_test
