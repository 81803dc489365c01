// S07: two four-bar windows pass positions where they could change to the antiparallelogram; noise decides.
#include <random>

#include "tools/stability/lab.h"
#include "tools/stability/methods/plain_alpha.h"
#include "tools/stability/scenes/candidates.h"
#include "tools/stability/scenes/natural_rods.h"

namespace lithe::lab {
namespace {

constexpr double kEnd = 10, kStep = 0.002;          // s
constexpr double kEnergy = 0.01, kMismatch = 1e-6;  // J, rad
constexpr double kExploded = 1e3;                   // J

struct Published {
  double energy = NAN, mismatch = NAN;
  int digits = 2;
};

/// Normal noise of so many metres is added to every coordinate after every step.
Finding pass(Integrator& method, double noise, const Published& published, const std::string& why, int seed = 1) {
  Windows scene({});
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal;
  double mismatch = 0;
  const auto course = scene.run(
      method, kEnd,
      [&] {
        if (noise > 0)
          for (int i = 0; i < scene.state.q.size(); ++i) scene.state.q[i] += noise * normal(generator);
        mismatch = std::max(mismatch, scene.mismatch());
      },
      1e12);
  Outcome outcome = course.energy_error < kEnergy && mismatch < kMismatch ? Outcome::converged : Outcome::inaccurate;
  if (!course.reached || course.energy_error > kExploded) outcome = Outcome::unstable;
  return {outcome,
          {{"energy error, J", course.energy_error, published.energy, published.digits},
           {"difference of uprights, rad", mismatch, published.mismatch, 0},
           {"steps whose Newton did not converge", static_cast<double>(method.statistics().newton_failures)},
           {"seconds simulated", course.end}},
          why};
}

Finding dense_lu(double noise, const Published& published) {
  PlainAlpha method({.step = kStep, .spectral_radius = 0.9, .solver = PlainAlpha::Solver::dense_lu});
  return pass(method, noise, published, "step does not hit the rank drop");
}

/// Without noise and with a little: the worse of the two is the figure.
Finding quiet() {
  const Finding none = dense_lu(0, {5.0e-3}), little = dense_lu(1e-9, {5.0e-3, 6e-9});
  return none.outcome == Outcome::converged ? little : none;
}

/// What noise does depends on where it meets the crossings: the worst of five sequences.
Finding noisy() {
  Finding worst;
  for (int seed = 1; seed <= 5; ++seed) {
    PlainAlpha method({.step = kStep, .spectral_radius = 0.9});
    Finding finding = pass(method, 1e-6, {1.33, NAN, 0}, "noise comparable with the branch gap; worst of five", seed);
    if (seed == 1 || !(finding.figures[0].value < worst.figures[0].value)) worst = std::move(finding);
  }
  return worst;
}

/// Below 1e-4 of the largest singular value the branch gap is cut off too.
Finding truncated() {
  PlainAlpha method(
      {.step = kStep, .spectral_radius = 0.9, .solver = PlainAlpha::Solver::truncated_least_squares, .cut = 1e-4});
  // The published size, 1.6e10 J, is that of one sequence of random numbers: only the explosion is the figure.
  return pass(method, 1e-6, {}, "rank cut at the wrong place loses a constraint");
}

const Registered scene{under_every_method(
    {"S07",
     "singular configuration, stepping through",
     {{"LU, no noise or noise 1e-9", quiet},
      {"LU, position noise 1e-6 per step", noisy},
      {"truncated least squares, noise 1e-6", truncated},
      {"generalized-alpha, index 3", [] { return pass(*alpha_index3(kStep), 0, {}, ""); }, Role::ours},
      {"generalized-alpha, index 2", [] { return pass(*alpha_index2(kStep), 0, {}, ""); }, Role::ours},
      {"explicit Runge-Kutta 5(4), 1e-8", [] { return pass(*runge_kutta(1e-8), 0, {}, ""); }, Role::ours}}},
    {1e-8, kStep}, [](Integrator& method) { return pass(method, 0, {}, ""); })};

}  // namespace
}  // namespace lithe::lab
