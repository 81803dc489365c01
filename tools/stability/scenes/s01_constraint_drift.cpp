// S01: the pendulum at acceleration level drifts off its rod.
#include "tools/stability/lab.h"
#include "tools/stability/methods/explicit_index1.h"
#include "tools/stability/scenes/candidates.h"
#include "tools/stability/scenes/pendulum.h"

namespace lithe::lab {
namespace {

constexpr double kEnd = 100, kLimit = 1e-10;  // s, m

struct Published {
  double drift = NAN, exponent = NAN;
};

/// The largest violation up to 100 s, and its growth from 10 s on as a power of time.
Finding drift(Integrator& method, const Published& published, const std::string& why) {
  Pendulum p;
  double violation = 0, at_tenth = 0;
  const auto course = p.run(method, kEnd, [&] {
    violation = std::max(violation, p.stretch());
    if (p.state.time <= kEnd / 10) at_tenth = violation;
  });
  std::vector<Figure> figures{{"|g| to 100 s, m", violation, published.drift, published.exponent > 0 ? 2 : 0},
                              {"energy error, J", course.energy_error}};
  if (published.exponent > 0)
    figures.push_back({"grows as time to the power", std::log10(violation / at_tenth), published.exponent, 3});
  return {course.reached ? judged(violation, kLimit) : Outcome::unstable, figures, why};
}

Finding by(ExplicitIndex1::Stabilisation how, const Published& published, const std::string& why) {
  ExplicitIndex1 method({.step = 0.01, .stabilisation = how});
  return drift(method, published, why);
}

using enum ExplicitIndex1::Stabilisation;
const Registered scene{under_every_method(
    {"S01",
     "constraint drift",
     {{"index 1, no stabilisation",
       [] {
         return by(none, {3.6e-3, 2.00}, "double zero root of g'' = 0");
       }},
      {"index 2, velocity projected",
       [] {
         return by(velocity, {3.9e-7, 1.00}, "single zero root");
       }},
      {"position and velocity projection", [] { return by(position_velocity, {1e-16}, "drift removed each step"); }},
      {"explicit Runge-Kutta 5(4), h = 0.01", [] { return drift(*runge_kutta_step(0.01), {}, ""); }, Role::ours},
      {"generalized-alpha, index 3, h = 0.01", [] { return drift(*alpha_index3(0.01), {}, ""); }, Role::ours},
      {"generalized-alpha, index 2, h = 0.01", [] { return drift(*alpha_index2(0.01), {}, ""); }, Role::ours}}},
    {1e-8, 0.01}, [](Integrator& method) { return drift(method, {}, ""); })};

}  // namespace
}  // namespace lithe::lab
