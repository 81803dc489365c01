// S04: implicit Euler on index 3 loses its multipliers at every change of the step.
#include "tools/stability/lab.h"
#include "tools/stability/methods/alternating.h"
#include "tools/stability/methods/index3_bdf.h"
#include "tools/stability/scenes/ours.h"
#include "tools/stability/scenes/pendulum.h"

namespace lithe::lab {
namespace {

constexpr double kStart = 0.3;  // s: λ = 12.5
constexpr int kSteps = 40, kFirst = 5;

/// Largest error of the multiplier over steps 6 to 40 from 0.3 s on.
double multiplier_error(Integrator& method) {
  Pendulum p(kStart);
  method.start(p.equations, p.state);
  double error = 0;
  for (int k = 0; k < kSteps; ++k) {
    if (!method.step(p.equations, p.state, 1e9).ok()) return NAN;
    if (k >= kFirst) error = std::max(error, p.multiplier_error());
  }
  return error;
}

template <class Make>
Finding over_steps(Make&& make, const std::vector<double>& published, const std::string& why) {
  double errors[3];
  const double steps[] = {1e-2, 1e-3, 1e-4};
  for (int i = 0; i < 3; ++i) errors[i] = multiplier_error(*make(steps[i]));
  const auto expected = [&](std::size_t i) { return published.empty() ? NAN : published[i]; };
  return {errors[2] < 0.2 * errors[1] && errors[1] < 0.2 * errors[0] ? Outcome::converged : Outcome::inaccurate,
          {{"multiplier error (of 12.5) at h = 1e-4 s", errors[2], expected(2)},
           {"at 1e-3", errors[1], expected(1)},
           {"at 1e-2", errors[0], expected(0)}},
          why};
}

auto bdf1(Steps steps) {
  return [steps](double h) { return std::make_unique<Index3Bdf>(Index3Bdf::Parameters{.step = h, .steps = steps}); };
}

const Registered scene{
    {"S04",
     "variable-step BDF on index 3",
     {{"BDF1 variable step, index 3",
       [] {
         return over_steps(bdf1(Steps::alternating), {7.9, 4.9, 4.2}, "O(1) multiplier error at step changes");
       }},
      {"BDF1 constant step",
       [] {
         return over_steps(bdf1(Steps::constant), {1.7, 6.2e-2, 5.2e-3}, "order 1");
       }},
      {"index 2 (stabilised, GGL)",
       [] {
         return over_steps([](double h) { return std::make_unique<Alternating>(alpha_index2(h), h); }, {},
                           "generalized-alpha, steps h, h/2 in turn: index 2 keeps the order");
       }},
      {"generalized-alpha, index 3, steps h, h/2",
       [] {
         return over_steps([](double h) { return std::make_unique<Alternating>(alpha_index3(h), h); }, {},
                           "offsets move with the step");
       },
       Role::ours}}}};

}  // namespace
}  // namespace lithe::lab
