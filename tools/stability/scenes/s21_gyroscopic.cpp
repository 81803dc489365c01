// S21: a body that spins about its middle axis: explicit Euler feeds energy in, implicit Euler eats it.
#include "tools/stability/methods/explicit_index1.h"
#include "tools/stability/methods/theta_rule.h"
#include "tools/stability/scenes/candidates.h"
#include "tools/stability/scenes/free_body.h"

namespace lithe::lab {
namespace {

constexpr double kEnd = 20, kLimit = 1e-6;  // s; of E/E₀ - 1

struct Result {
  double ratio = NAN;  // E/E₀ at the end
  double end = 0;      // s
};
Result spin(Integrator& method) {
  FreeBody body({1, 2, 3}, {0.1, 10, 0.1});
  const double start = body.energy();
  const auto course = body.run(method, kEnd, {}, 1e6 * start);
  return {body.energy() / start, course.end};
}

Finding explicit_euler() {
  const auto with = [](double h) {
    ExplicitIndex1 method({.step = h, .method = ExplicitIndex1::Method::euler});
    return spin(method);
  };
  const Result coarse = with(1.0 / 60), middle = with(1.0 / 240), fine = with(1e-3);
  return {coarse.end < kEnd ? Outcome::unstable : judged(coarse.ratio - 1, kLimit),
          {{"time at which E passes a million E₀, h = 1/60, s", coarse.end, 18.8, 3},
           {"E/E₀ at 20 s, h = 1/240", middle.ratio, 1.73, 3},
           {"h = 1/1000", fine.ratio, 1.13, 3}},
          "energy grows every step"};
}

/// The rule with h = 1/60, 1/240, 1/1000; the first is judged.
Finding implicit(double theta, const std::vector<double>& published, const std::string& why) {
  std::vector<Figure> figures;
  const double steps[] = {1.0 / 60, 1.0 / 240, 1e-3};
  for (int i = 0; i < 3; ++i) {
    ThetaRule method({.step = steps[i], .theta = theta});
    const double ratio = spin(method).ratio;
    figures.push_back({"E/E₀ at 20 s, h = " + figure_text(steps[i]), ratio, published[i]});
  }
  return {judged(figures[0].value - 1, kLimit), figures, why};
}

Finding judge(Integrator& method) {
  const Result result = spin(method);
  return {judged(result.ratio - 1, kLimit, 10), {{"E/E₀ - 1 at 20 s", result.ratio - 1}}};
}

const Registered scene{with_candidates(
    {"S21",
     "gyroscopic, spin near a principal axis",
     {{"explicit Euler", explicit_euler},
      {"implicit Euler",
       [] {
         return implicit(1, {0.26, 0.65, 0.89}, "numerical damping eats the spin");
       }},
      {"implicit midpoint",
       [] {
         return implicit(0.5, {1, 1, 1}, "quadratic invariants kept");
       }}}},
    {automatic(1e-7), runge_kutta8(1e-9), radau(1e-8), lie_bdf(1e-9), adams(1e-9), alpha(1.0 / 240), rattle(1.0 / 240)},
    {1e-7, 1.0 / 240}, judge)};

}  // namespace
}  // namespace lithe::lab
