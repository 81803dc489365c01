// S09: windows released at rest exactly flat. Several motions begin there; the one with all windows parallelograms is
// nearest to the free fall of the links (Gauss's principle), and comes to rest flat on the other side, where the same
// choice is to be made again.
#include <gtest/gtest.h>

#include "tests/joints/mechanisms.h"
#include "tests/reference/benchmark.h"
#include "tests/reference/loops.h"

namespace lithe::test::singular_start_test {
namespace {

constexpr int kWindows = 2;
/// θ̈ = κ sin θ for parallelograms, θ from the vertical (R02).
constexpr double kKappa = 9.81 * ((kWindows + 1) / 2.0 + kWindows) / ((kWindows + 1) / 3.0 + kWindows);

/// By steps of 1e-4 s of order 4, from time to time + for_time.
void swing(double& angle, double& speed, double for_time) {
  const int steps = static_cast<int>(std::ceil(for_time / 1e-4));
  const double h = for_time / steps;
  const auto rate = [](double x) { return kKappa * std::sin(x); };
  for (int i = 0; i < steps; ++i) {
    const double k1 = rate(angle), k2 = rate(angle + h / 2 * speed), k3 = rate(angle + h / 2 * speed + h * h / 4 * k1),
                 k4 = rate(angle + h * speed + h * h / 2 * k2);
    angle += h * speed + h * h / 6 * (k1 + k2 + k3), speed += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
  }
}

struct Followed {
  double off = 0, spread = 0, gap = 0;  // m
  int told = 0;
};

Followed fall(Integrator& method, double end) {
  Scene scene({0, -9.81, 0}, [&](SystemGraph& graph) { draw_flat_four_bars(graph, kWindows); });
  method.start(scene.equations, scene.state);
  for (int i = 0; i <= kWindows; ++i) EXPECT_NEAR(scene.state.v_dot[6 * i + 5], -kKappa, 1e-5);
  Followed out;
  double angle = kPi / 2, speed = 0;
  for (int k = 1; k <= 20; ++k) {
    swing(angle, speed, end / 20);
    while (scene.state.time < end * k / 20) {
      const StepResult step = method.step(scene.equations, scene.state, end * k / 20);
      if (!step.ok()) {
        ADD_FAILURE() << step.why << " at t = " << scene.state.time;
        return out;
      }
      out.told += step.why.find("several motions are possible") != std::string::npos;
      out.gap = std::max(out.gap, scene.violation(Level::position));
    }
    const Vector3 end_of_upright(std::sin(angle), std::cos(angle), 0);
    out.off = std::max(out.off, (2 * scene.position(0) - end_of_upright).norm());
    for (int i = 1; i <= kWindows; ++i)
      out.spread = std::max(out.spread, (scene.position(i) - scene.position(0) - Vector3(i, 0, 0)).norm());
  }
  return out;
}

TEST(SingularStart, TakesTheMotionThatInertiaAndForcesTell) {
  for (auto& [name, method] : every_method(1e-3)) {
    SCOPED_TRACE(name);
    const Followed run = fall(*method, 0.8);
    EXPECT_EQ(run.told, 1);
    expect_below(name + ", end of the first upright (m)", run.off, 1e-4);  // second order at 1 ms
    expect_below(name + ", uprights leave their parallels (m)", run.spread, 1e-9);
    expect_below(name + ", |g|", run.gap, 1e-8);
  }
}

TEST(SingularStart, IsLeftAndMetAgainAtRestToTensOfNanometres) {
  for (auto make :
       {+[] { return runge_kutta8(1e-10); }, +[] { return automatic(1e-10); }, +[] { return radau(1e-9); }}) {
    const Method method = make();
    SCOPED_TRACE(method->name());
    const Followed run = fall(*method, 2);  // flat again at 1.09 s, at rest
    expect_below(method->name() + ", end of the first upright (m)", run.off, 5e-8);
    expect_below(method->name() + ", uprights leave their parallels (m)", run.spread, 1e-10);
  }
}

}  // namespace
}  // namespace lithe::test::singular_start_test
