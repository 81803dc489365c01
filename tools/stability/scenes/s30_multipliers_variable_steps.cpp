// S30: generalized-alpha on index 3 with changing steps: what is carried over them costs the multipliers an order.
#include "tools/stability/lab.h"
#include "tools/stability/methods/alternating.h"
#include "tools/stability/methods/plain_alpha.h"
#include "tools/stability/scenes/ours.h"
#include "tools/stability/scenes/pendulum.h"

namespace lithe::lab {
namespace {

/// Largest error of the multiplier from 0.9 to 1 s (|λ| up to 29), for four steps; and of the position at 1 s. As
/// published, of the smaller steps two in eight are looked at.
template <class Make>
Finding over_steps(Make&& make, const std::vector<double>& published, const std::string& why) {
  const double steps[] = {0.01, 0.005, 0.0025, 0.00125};
  double errors[4] = {}, position = 0;
  for (int i = 0; i < 4; ++i) {
    Pendulum p;
    long k = 0;
    const auto watch = [&] {
      ++k;
      if (p.state.time > 0.9 && (steps[i] >= 0.005 || k % 8 < 2)) errors[i] = std::max(errors[i], p.multiplier_error());
    };
    if (!p.run(*make(steps[i]), 1, watch).reached) errors[i] = NAN;
    if (i == 0) position = p.position_error();
  }
  const auto expected = [&](std::size_t i) { return published.empty() ? NAN : published[i]; };
  const double order = std::log2(errors[2] / errors[3]);
  return {order > 1.7 ? Outcome::converged : Outcome::inaccurate,
          {{"multiplier error near 1 s, h = 0.01 s", errors[0], expected(0)},
           {"0.005", errors[1], expected(1)},
           {"0.0025", errors[2], expected(2)},
           {"0.00125", errors[3], expected(3)},
           {"order", order},
           {"position error, h = 0.01 s, m", position, expected(4)}},
          why};
}

auto plain(Steps pattern, PlainAlpha::StepChange change) {
  return [=](double h) {
    return std::make_unique<PlainAlpha>(PlainAlpha::Parameters{
        .step = h, .spectral_radius = 0.8, .steps = pattern, .at_step_change = change, .newton_tolerance = 1e-11});
  };
}
Method alternating_index2(double h) { return std::make_unique<Alternating>(alpha_index2(h), h); }
Method alternating_index3(double h) { return std::make_unique<Alternating>(alpha_index3(h), h); }

using enum Steps;
using enum PlainAlpha::StepChange;
const Registered scene{
    {"S30",
     "order of multipliers at variable steps",
     {{"constant steps",
       [] {
         return over_steps(plain(constant, carry), {0.0192, 0.0048, 0.0012, 0.00030, 6.2e-4}, "order 2");
       }},
      {"steps alternating h, h/2",
       [] {
         return over_steps(plain(alternating, carry), {17.3, 8.4, 4.0, 2.0, 1.2e-2},
                           "the acceleration state belongs to the old step");
       }},
      {"alternating, state reset to the acceleration",
       [] {
         return over_steps(plain(alternating, reset), {6.7, 3.1, 1.5, 0.77, 1.6e-3},
                           "the offset of the state from the acceleration is lost");
       }},
      {"index 2 / stabilised index 3, or Radau IIA",
       [] { return over_steps(alternating_index2, {}, "stabilized index 2, steps h, h/2"); }},
      {"generalized-alpha, index 3, steps h, h/2", [] { return over_steps(alternating_index3, {}, ""); }, Role::ours},
      {"generalized-alpha, index 2, steps h, h/2", [] { return over_steps(alternating_index2, {}, ""); },
       Role::ours}}}};

}  // namespace
}  // namespace lithe::lab
