// S22: Cardan angles that pass a quarter turn: the step collapses, the motion is as smooth as ever.
#include "tools/stability/methods/ordinary.h"
#include "tools/stability/scenes/candidates.h"
#include "tools/stability/scenes/free_body.h"

namespace lithe::lab {
namespace {

constexpr double kEnd = 10;                      // s
constexpr long kLimit = 500;                     // evaluations
constexpr double kTilts[] = {1e-2, 1e-4, 1e-6};  // rad/s: ω = (eps, 1, eps)
const Vector3 kInertia(1, 2, 3);

/// y = (α, β, γ, ω), R = Rx(α) Ry(β) Rz(γ).
VectorX cardan(double, const VectorX& y) {
  const Vector3 w = y.tail<3>();
  const double rate = (w[0] * std::cos(y[2]) - w[1] * std::sin(y[2])) / std::cos(y[1]);
  VectorX out(6);
  out << rate, w[0] * std::sin(y[2]) + w[1] * std::cos(y[2]), w[2] - rate * std::sin(y[1]), euler_rates(kInertia, w);
  return out;
}
/// y = (e, ω).
VectorX quaternion(double, const VectorX& y) {
  VectorX out(7);
  out << quaternion_rates(y.head<4>(), y.tail<3>()), euler_rates(kInertia, y.tail<3>());
  return out;
}

template <class Count>  // AdaptiveRun of a tilt
Finding over_tilts(Count&& run, const std::vector<double>& evaluations, const std::vector<double>& steps,
                   const std::string& why) {
  std::vector<Figure> counts, shortest;
  for (int i = 0; i < 3; ++i) {
    const AdaptiveRun r = run(kTilts[i]);
    counts.push_back(
        {"evaluations, eps = " + figure_text(kTilts[i]), static_cast<double>(r.evaluations), evaluations[i], 3});
    shortest.push_back({"smallest step, s", r.smallest_step, steps[i]});
  }
  double most = 0;
  for (const Figure& f : counts) most = std::max(most, f.value);
  counts.insert(counts.end(), shortest.begin(), shortest.end());
  return {judged(most, kLimit), counts, why};
}

AdaptiveRun as_scipy(const Rates& rates, VectorX start, double eps) {
  start.tail<3>() << eps, 1, eps;
  return run_as_scipy(dormand_prince8(), rates, 0, kEnd, start, 1e-9, 1e-12);
}

Finding judge(Integrator& method) {
  return over_tilts(
      [&](double eps) {
        FreeBody body(kInertia, {eps, 1, eps});
        const auto course = body.run(method, kEnd);
        return AdaptiveRun{body.state.q, method.statistics().evaluations, course.smallest_step, course.reached};
      },
      {NAN, NAN, NAN}, {NAN, NAN, NAN}, "");
}

const Registered scene{with_candidates(
    {"S22",
     "gimbal lock",
     {{"Cardan angles",
       [] {
         return over_tilts([](double eps) { return as_scipy(cardan, VectorX::Zero(6), eps); }, {2102, 4214, 5810},
                           {1.6e-3, 1.8e-5, 1.6e-7}, "angle rates grow as 1/cos; exactly at 90 deg there are none");
       }},
      {"quaternion",
       [] {
         return over_tilts([](double eps) { return as_scipy(quaternion, VectorX::Unit(7, 0), eps); }, {278, 194, 170},
                           {NAN, NAN, NAN}, "no singularity");
       }}}},
    {automatic(1e-7), runge_kutta8(1e-9)}, {1e-7, 0.01}, judge)};

}  // namespace
}  // namespace lithe::lab
