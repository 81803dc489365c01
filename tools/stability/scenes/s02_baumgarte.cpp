// S02: Baumgarte's gains: drift below the window, a stiff equation above it.
#include "engine/study/study_run.h"
#include "tools/stability/lab.h"
#include "tools/stability/methods/explicit_index1.h"
#include "tools/stability/scenes/candidates.h"
#include "tools/stability/scenes/pendulum.h"

namespace lithe::lab {
namespace {

constexpr double kEnd = 10, kStep = 0.01;          // s
constexpr double kStretch = 1e-6, kEnergy = 1e-4;  // m, J
constexpr double kDead = 1e3;                      // J: the step that passes it is the last

struct Result {
  Bench::Course course;
  double stretch = 0;
  bool alive() const { return course.reached && course.energy_error < kDead; }
};

Result follow(Integrator& method) {
  Pendulum p;
  Result result;
  result.course = p.run(
      method, kEnd, [&] { result.stretch = std::max(result.stretch, p.stretch()); }, 1e9);
  return result;
}

Result with_gain(double alpha, double step = kStep) {
  ExplicitIndex1 method(
      {.step = step, .stabilisation = ExplicitIndex1::Stabilisation::baumgarte, .alpha = alpha, .beta = alpha});
  return follow(method);
}

Outcome judge(const Result& result) {
  if (!result.alive()) return Outcome::unstable;
  return result.stretch < kStretch && result.course.energy_error < kEnergy ? Outcome::converged : Outcome::inaccurate;
}

Finding gain(double alpha, double published_stretch, double published_energy, const std::string& why) {
  const Result result = with_gain(alpha);
  return {judge(result),
          {{"largest |g|, m", result.stretch, published_stretch},
           {"energy error, J", result.course.energy_error, published_energy, published_energy > 1e-5 ? 2 : 1}},
          why,
          largest_stable_step([&](double h) { return with_gain(alpha, h).alive(); }, 1e-3, 0.1)};
}

/// From 2.75 on: steps that it lives, at gains of 2.75, 3 and 4; the largest alpha h that lives 10 s.
Finding beyond_limit() {
  const Result first = with_gain(2.75 / kStep);
  Outcome outcome = Outcome::unstable;
  for (const double alpha_h : {2.75, 3.0, 4.0})
    if (judge(with_gain(alpha_h / kStep)) != Outcome::unstable) outcome = Outcome::inaccurate;
  const double limit = largest_stable_step([](double alpha_h) { return with_gain(alpha_h / kStep).alive(); }, 2, 4);
  return {outcome,
          {{"steps survived, alpha h = 2.75", static_cast<double>(first.course.steps - 1), 29},
           {"largest alpha h that lives 10 s", limit}},
          "explicit stability limit 2.785",
          largest_stable_step([](double h) { return with_gain(2.75 / kStep, h).alive(); }, 1e-3, kStep)};
}

Finding ours(Integrator& method) {
  const Result result = follow(method);
  return {judge(result), {{"largest |g|, m", result.stretch}, {"energy error, J", result.course.energy_error}}};
}

const Registered scene{under_every_method(
    {"S02",
     "Baumgarte gains",
     {{"alpha h = 0.05", [] { return gain(5, 1.0e-7, 2e-6, "inside the window 0.01 to 0.2"); }},
      {"alpha h = 2", [] { return gain(200, 7.4e-4, 0.040, "stabilisation terms no longer resolved"); }},
      {"alpha h = 2.75 and above", beyond_limit},
      {"explicit Runge-Kutta 5(4), h = 0.01", [] { return ours(*runge_kutta_step(kStep)); }, Role::ours}}},
    {1e-8, kStep}, ours)};

}  // namespace
}  // namespace lithe::lab
