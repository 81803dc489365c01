// S08: seven windows by elimination at acceleration level: every crossing multiplies the branch error.
#include "engine/study/study_run.h"
#include "tools/stability/lab.h"
#include "tools/stability/methods/explicit_index1.h"
#include "tools/stability/scenes/candidates.h"
#include "tools/stability/scenes/natural_rods.h"

namespace lithe::lab {
namespace {

constexpr NaturalRods::Parameters kSeven{.windows = 7, .length = 0.8, .mass = 2, .speed = 1.5};
constexpr double kEnd = 6, kLimit = 1e-6, kLost = 1;  // s, J, J
constexpr int kCrossings = 6;

/// The energy error when so many crossings of the horizontal lie behind, and at the end.
Finding cross(Integrator& method, const NaturalRods::Parameters& parameters, double end, const std::string& why) {
  Windows scene(parameters);
  const double start = scene.energy();
  std::vector<double> after;
  double height = scene.state.q[1];
  const auto course = scene.run(
      method, end,
      [&] {
        const double now = scene.state.q[1];
        if (now * height < 0 && after.size() < kCrossings) after.push_back(std::abs(scene.energy() - start));
        height = now;
      },
      1e9);
  const double tip =
      std::abs(std::remainder(scene.angle(0) - parallelogram_angle(parameters, scene.state.time), 2 * M_PI));
  Finding finding{judged(course.energy_error, kLimit, kLost), {{"energy error, J", course.energy_error}}, why};
  if (!course.reached) finding.outcome = Outcome::unstable;
  for (std::size_t i = 0; i < after.size(); ++i)
    finding.figures.push_back({"at crossing " + std::to_string(i + 1), after[i]});
  finding.figures.push_back({"error of the angle at the end, rad", tip});
  finding.figures.push_back({"difference of uprights, rad", scene.mismatch()});
  return finding;
}

Finding by_elimination() {
  ExplicitIndex1 method({.step = 2e-4, .solver = ExplicitIndex1::Solver::rows_once_a_step, .cut = 1e-14});
  return cross(method, kSeven, kEnd, "every crossing multiplies the branch error");
}

Finding least_norm_projected() {
  ExplicitIndex1 method({.step = 5e-4,
                         .stabilisation = ExplicitIndex1::Stabilisation::position_velocity,
                         .solver = ExplicitIndex1::Solver::least_norm,
                         .cut = 1e-9});
  return cross(method, {}, 4, "the branch is held by the projection");
}

const Registered scene{under_every_method(
    {"S08",
     "singular configuration, fixed independent constraints",
     {{"index 1 by elimination", by_elimination},
      {"minimum-norm multipliers plus position projection (N = 2)", least_norm_projected},
      {"explicit Runge-Kutta 5(4), 1e-9, N = 2", [] { return cross(*runge_kutta(1e-9), {}, 4, ""); }, Role::ours},
      {"library's explicit Runge-Kutta, 1e-9, N = 7", [] { return cross(*runge_kutta(1e-9), kSeven, kEnd, ""); },
       Role::also}}},
    {1e-9, 1e-3}, [](Integrator& method) { return cross(method, {}, 4, ""); })};

}  // namespace
}  // namespace lithe::lab
