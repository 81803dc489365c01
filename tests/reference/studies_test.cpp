// The scenes of examples/studies/ move as the benchmarks that they are taken from.
#include <gtest/gtest.h>

#include "engine/study/study_run.h"
#include "integrators/catalogue.h"
#include "lithe/lithe.h"
#include "tests/reference/benchmark.h"
#include "tests/support/linear_algebra.h"

// Each has a function scene() and its own helpers.
namespace lithe::test::top_study {
#include "examples/studies/heavy_top.cpp"
}
namespace lithe::test::squeezer {
#include "examples/studies/andrews_squeezer.cpp"
}
namespace lithe::test::governor {
#include "examples/studies/flyball_governor.cpp"
}
namespace lithe::test::chain {
#include "examples/studies/chain_16.cpp"
}
namespace lithe::test::slider_crank {
#include "examples/studies/flexible_slider_crank.cpp"
}
namespace lithe::test::pendulum {
#include "examples/studies/flexible_pendulum.cpp"
}
namespace lithe::test::spin_up {
#include "examples/studies/beam_spin_up.cpp"
}

namespace lithe::test::studies_test {
namespace {

/// Values of the sensors at the end, by explicit Runge-Kutta.
Table ends(const StudyScene& scene, double time, double tolerance = 1e-9) {
  const StudySystem study(scene);
  const StudyMethod method = select_methods(standard_methods(), {"explicit Runge-Kutta 5(4)"}).front();
  const StudyRun run = run_study(study, method, tolerance, {time}, 60);
  EXPECT_EQ(run.outcome, StudyRun::Outcome::reached) << scene.name << ": " << run.why;
  return run.samples;
}

/// The row of a reference at a time.
int row_at(const Table& table, double time) {
  for (int row = 0; row < table.row_count(); ++row)
    if (std::abs(table.at(row, 0) - time) < 1e-9) return row;
  ADD_FAILURE() << "no row at " << time;
  return 0;
}

TEST(Studies, MoveAsTheirBenchmarks) {
  const Table top = reference("R08_heavy_top/reference_A.csv");
  for (const char* axis : {"x", "y", "z"}) {
    SCOPED_TRACE(axis);
    const double expected = top.column(axis)[row_at(top, 1)];
    EXPECT_NEAR(ends(top_study::scene(), 1).column(std::string("center_") + axis)[0], expected, 1e-7);
  }
  const Table squeezer_table = reference("R03_andrews_squeezer/reference.csv");
  const Table F = ends(squeezer::scene(), 0.03);
  EXPECT_NEAR(F.column("F_x")[0], squeezer_table.column("Fx")[row_at(squeezer_table, 0.03)], 1e-9);
  EXPECT_NEAR(F.column("F_y")[0], squeezer_table.column("Fy")[row_at(squeezer_table, 0.03)], 1e-9);

  const Table governor_table = reference("R05_flyball_governor/reference.csv");
  EXPECT_NEAR(ends(governor::scene(), 2, 1e-7).column("slider")[0],
              governor_table.column("s")[row_at(governor_table, 2)], 1e-7);

  const Table crank = reference("F01_flexible_slider_crank/reference.csv");
  const Table q = ends(slider_crank::scene(), 0.1);
  for (int k = 1; k <= 4; ++k)
    EXPECT_NEAR(q.at(0, k), crank.column("q" + std::to_string(k))[row_at(crank, 0.1)], 1e-9) << "q" << k;

  // Linear in its deformation: a millimetre off nonlinear finite elements, no more.
  const Table calculix = read_csv(std::string(LITHE_EXAMPLE_DATA) + "/pendulum/hex8i/trajectory.csv");
  const Table tip = ends(pendulum::scene(), 1, 1e-7);
  for (int axis : {1, 2, 3}) EXPECT_NEAR(tip.at(0, axis), calculix.at(row_at(calculix, 1), axis), 1e-3);
}

/// Accelerations of the chain's angles a above the horizontal: M(a) ä = h, 1 m and 1 kg a rod, the mass beyond rod k
/// moving with its end.
VectorX chain_accelerations(const VectorX& a, const VectorX& rates) {
  const int n = static_cast<int>(a.size());
  MatrixX M(n, n);
  VectorX h(n);
  for (int i = 0; i < n; ++i) {
    h[i] = -9.81 * (n - 1 - i + 0.5) * std::cos(a[i]);
    for (int k = 0; k < n; ++k) {
      const double w = i == k ? n - 1 - i + 1.0 / 3 : n - 1 - std::max(i, k) + 0.5;
      M(i, k) = w * std::cos(a[i] - a[k]);
      h[i] -= w * std::sin(a[i] - a[k]) * rates[k] * rates[k];
    }
  }
  return solve_positive(M, h);
}

TEST(Studies, TheChainMovesAsItsAnglesDo) {
  // Minimal coordinates, Runge-Kutta of order 4 at 1 ms, as those do whose figures the chart shows.
  const int n = 16;
  const double step = 1e-3;
  VectorX a = VectorX::Zero(n), v = VectorX::Zero(n);
  for (int i = 0; i < 1000; ++i) {
    const VectorX k1 = chain_accelerations(a, v), v2 = v + step / 2 * k1;
    const VectorX k2 = chain_accelerations(a + step / 2 * v, v2), v3 = v + step / 2 * k2;
    const VectorX k3 = chain_accelerations(a + step / 2 * v2, v3), v4 = v + step * k3;
    const VectorX k4 = chain_accelerations(a + step * v3, v4);
    a += step / 6 * (v + 2 * v2 + 2 * v3 + v4);
    v += step / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
  }
  const Table rods = ends(chain::scene(), 1);
  double x = 0, z = 0;
  for (int i = 0; i < n; ++i) {
    x += std::cos(a[i]), z += std::sin(a[i]);
    const std::string name = "end_" + std::to_string(i + 1);
    EXPECT_NEAR(rods.column(name + "_x")[0], x, 1e-8) << name;
    EXPECT_NEAR(rods.column(name + "_z")[0], z, 1e-8) << name;
  }
}

TEST(Studies, TheSpunBeamTurnsWithItsHubAndTrailsBehindIt) {
  // θ(20 s) = Ω (20 - T/2) = 37.5 rad, its speed constant since 15 s; the tip is about 10 m away.
  const Table tip = ends(spin_up::scene(), 20, 1e-7);
  const double x = tip.column("tip_x")[0], y = tip.column("tip_y")[0];
  EXPECT_NEAR(std::hypot(x, y), 10, 0.05);
  EXPECT_NEAR(std::remainder(std::atan2(y, x) - 37.5, 2 * M_PI), 0, 0.05);
}

}  // namespace
}  // namespace lithe::test::studies_test
