// S03: Newton's matrix of an index-3 BDF at small steps: condition h⁻³, unless it is scaled.
#include "tools/stability/lab.h"
#include "tools/stability/methods/index3_bdf.h"
#include "tools/stability/scenes/ours.h"
#include "tools/stability/scenes/pendulum.h"

namespace lithe::lab {
namespace {

constexpr double kStart = 0.3, kLength = 0.08;  // s
constexpr int kSteps = 800;                     // at most
constexpr int kFirst = 6;                       // steps until the start has died away

struct Result {
  double multiplier_error = 0, condition = 0;
};

/// BDF2 from 0.3 s on, from exact values.
Result bdf2(double h, bool scaled) {
  const Pendulum before(kStart);
  Pendulum p(kStart + h);
  Index3Bdf method({.step = h, .order = 2, .scaled = scaled});
  method.start_with(before.state);
  Result result;
  const int count = std::clamp(static_cast<int>(std::lround(kLength / h)), 20, kSteps);
  method.start(p.equations, p.state);
  for (int k = 0; k < count; ++k) {
    if (!method.step(p.equations, p.state, 1e9).ok()) return {NAN, NAN};
    if (k == 0) result.condition = method.last_condition();
    if (k >= kFirst) result.multiplier_error = std::max(result.multiplier_error, p.multiplier_error());
  }
  return result;
}

Finding unscaled() {
  // Round-off in the multipliers grows as h⁻²: smaller steps make it worse below 1e-5 s.
  const Result coarse = bdf2(1e-2, false), middle = bdf2(1e-4, false), fine = bdf2(1e-6, false),
               finest = bdf2(1e-7, false);
  return {finest.multiplier_error > middle.multiplier_error ? Outcome::inaccurate : Outcome::converged,
          {{"condition at h = 1e-6 s", fine.condition, 3.4e18},
           {"at 1e-2", coarse.condition, 3.5e6},
           {"at 1e-4", middle.condition, 3.4e12},
           {"multiplier error at 1e-4", middle.multiplier_error, 1.5e-6, 0},
           {"at 1e-6", fine.multiplier_error, 6.8e-4, 0},
           {"at 1e-7", finest.multiplier_error, 6.0e-2, 0}},
          "condition h^-3, round-off in multipliers h^-2"};
}

Finding scaled() {
  double largest = 0, smallest = INFINITY;
  for (const double h : {1e-2, 1e-3, 1e-4, 1e-5, 1e-6}) {
    const double condition = bdf2(h, true).condition;
    largest = std::max(largest, condition);
    smallest = std::min(smallest, condition);
  }
  const double coarse = bdf2(1e-2, true).multiplier_error, fine = bdf2(1e-3, true).multiplier_error,
               finest = bdf2(1e-4, true).multiplier_error;
  return {fine < 0.1 * coarse && finest < 0.1 * fine && largest < 10 ? Outcome::converged : Outcome::inaccurate,
          {{"largest condition, h = 1e-2 to 1e-6 s", largest, 7.77, 3},
           {"smallest", smallest, 7.77, 3},
           {"multiplier error at 1e-2", coarse},
           {"at 1e-3", fine},
           {"at 1e-4", finest}},
          "scaling removes h"};
}

/// The engine's own factor, in increments and multipliers: what is left of the error at small steps.
Finding ours(Integrator& coarse, Integrator& fine) {
  double errors[2];
  Integrator* methods[] = {&coarse, &fine};
  for (int i = 0; i < 2; ++i) {
    Pendulum p(kStart);
    errors[i] = 0;
    p.run(*methods[i], kStart + kLength, [&] { errors[i] = std::max(errors[i], p.multiplier_error()); });
  }
  return {errors[1] < 0.1 * errors[0] ? Outcome::converged : Outcome::inaccurate,
          {{"multiplier error at h = 1e-4 s", errors[1]}, {"at 1e-2", errors[0]}}};
}

const Registered scene{
    {"S03",
     "Newton matrix at small steps",
     {{"unscaled matrix", unscaled},
      {"rows and columns scaled by powers of h", scaled},
      {"generalized-alpha, index 3", [] { return ours(*alpha_index3(1e-2), *alpha_index3(1e-4)); }, Role::ours},
      {"generalized-alpha, index 2", [] { return ours(*alpha_index2(1e-2), *alpha_index2(1e-4)); }, Role::ours}}}};

}  // namespace
}  // namespace lithe::lab
