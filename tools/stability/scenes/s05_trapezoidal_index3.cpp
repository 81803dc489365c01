// S05: the trapezoidal rule with position constraints: weakly unstable, worse for smaller steps.
#include "tools/stability/lab.h"
#include "tools/stability/methods/plain_alpha.h"
#include "tools/stability/scenes/ours.h"
#include "tools/stability/scenes/pendulum.h"

namespace lithe::lab {
namespace {

constexpr double kEnd = 10, kLimit = 0.1, kExploded = 1e5;  // s, J, J

struct Result {
  double energy_error = 0, zigzag = 0;  // J; of the multiplier over the last 0.9 s that it lived
};

Result follow(Integrator& method, double h) {
  Pendulum p;
  std::vector<double> multipliers;
  Result result;
  result.energy_error = p.run(method, kEnd, [&] { multipliers.push_back(p.state.lambda[0]); }).energy_error;
  const int count = static_cast<int>(multipliers.size()), last = static_cast<int>(std::lround(0.9 / h));
  for (int k = std::max(2, count - last); k < count; ++k)
    result.zigzag = std::max(result.zigzag, std::abs(multipliers[k] - 2 * multipliers[k - 1] + multipliers[k - 2]) / 4);
  return result;
}

struct Published {
  double coarse = NAN, fine = NAN, zigzag = NAN;
  int digits = 2;
};

template <class Make>
Finding over_steps(Make&& make, const Published& published, const std::string& why) {
  const Result coarse = follow(*make(0.01), 0.01), fine = follow(*make(0.005), 0.005);
  const double worst = std::isfinite(coarse.energy_error) && std::isfinite(fine.energy_error)
                           ? std::max(coarse.energy_error, fine.energy_error)
                           : INFINITY;
  return {judged(worst, kLimit, kExploded),
          {{"energy error at h = 0.01 s, J", coarse.energy_error, published.coarse, published.digits},
           {"at 0.005", fine.energy_error, published.fine, published.digits},
           {"zigzag of the multiplier in the last 0.9 s", coarse.zigzag, published.zigzag, published.digits}},
          why};
}

auto plain(double rho) {
  return [rho](double h) {
    return std::make_unique<PlainAlpha>(PlainAlpha::Parameters{.step = h, .spectral_radius = rho});
  };
}

const Registered scene{
    {"S05",
     "trapezoidal rule on index 3 (weak instability)",
     {{"Newmark 1/4, 1/2; generalized-alpha rho = 1",
       // Published sizes differ by a hundred between two programs: only the explosion is the figure.
       [] { return over_steps(plain(1), {}, "double root -1 at infinity: zigzag grows, worse for smaller h"); }},
      {"generalized-alpha rho = 0.9",
       [] {
         return over_steps(plain(0.9), {7.3e-3, 1.8e-3, 0.012}, "roots at infinity inside the unit circle");
       }},
      {"generalized-alpha, index 3", [] { return over_steps(alpha_index3, {}, ""); }, Role::ours},
      {"generalized-alpha, index 2", [] { return over_steps(alpha_index2, {}, ""); }, Role::ours},
      {"explicit Runge-Kutta 5(4)", [] { return over_steps(runge_kutta_step, {}, ""); }, Role::ours}}}};

}  // namespace
}  // namespace lithe::lab
