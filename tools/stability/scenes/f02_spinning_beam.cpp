// F02: a free flexible beam that spins at two thirds of its first frequency while it vibrates: gyroscopic and
// centrifugal terms of a body whose inertia depends on its deformation.
#include "tools/stability/methods/explicit_index1.h"
#include "tools/stability/methods/theta_rule.h"
#include "tools/stability/scenes/beam.h"
#include "tools/stability/scenes/candidates.h"

namespace lithe::lab {
namespace {

constexpr double kSpin = 30, kEnd = 2, kLimit = 1e-3;  // rad/s (first mode with its root held: 52 rad/s), s

/// Three modes of the beam with its frame at the root; the first moves at 1 m/s.
class SpinningBeam : public Bench {
 public:
  SpinningBeam()
      : Bench(Vector3::Zero(), [](SystemGraph& graph) {
          graph.add<FlexibleBody>("beam", {.basis = cantilever(1, square(0.01, 2.1e11, 0.3, 7850), 3),
                                           .velocity = {0, -kSpin / 2, 0},
                                           .angular_velocity = {1, 0, kSpin},
                                           .modal_velocities = Vector3(1, 0, 0)});
        }) {}
  /// About the world's origin, kg m²/s.
  Vector3 angular_momentum() {
    const auto& beam = static_cast<const FlexibleBody&>(*system.layout().bodies()[0].body);
    FlexibleBody::Cache cache(beam);
    const BodyState body{state.q.data(), state.v.data(), &cache};
    beam.evaluate(body, Level::velocity);
    return beam.angular_momentum(body);
  }
};

Finding judge(Integrator& method) {
  SpinningBeam scene;
  const double energy = scene.energy();
  const Vector3 momentum = scene.angular_momentum();
  const auto course = scene.run(method, kEnd, {}, 1e3 * energy);
  if (!course.reached) return {Outcome::unstable, {{"energy beyond bounds at, s", course.end}}, course.why};
  const double lost = (scene.angular_momentum() - momentum).norm() / momentum.norm();
  return {judged(std::max(course.energy_error / energy, lost), kLimit, 10),
          {{"largest energy error over E₀", course.energy_error / energy},
           {"change of the angular momentum, relative", lost},
           {"steps", static_cast<double>(course.steps)}}};
}
template <class Type>
Cell failing(const std::string& name, typename Type::Parameters parameters, const std::string& why) {
  return {name,
          [parameters, why] {
            Type method(parameters);
            Finding finding = judge(method);
            finding.why = why;
            return finding;
          },
          Role::also};
}

using enum ExplicitIndex1::Method;
const Registered scene{with_candidates(
    {"F02",
     "flexible beam at gyroscopic speed",
     {failing<ExplicitIndex1>("explicit Euler h = 1e-4", {.step = 1e-4, .method = euler}, "energy grows every step"),
      failing<ExplicitIndex1>("RK4 h = 2e-4", {.step = 2e-4, .method = rk4}, "within its limit"),
      failing<ExplicitIndex1>("RK4 h = 1e-3", {.step = 1e-3, .method = rk4}, "beyond its limit"),
      failing<ThetaRule>("implicit Euler h = 1e-3", {.step = 1e-3, .theta = 1}, "damps spin and vibration alike"),
      failing<ThetaRule>("implicit midpoint h = 1e-3", {.step = 1e-3}, "bounded, second order")}},
    {automatic(1e-6), runge_kutta8(1e-8), radau(1e-6), alpha(2e-4), rattle(2e-4)}, {1e-6, 2e-4}, judge)};

}  // namespace
}  // namespace lithe::lab
