// S23: four plain numbers under RK4 do not keep their norm.
#include "tools/stability/methods/explicit_index1.h"
#include "tools/stability/scenes/candidates.h"
#include "tools/stability/scenes/free_body.h"

namespace lithe::lab {
namespace {

constexpr double kEnd = 100, kLimit = 1e-8;  // s; of the norm

double norm_error(Integrator& method) {
  FreeBody body({1, 2, 3}, {0.1, 10, 0.1});
  body.run(method, kEnd);
  return body.state.q.segment<4>(3).norm() - 1;
}

Finding rk4(bool normalise, double coarse, double fine, const std::string& why) {
  ExplicitIndex1 method({.step = 0.01, .normalise = normalise}), finer({.step = 0.003, .normalise = normalise});
  const double error = norm_error(method);
  return {judged(error, kLimit),
          {{"norm - 1 at 100 s, h = 0.01", error, coarse, 2}, {"h = 0.003", norm_error(finer), fine, 2}},
          why};
}

Finding judge(Integrator& method) {
  const double error = norm_error(method);
  return {judged(error, kLimit), {{"norm - 1 at 100 s", error}}};
}

const Registered scene{with_candidates(
    {"S23",
     "quaternion norm",
     {{"no normalisation", [] { return rk4(false, -1.7e-6, -4.1e-9, "RK4 is dissipative on rotations"); }},
      {"normalised or constrained", [] { return rk4(true, NAN, NAN, ""); }}}},
    {automatic(1e-6), alpha(0.01), rattle(0.01)}, {1e-6, 0.01}, judge)};

}  // namespace
}  // namespace lithe::lab
