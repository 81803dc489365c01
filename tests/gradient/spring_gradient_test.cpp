// A mass on a spring by Radau, backwards: thousands of looks at the elements' tangents and at differenced columns.
#include "bodies/point_mass.h"
#include "engine/gradient/differences.h"
#include "integrators/radau.h"
#include "joints/forces/spring_damper.h"
#include "tests/gradient/gradient_support.h"

namespace lithe::test {
namespace {

constexpr double kSpringLength = 100;  // m: its last bits are 1e-14 m

MakeIntegrator spring_radau(double step) {
  return [=] { return std::make_unique<Radau>(Radau::Parameters{.step = step, .newton_tolerance = 1e-13}); };
}

/// It swings along the spring, which is drawn out and pressed together.
ParametricScene mass_on_a_spring(double duration, MakeIntegrator integrator) {
  return {.name = "mass on a spring",
          .duration = duration,
          .gravity = {0, 0, 0},
          .draw =
              [](SystemGraph& graph, const SweepPoint& p) {
                auto& mass = graph.add<PointMass>(
                    "mass", {.mass = p["mass"], .position = {0, 0, -kSpringLength}, .velocity = {0, 0, p["speed"]}});
                graph.add<SpringDamper>(
                    "spring", {graph.ground().marker(), mass.marker()},
                    {.stiffness = p["stiffness"], .damping = p["damping"], .natural_length = kSpringLength});
                return std::vector<Sensor>{position(mass.marker(), "p")};
              },
          .integrator = std::move(integrator)};
}

/// x = v/ω_d e^{-δt} sin ω_d t, δ = c/(2m), ω_d² = k/m - δ²: its derivatives by k, m, c and v times these.
Eigen::RowVector4d of_closed_form(double k, double m, double c, double v, double t) {
  const double delta = c / (2 * m), w = std::sqrt(k / m - delta * delta), fade = std::exp(-delta * t);
  const double by_w = v * fade * (t * std::cos(w * t) / w - std::sin(w * t) / (w * w)),
               by_delta = -t * v * fade * std::sin(w * t) / w;
  const double delta_by_m = -delta / m, delta_by_c = 1 / (2 * m);
  const double w_by_k = 1 / (2 * m * w), w_by_m = (-k / (m * m) / 2 - delta * delta_by_m) / w,
               w_by_c = -delta * delta_by_c / w;
  return {k * by_w * w_by_k, m * (by_w * w_by_m + by_delta * delta_by_m), c * (by_w * w_by_c + by_delta * delta_by_c),
          v * fade * std::sin(w * t) / w};
}

/// A direction along which the spring's forces nearly cancel is no refusal: by looks of 3 a step some are sure to come.
TEST(SpringGradients, OfAMassOnALongSpringBackwards) {
  const double m = 2, k = 800, v = 1.5, c = 0.4;
  for (const double duration : {0.0635, 2.0}) {
    const Gradient found = gradient(mass_on_a_spring(duration, spring_radau(1e-3)), {value_at("p_z", duration)},
                                    {{"stiffness", k}, {"mass", m}, {"damping", c}, {"speed", v}},
                                    {.mode = GradientOptions::Mode::adjoint});
    const Eigen::RowVector4d expected = of_closed_form(k, m, c, v, duration);
    const Eigen::RowVector4d of_found = found.derivatives.cwiseProduct(Eigen::RowVector4d(k, m, c, v));
    const double off = (of_found - expected).lpNorm<Eigen::Infinity>() / expected.lpNorm<Eigen::Infinity>();
    if (std::getenv("LITHE_SHOW_ERRORS")) std::printf("%g s, %ld steps: off %.1e\n", duration, found.steps, off);
    EXPECT_LT(off, 1e-8);
  }
}

/// Without a choice of steps, by error control at several tolerances.
TEST(SpringGradients, OfAMassOnASpringByErrorControl) {
  const double m = 0.15, k = 5900, v = 1, c = 2.7, duration = 0.3;
  for (const double tolerance : {1e-8, 1e-10, 1e-12}) {
    const auto automatic = [=] {
      return std::make_unique<Radau>(Radau::Parameters{.tolerance = {.relative = tolerance, .absolute = tolerance}});
    };
    const Gradient found = gradient(mass_on_a_spring(duration, automatic), {value_at("p_z", duration)},
                                    {{"stiffness", k}, {"mass", m}, {"damping", c}, {"speed", v}},
                                    {.mode = GradientOptions::Mode::adjoint});
    const Eigen::RowVector4d expected = of_closed_form(k, m, c, v, duration);
    const Eigen::RowVector4d of_found = found.derivatives.cwiseProduct(Eigen::RowVector4d(k, m, c, v));
    const double off = (of_found - expected).lpNorm<Eigen::Infinity>() / (v * duration);
    if (std::getenv("LITHE_SHOW_ERRORS")) std::printf("%g: %ld steps, off %.1e\n", tolerance, found.steps, off);
    EXPECT_LT(off, std::max(1e-8, 10 * tolerance));
  }
}

/// A slope beside terms that cancel. Small steps leave nothing of it, and so look as if they agreed best.
TEST(SpringGradients, DifferencesKeepASlopeThatDrownsInWhatCancels) {
  const double slope = 3.66e-6, terms = 71, h = 1.4e-4;
  const auto f = [&](double t) -> VectorX {
    volatile const double sum = terms + slope * t;  // rounded
    return VectorX::Constant(1, sum - terms);
  };
  double scale = 0;
  EXPECT_NEAR(difference(h, true, scale, f, terms)[0], slope, kTermRoundOff * terms / h);
}

}  // namespace
}  // namespace lithe::test
