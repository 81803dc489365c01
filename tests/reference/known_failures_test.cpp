// Scenes at which other tools are known to fail: a driven slider-crank with a rod that is a distance, over-constrained
// linkages, a platform on six driven legs. |g| < 1e-10 at all output times, redundant rows counted by a dense rank.
#include <gtest/gtest.h>

#include "joints/coordinate_drive.h"
#include "joints/distance_joint.h"
#include "joints/prismatic_joint.h"
#include "joints/revolute_joint.h"
#include "joints/spherical_joint.h"
#include "joints/universal_joint.h"
#include "tests/reference/benchmark.h"
#include "tests/reference/mechanism.h"
#include "tests/support/linear_algebra.h"

namespace lithe::test::known_failures_test {
namespace {

const Matrix3 kAlongX = axes_with_z({1, 0, 0}, {0, 1, 0}), kAlongY = axes_with_z({0, 1, 0}, {1, 0, 0});

/// G at the scene's state, dense.
MatrixX jacobian(Scene& scene) {
  const int nv = scene.system.layout().v_count(), rows = scene.system.layout().row_count();
  scene.equations.evaluate(scene.state.time, scene.state.q, scene.state.v, Level::velocity);
  scene.equations.factorize({0, 0, 1}, VectorX::Zero(nv), VectorX::Zero(rows), nullptr);
  MatrixX G = MatrixX::Zero(rows, nv);
  scene.equations.visit_blocks([&](int row, int column, ConstMatrixRef block) {
    if (row >= nv && column < nv) G.block(row - nv, column, block.rows(), block.cols()) = block;
  });
  return G;
}

/// As many rows are named as a singular value decomposition finds too many, and those left are independent.
void expect_redundant(Scene& scene, int count) {
  const MatrixX G = jacobian(scene);
  const int independent = rank(G, 1e-8);
  EXPECT_EQ(G.rows() - independent, count);
  EXPECT_EQ(static_cast<int>(scene.system.redundant_rows().size()), count);
  MatrixX kept(independent, G.cols());
  int row = 0, k = 0;
  for (int r = 0; r < G.rows(); ++r) {
    const auto& redundant = scene.system.redundant_rows();
    if (k < static_cast<int>(redundant.size()) && redundant[k].row == r) {
      EXPECT_FALSE(redundant[k++].name.empty());
      continue;
    }
    if (row < independent) kept.row(row) = G.row(r);
    ++row;
  }
  EXPECT_EQ(row, independent);
  const VectorX left = singular_values(kept);
  EXPECT_GT(left[independent - 1], 1e-6 * left[0]);
}

TEST(KnownFailures, DistanceInADrivenSliderCrankGivesTheAccelerationsOfTheRodsEnds) {
  constexpr double r = 0.3, l = 0.7, start = 0.4, speed = 5, growth = 3;
  const auto law = [=](double t) {
    return Motion{start + speed * t + 0.5 * growth * t * t, speed + growth * t, growth};
  };
  struct Slider {
    double x, v, a;
  };
  const auto slider_at = [=](double t) -> Slider {
    const Motion th = law(t);
    const double u = r * std::sin(th.value), c = r * std::cos(th.value), s = std::sqrt(l * l - u * u);
    const double first = -u - u * c / s, second = -c - (c * c - u * u) / s - u * u * c * c / (s * s * s);
    return {c + s, first * th.rate, second * th.rate * th.rate + first * th.acceleration};
  };
  for (const bool explicit_method : {true, false}) {
    Scene scene({0, -9.81, 0}, [&](SystemGraph& graph) {
      const Vector3 pin(r * std::cos(start), r * std::sin(start), 0), end(slider_at(0).x, 0, 0), O(0, 0, 0);
      const Part crank = rod(graph, "crank", O, pin, 1, 0, O, speed * Vector3(-pin.y(), pin.x(), 0));
      const Part slider(graph, "slider", 2, {1, 1, 1}, end, Matrix3::Identity(), {slider_at(0).v, 0, 0});
      graph.add<RevoluteJoint>("bearing", {graph.ground().marker(), crank.at(O)});
      graph.add<CoordinateDrive>("motor", {angle_between(graph.ground().marker(), crank.body.marker())},
                                 {.motion = law});
      graph.add<PrismaticJoint>("guide", {graph.ground().marker(O, kAlongX), slider.at(end, kAlongX)});
      graph.add<DistanceJoint>("rod", {crank.at(pin), slider.at(end)}, {.length = l});
    });
    expect_redundant(scene, 0);
    Method method = explicit_method ? runge_kutta(1e-9) : index2(1e-3);
    double position = 0, velocity = 0, pin = 0, slider = 0, g = 0;
    for (int i = 1; i <= 100; ++i) {
      const double t = 0.02 * i;
      ASSERT_NO_FATAL_FAILURE(scene.run(*method, t));
      const Motion th = law(t);
      const Slider exact = slider_at(t);
      const Vector3 p = r * Vector3(std::cos(th.value), std::sin(th.value), 0), across(-p.y(), p.x(), 0);
      // The pin is at twice the crank's centre of mass.
      const Vector3 pin_acceleration = th.acceleration * across - th.rate * th.rate * p;
      pin = std::max(pin, (2 * scene.state.v_dot.head<3>() - pin_acceleration).norm() / pin_acceleration.norm());
      slider = std::max(slider, std::abs(scene.state.v_dot[6] - exact.a) / (r * th.rate * th.rate));
      position = std::max(position, std::abs(scene.position(1).x() - exact.x));
      velocity = std::max(velocity, std::abs(scene.state.v[6] - exact.v));
      g = std::max(g, scene.violation(Level::position));
    }
    const std::string name = "driven slider-crank, " + method->name();
    expect_below(name + ", slider (m)", position, 1e-10);
    expect_below(name + ", slider's speed (m/s)", velocity, 1e-9);
    // The generalized-alpha method's own v̇ is of second order.
    expect_below(name + ", acceleration of the pin (relative)", pin, explicit_method ? 1e-10 : 3e-3);
    expect_below(name + ", acceleration of the slider (of r θ̇²)", slider, explicit_method ? 1e-10 : 3e-3);
    expect_below(name + ", |g|", g, 1e-10);
  }
}

TEST(KnownFailures, ScottRussellLinkageOfHingesIsOverConstrainedAndDrawsItsStraightLine) {
  // Crank O-C, link A-B with C its middle, a slider at A on x and one at B on y: either is enough.
  constexpr double a = 0.5, start = 0.7, speed = 4;
  Scene scene({0, -9.81, 0}, [&](SystemGraph& graph) {
    const double c = std::cos(start), s = std::sin(start);
    const Vector3 O(0, 0, 0), C(a * c, a * s, 0), A(2 * a * c, 0, 0), B(0, 2 * a * s, 0);
    const Vector3 v_C = speed * Vector3(-C.y(), C.x(), 0), v_A(-2 * speed * C.y(), 0, 0), v_B(0, 2 * speed * C.x(), 0);
    const Part crank = rod(graph, "crank", O, C, 1, 0, O, v_C), link = rod(graph, "link", A, B, 2, 0, v_A, v_B);
    const Part at_A(graph, "slider A", 1, {1, 1, 1}, A, Matrix3::Identity(), v_A);
    const Part at_B(graph, "slider B", 1, {1, 1, 1}, B, Matrix3::Identity(), v_B);
    graph.add<RevoluteJoint>("O", {graph.ground().marker(), crank.at(O)});
    graph.add<RevoluteJoint>("C", {crank.at(C), link.at(C)});
    graph.add<RevoluteJoint>("A", {link.at(A), at_A.at(A)});
    graph.add<RevoluteJoint>("B", {link.at(B), at_B.at(B)});
    graph.add<PrismaticJoint>("guide A", {graph.ground().marker(O, kAlongX), at_A.at(A, kAlongX)});
    graph.add<PrismaticJoint>("guide B", {graph.ground().marker(O, kAlongY), at_B.at(B, kAlongY)});
  });
  expect_redundant(scene, 7);
  EXPECT_EQ(scene.system.degrees_of_freedom(), 1);
  // One coordinate: the crank's angle. Every mass moves with it; heights: crank a/2, link's centre a, B 2a times sin.
  constexpr double inertia_crank = a * a / 3, inertia_link = 2 * (a * a + a * a / 3);
  const auto rates = [&](double th, double w) {
    // ½ I(th) w², I = crank + link + 4 a² sin² (A) + 4 a² cos² (B) = constant, for equal sliders.
    const double I = inertia_crank + inertia_link + 4 * a * a;
    return std::pair{w, -9.81 * (a / 2 + 2 * a + 2 * a) * std::cos(th) / I};
  };
  double th = start, w = speed, angle = 0, line = 0, g = 0, g_dot = 0;
  const double energy = scene.energy();
  double drift = 0, turned = 0;
  Method method = runge_kutta(1e-9);
  for (int i = 1; i <= 150; ++i) {
    for (int k = 0; k < 20; ++k) {  // classical Runge-Kutta, 1 ms
      constexpr double h = 1e-3;
      const auto [k1, l1] = rates(th, w);
      const auto [k2, l2] = rates(th + h / 2 * k1, w + h / 2 * l1);
      const auto [k3, l3] = rates(th + h / 2 * k2, w + h / 2 * l2);
      const auto [k4, l4] = rates(th + h * k3, w + h * l3);
      th += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4), w += h / 6 * (l1 + 2 * l2 + 2 * l3 + l4);
    }
    ASSERT_NO_FATAL_FAILURE(scene.run(*method, 0.02 * i));
    turned = std::max(turned, std::abs(th - start));
    angle = std::max(angle, (2 * scene.position(0) - a * Vector3(std::cos(th), std::sin(th), 0)).norm());
    line = std::max(line, std::abs(scene.position(3).x()));
    drift = std::max(drift, std::abs(scene.energy() - energy));
    g = std::max(g, scene.violation(Level::position));
    g_dot = std::max(g_dot, scene.violation(Level::velocity));
  }
  EXPECT_GT(turned, 2);  // it does pass the dead centres
  expect_below("Scott-Russell, crank pin (m)", angle, 1e-7);
  expect_below("Scott-Russell, B off its line (m)", line, 1e-10);
  expect_below("Scott-Russell, energy (J)", drift, 1e-6);
  expect_below("Scott-Russell, |g| of all rows", g, 1e-10);
  expect_below("Scott-Russell, |G v| of all rows", g_dot, 1e-9);
}

/// A platform's prescribed motion: p(t), and a turn by phi(t) about n.
struct PlatformMotion {
  Vector3 p, v, a;
  Motion phi;
};
const Vector3 kAxis = Vector3(1, 2, 3).normalized();
PlatformMotion platform(double t) {
  const double s = std::sin(3 * t), c = std::cos(3 * t);
  const Vector3 swing(0.2, 0.1, -0.15);
  return {Vector3(0, 0, 1) + swing * s,
          3 * swing * c,
          -9 * swing * s,
          {0.3 * std::sin(2 * t), 0.6 * std::cos(2 * t), -1.2 * std::sin(2 * t)}};
}
Matrix3 turn(double phi) { return Eigen::AngleAxisd(phi, kAxis).matrix(); }

TEST(KnownFailures, StewartPlatformFollowsItsSixDrivenLegs) {
  const auto corner = [](double radius, double angle) {
    return Vector3(radius * std::cos(angle), radius * std::sin(angle), 0);
  };
  std::array<Vector3, 6> base, top;
  for (int i = 0; i < 6; ++i) {
    base[i] = corner(1, M_PI / 3 * (i + i % 2) + (i % 2 ? -0.2 : 0.2));
    top[i] = corner(0.6, M_PI / 3 * (i + 1 - i % 2) + (i % 2 ? 0.2 : -0.2));
  }
  Scene scene({0, 0, -9.81}, [&](SystemGraph& graph) {
    const PlatformMotion now = platform(0);
    const Vector3 spin = now.phi.rate * kAxis;
    const Part plate(graph, "platform", 10, {1, 1, 2}, now.p, Matrix3::Identity(), now.v, spin);
    for (int i = 0; i < 6; ++i) {
      const std::string number = std::to_string(i + 1);
      const Vector3 foot = base[i], head = now.p + top[i], d = head - foot, v = now.v + spin.cross(top[i]);
      const Vector3 omega = d.cross(v) / d.squaredNorm();
      const Matrix3 axes = axes_with_z(d);
      const Vector3 low = foot + 0.25 * d, high = foot + 0.75 * d;
      const Part cylinder(graph, "cylinder " + number, 1, {0.02, 0.02, 0.001}, low, axes, omega.cross(low - foot),
                          omega);
      const Part piston(graph, "piston " + number, 0.5, {0.01, 0.01, 0.001}, high, axes,
                        omega.cross(high - foot) + v.dot(d) / d.squaredNorm() * d, omega);
      graph.add<UniversalJoint>("foot " + number, {graph.ground().marker(foot, axes), cylinder.at(foot, axes)});
      auto& leg = graph.add<PrismaticJoint>("leg " + number, {cylinder.at(foot, axes), piston.at(head, axes)});
      graph.add<SphericalJoint>("head " + number, {piston.at(head), plate.at(head)});
      graph.add<CoordinateDrive>("drive " + number, {leg.displacement()}, {.motion = [foot, b = top[i]](double t) {
                                   const PlatformMotion m = platform(t);
                                   const Vector3 arm = turn(m.phi.value) * b, across = kAxis.cross(arm);
                                   const Vector3 e = m.p + arm - foot, e1 = m.v + m.phi.rate * across;
                                   const Vector3 e2 = m.a + m.phi.acceleration * across +
                                                      m.phi.rate * m.phi.rate * kAxis.cross(across);
                                   const double L = e.norm(), L1 = e.dot(e1) / L;
                                   return Motion{L, L1, (e1.dot(e1) + e.dot(e2) - L1 * L1) / L};
                                 }});
    }
  });
  EXPECT_EQ(scene.system.degrees_of_freedom(), 0);
  expect_redundant(scene, 0);
  Method method = runge_kutta(1e-9);
  double p = 0, v = 0, a = 0, attitude = 0, g = 0;
  for (int i = 1; i <= 50; ++i) {
    ASSERT_NO_FATAL_FAILURE(scene.run(*method, 0.04 * i));
    const PlatformMotion exact = platform(0.04 * i);
    p = std::max(p, (scene.position(0) - exact.p).norm());
    attitude = std::max(attitude, (rotation_matrix(scene.state.q.segment<4>(3)) - turn(exact.phi.value)).norm());
    v = std::max(v, (scene.state.v.head<3>() - exact.v).norm());
    a = std::max(a, (scene.state.v_dot.head<3>() - exact.a).norm());
    g = std::max(g, scene.violation(Level::position));
  }
  expect_below("Stewart platform, position (m)", p, 1e-10);
  expect_below("Stewart platform, attitude (rad)", attitude, 1e-10);
  expect_below("Stewart platform, velocity (m/s)", v, 1e-9);
  expect_below("Stewart platform, acceleration (m/s²)", a, 1e-8);
  expect_below("Stewart platform, |g|", g, 1e-10);
}

constexpr double kBar = 1, kStart = M_PI / 4;  // length, m; angle from the horizontal; bars weigh 1 kg

/// n x n units of two bars crossing in their middles, all hinges 3-D about z; the lower left corner is pinned, the next
/// one along x kept at its height. Bars 2 (i + n j) rise to the right, the next ones to the left.
Scene scissor_grid(int n) {
  return Scene({0, -9.81, 0}, [&](SystemGraph& graph) {
    const double w = kBar * std::cos(kStart), h = kBar * std::sin(kStart);
    const auto at = [&](int i, int j) { return Vector3(i * w, j * h, 0); };
    struct End {
      const Part* part;
      Vector3 point;
    };
    std::vector<Part> bars;
    bars.reserve(2 * n * n);
    std::vector<std::vector<End>> corners((n + 1) * (n + 1));
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        const std::string unit = std::to_string(i) + "," + std::to_string(j);
        const auto add = [&](const std::string& name, int i0, int j0, int i1, int j1) {
          bars.push_back(rod(graph, name + " " + unit, at(i0, j0), at(i1, j1), 1));
          corners[i0 + (n + 1) * j0].push_back({&bars.back(), at(i0, j0)});
          corners[i1 + (n + 1) * j1].push_back({&bars.back(), at(i1, j1)});
          return &bars.back();
        };
        const Part* rising = add("rising", i, j, i + 1, j + 1);
        const Part* falling = add("falling", i + 1, j, i, j + 1);
        const Vector3 middle = (at(i, j) + at(i + 1, j + 1)) / 2;
        graph.add<RevoluteJoint>("middle " + unit, {rising->at(middle), falling->at(middle)});
      }
    for (std::size_t c = 0; c < corners.size(); ++c)
      for (std::size_t k = 1; k < corners[c].size(); ++k)
        graph.add<RevoluteJoint>(
            "corner " + std::to_string(c) + "." + std::to_string(k),
            {corners[c][0].part->at(corners[c][0].point), corners[c][k].part->at(corners[c][k].point)});
    graph.add<RevoluteJoint>("pin", {graph.ground().marker(), bars[0].at(at(0, 0))});
    graph.add<CoordinateDrive>("rail",
                               {displacement_between(graph.ground().marker({0, 0, 0}, kAlongY), bars[1].at(at(1, 0)))},
                               {.motion = constant(0)});
  });
}

