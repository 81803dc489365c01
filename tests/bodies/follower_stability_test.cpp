#include <gtest/gtest.h>

#include <algorithm>
#include <complex>
#include <utility>

#include "bodies/beam/beam.h"
#include "engine/analysis/equilibrium.h"
#include "engine/analysis/linearization.h"
#include "joints/fixed_joint.h"
#include "joints/forces/line_load.h"
#include "joints/forces/point_force.h"
#include "tests/support/methods.h"

/// Columns under thrusts that follow them lose their stability by flutter: two frequencies meet and become a growing
/// and a dying oscillation. No static method finds it.
namespace lithe::test::follower_stability_test {
namespace {

enum class Thrust { at_the_end, along };

/// A clamped column of length, EI and mass 1 that bends in one plane, hardly stretches, shears or turns.
struct Column {
  Thrust thrust;
  int elements;

  Linearization under(double load) const {
    constexpr double kSlender = 1e8;
    SystemGraph graph{{.gravity = Vector3::Zero()}};
    auto& beam = graph.add<Beam>(
        "column", {.axis = BeamAxis::straight({0, 0, 0}, {1, 0, 0}, {0, 1, 0}),
                   .sections = {{0, BeamSection::diagonal({kSlender, kSlender, kSlender, 100, 1000, 1}, 1,
                                                          {2 / kSlender, 1 / kSlender, 1 / kSlender})}},
                   .elements = elements});
    graph.add<FixedJoint>("clamp", {graph.ground().marker({0, 0, 0}, beam.axes(0)), beam.marker(0)});
    if (thrust == Thrust::at_the_end)
      graph.add<PointForce>("thrust", {beam.marker(1)}, {.force = {-load, 0, 0}, .axes = PointForce::Axes::marker});
    else
      add_line_load(graph, "thrust", beam, {.density = {{0, force({-load, 0, 0})}}, .axes = LineLoad::Axes::section});
    const System system = assemble(graph);
    return linearize(system, find_equilibrium(system, system.initial_state()).state);
  }

  /// (s₁² - s₂²)² of the two slowest modes: positive while they oscillate, zero where they meet, negative in flutter.
  static double apart(const Linearization& about) {
    std::vector<std::complex<double>> s;
    for (const Mode& mode : about.modes) s.push_back(mode.eigenvalue);
    std::partial_sort(s.begin(), s.begin() + 2, s.end(), [](auto a, auto b) { return std::abs(a) < std::abs(b); });
    return ((s[0] * s[0] - s[1] * s[1]) * (s[0] * s[0] - s[1] * s[1])).real();
  }

  /// Where they meet, near `guess`, by secants.
  double flutter(double guess) const {
    double last = 0.97 * guess, load = guess, at_last = apart(under(last));
    for (int i = 0; i < 3; ++i) {
      const double here = apart(under(load));
      last = std::exchange(load, load - here * (load - last) / (here - at_last));
      at_last = here;
    }
    return load;
  }
};

void check(const std::string& what, Thrust thrust, double exact) {
  double found[3];
  for (int k = 0; k < 3; ++k) found[k] = Column{thrust, 5 << k}.flutter(exact);
  const double first = (4 * found[1] - found[0]) / 3, second = (4 * found[2] - found[1]) / 3;
  expect_below(what + ", 20 elements", std::abs(found[2] / exact - 1), 0.02);
  expect_below(what + ", extrapolated", std::abs((16 * second - first) / 15 / exact - 1), 4e-5);
  const Column column{thrust, 10};
  for (const double share : {0.5, 0.99, 1.01, 1.1}) {
    const Linearization about = column.under(share * found[1]);
    const auto growing = std::max_element(about.modes.begin(), about.modes.end(),
                                          [](const Mode& a, const Mode& b) { return a.growth() < b.growth(); });
    if (share < 1) {
      EXPECT_LT(growing->growth(), 1e-4) << share;
    } else {
      EXPECT_GT(growing->growth(), 0.5) << share;
      EXPECT_NEAR(2 * M_PI * growing->frequency(), 11, 1) << "it flutters, and does not buckle, at " << share;
    }
  }
}

/// M. Beck, ZAMP 3 (1952) 225; V. V. Bolotin, Nonconservative Problems of the Theory of Elastic Stability, 1963:
/// 20.05 EI/L².
TEST(FollowerStability, OfBecksColumn) { check("Beck's column", Thrust::at_the_end, 20.050954); }

/// H. Leipholz, ZAMP 13 (1962) 581: 40.05 EI/L³.
TEST(FollowerStability, OfLeipholzsColumn) { check("Leipholz's column", Thrust::along, 40.053737); }

}  // namespace
}  // namespace lithe::test::follower_stability_test
