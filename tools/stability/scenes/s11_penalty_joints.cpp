// S11: a stiff spring in place of the rod, and explicit integration.
#include "engine/study/study_run.h"
#include "joints/forces/spring_damper.h"
#include "tools/stability/lab.h"
#include "tools/stability/methods/explicit_index1.h"
#include "tools/stability/scenes/candidates.h"
#include "tools/stability/scenes/pendulum.h"

namespace lithe::lab {
namespace {

constexpr double kEnd = 1, kExploded = 1000;  // s, J
constexpr double kLimit = 1e-6;               // m, of the rod's length

/// P on a spring of stiffness k (N/m).
class Penalty : public Bench {
 public:
  explicit Penalty(double k)
      : Bench({0, -kGravity, 0}, [&](SystemGraph& graph) {
          auto& mass = graph.add<RigidBody>("mass", {.mass = 1, .inertia = {1, 1, 1}, .position = {1, 0, 0}});
          graph.add<SpringDamper>("spring", {graph.ground().marker(), mass.marker()},
                                  {.stiffness = k, .natural_length = 1});
        }) {}
  double stretch() const { return std::abs(state.q.head<3>().norm() - 1); }
};

struct Result {
  Bench::Course course;
  double stretch = 0;
  bool stable() const { return course.reached && course.energy_error < kExploded; }
};

Result follow(double k, Integrator& method) {
  Penalty p(k);
  Result result;
  result.course = p.run(
      method, kEnd, [&] { result.stretch = std::max(result.stretch, p.stretch()); }, kExploded);
  return result;
}
Result rk4(double k, double h) {
  ExplicitIndex1 method({.step = h});
  return follow(k, method);
}
double limit(double k) {
  return largest_stable_step([&](double h) { return rk4(k, h).stable(); }, 2.5 / std::sqrt(k), 3.5 / std::sqrt(k),
                             1e-4);
}

Finding above() {
  const double soft = limit(1e4), middle = limit(1e6), stiff = limit(1e8);
  const bool dead = !rk4(1e8, 1.02 * stiff).stable() && !rk4(1e6, 1.02 * middle).stable();
  return {dead ? Outcome::unstable : Outcome::inaccurate,
          {{"largest h sqrt(k/m), k = 1e8 N/m", stiff * 1e4, 2.83, 3},
           {"k = 1e6", middle * 1e3, 2.85, 3},
           {"k = 1e4", soft * 1e2, 2.96, 3}},
          "imaginary-axis limit 2 sqrt 2",
          stiff};
}

Finding below() {
  const double k = 1e6;
  const Result result = rk4(k, 0.5 / std::sqrt(k));
  return {result.stable() ? judged(result.stretch, kLimit) : Outcome::unstable,
          {{"stretch of the joint, k = 1e6 N/m, m", result.stretch, 3 * kGravity / k},
           {"energy error, J", result.course.energy_error}},
          "joint yields",
          limit(k)};
}

/// Stable far beyond: h sqrt(k/m) = 100. Not judged by the stretch, which is the spring's.
Finding implicit(Integrator& method) {
  const Result result = follow(1e8, method);
  return {
      result.stable() ? judged(result.course.energy_error, 0.1) : Outcome::unstable,
      {{"energy error, k = 1e8 N/m, h sqrt(k/m) = 100, J", result.course.energy_error}, {"stretch, m", result.stretch}},
      "unconditionally stable in the linear range; see S24 for the limit"};
}

const Registered scene{
    under_every_method({"S11",
                        "stiff penalty joints under explicit Runge-Kutta",
                        {{"RK4 above h = 2.83 sqrt(m/k)", above},
                         {"RK4 below", below},
                         {"generalized-alpha rho = 0.8 (implicit)", [] { return implicit(*alpha_index3(0.01)); }},
                         {"generalized-alpha, defaults", [] { return implicit(*alpha_index3(0.01)); }, Role::ours}}},
                       {1e-6, 0.01}, implicit)};

}  // namespace
}  // namespace lithe::lab