/// The grid has one coordinate, its bars' angle: centres at ((i + ½) L cos, (j + ½) L sin).
std::pair<double, double> grid_rates(int n, double th, double w) {
  double squares = 0, heights = 0;  // Σ (i + ½)², Σ (j + ½), over bars
  for (int k = 0; k < n; ++k) squares += 2 * n * (k + 0.5) * (k + 0.5), heights += 2 * n * (k + 0.5);
  // I = 2 n² L²/12 + squares L² (sin² + cos²): constant.
  const double I = 2 * n * n * kBar * kBar / 12 + squares * kBar * kBar;
  return {w, -9.81 * heights * kBar * std::cos(th) / I};
}

void check_grid(int n, Method method, double end, double bound) {
  Scene scene = scissor_grid(n);
  const int revolutes = n * n + 3 * (n - 1) * (n - 1) + 4 * (n - 1) + 1, rank = 12 * n * n - 1;
  EXPECT_EQ(scene.system.layout().row_count(), 5 * revolutes + 1);
  EXPECT_EQ(scene.system.rank(), rank);
  EXPECT_EQ(scene.system.degrees_of_freedom(), 1);
  if (n < 5) expect_redundant(scene, 5 * revolutes + 1 - rank);
  const double energy = scene.energy();
  double th = kStart, w = 0, g = 0, corner = 0, drift = 0;
  for (int i = 1; i <= 10; ++i) {
    for (int k = 0; k < 100; ++k) {
      const double h = end / 1000;
      const auto [k1, l1] = grid_rates(n, th, w);
      const auto [k2, l2] = grid_rates(n, th + h / 2 * k1, w + h / 2 * l1);
      const auto [k3, l3] = grid_rates(n, th + h / 2 * k2, w + h / 2 * l2);
      const auto [k4, l4] = grid_rates(n, th + h * k3, w + h * l3);
      th += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4), w += h / 6 * (l1 + 2 * l2 + 2 * l3 + l4);
    }
    ASSERT_NO_FATAL_FAILURE(scene.run(*method, end * i / 10));
    for (int body = 0; body < 2 * n * n; ++body) {
      const int unit = body / 2;
      const Vector3 center((unit % n + 0.5) * std::cos(th), (unit / n + 0.5) * std::sin(th), 0);
      corner = std::max(corner, (scene.position(body) - kBar * center).norm());
    }
    drift = std::max(drift, std::abs(scene.energy() / energy - 1));
    g = std::max(g, scene.violation(Level::position));
  }
  EXPECT_LT(th, 0.9 * kStart);
  const std::string name = "scissor grid " + std::to_string(n) + " x " + std::to_string(n) + ", " + method->name();
  expect_below(name + ", centres of bars (m)", corner, bound);
  expect_below(name + ", energy (relative)", drift, bound);
  expect_below(name + ", |g| of all rows", g, 1e-10);
}

TEST(KnownFailures, ScissorGridMovesAsOne) {
  check_grid(3, runge_kutta(1e-8), 0.3, 1e-8);
  check_grid(10, index2(5e-3), 0.5, 2e-5);
}

}  // namespace
}  // namespace lithe::test::known_failures_test
