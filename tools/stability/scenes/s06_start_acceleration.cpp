// S06: an acceleration state that starts at zero costs the multipliers an order.
#include "tools/stability/lab.h"
#include "tools/stability/methods/plain_alpha.h"
#include "tools/stability/scenes/ours.h"
#include "tools/stability/scenes/pendulum.h"

namespace lithe::lab {
namespace {

/// Errors of the multiplier at 1 s for h = 0.01, 0.005, 0.0025, and the order between the last two.
template <class Make>
Finding order(Make&& make, const std::vector<double>& published, const std::string& why) {
  double errors[3];
  const double steps[] = {0.01, 0.005, 0.0025};
  for (int i = 0; i < 3; ++i) {
    Pendulum p;
    errors[i] = p.run(*make(steps[i]), 1).reached ? p.multiplier_error() : NAN;
  }
  const auto expected = [&](std::size_t i) { return published.empty() ? NAN : published[i]; };
  const double measured = std::log2(errors[1] / errors[2]);
  return {measured > 1.8 ? Outcome::converged : Outcome::inaccurate,
          {{"order of the multiplier", measured, expected(3)},
           {"error at 1 s, h = 0.01 s", errors[0], expected(0)},
           {"0.005", errors[1], expected(1)},
           {"0.0025", errors[2], expected(2)}},
          why};
}

auto plain(PlainAlpha::StartAcceleration start) {
  return [start](double h) {
    return std::make_unique<PlainAlpha>(
        PlainAlpha::Parameters{.step = h, .spectral_radius = 0.8, .start = start, .newton_tolerance = 1e-11});
  };
}

using enum PlainAlpha::StartAcceleration;
const Registered scene{
    {"S06",
     "inconsistent start acceleration",
     {{"acceleration state started at 0",
       [] {
         return order(plain(zero), {0.277, 0.134, 0.066, 1}, "first-order error in the multiplier persists");
       }},
      {"consistent acceleration state",
       [] {
         return order(plain(consistent), {0.0129, 0.0032, 0.00080, 2}, "");
       }},
      {"generalized-alpha, index 3", [] { return order(alpha_index3, {}, ""); }, Role::ours},
      {"generalized-alpha, index 2", [] { return order(alpha_index2, {}, ""); }, Role::ours}}}};

}  // namespace
}  // namespace lithe::lab
