// F04: modes far faster than the step: undamped rules keep them ringing at the step's own frequency in the joint's
// force, damped ones forget them.
#include "engine/observe/snapshot.h"
#include "joints/revolute_joint.h"
#include "tools/stability/methods/plain_alpha.h"
#include "tools/stability/scenes/beam.h"
#include "tools/stability/scenes/candidates.h"

namespace lithe::lab {
namespace {

constexpr double kStep = 2e-3, kEnd = 2, kLast = 0.5;          // s: the highest of nine modes turns 20 rad a step
constexpr double kWeight = 7850 * 1e-4 * 9.81, kLimit = 0.01;  // N, of the weight

/// A steel rod of 1 m, 10 x 10 mm, pinned and released horizontally, undeformed: its weight strikes all its modes.
class Rod : public Bench {
 public:
  Rod()
      : Bench({0, -9.81, 0}, [](SystemGraph& graph) {
          auto& rod = graph.add<FlexibleBody>("rod", {.basis = cantilever(1, square(0.01, 2.1e11, 0.3, 7850), 9)});
          graph.add<RevoluteJoint>("pin", {graph.ground().marker(), rod.frame()});
        }) {}
};

/// Zigzag from step to step of the pin's force in the last half second, over the weight: fourth differences, which see
/// little of what the step resolves.
Finding judge(Integrator& method) {
  Rod scene;
  Snapshot now(scene.system);
  std::vector<Vector3> forces;
  double zigzag = 0;
  const auto course = scene.run(
      method, kEnd,
      [&] {
        now.evaluate(scene.state);
        forces.push_back(now.found_multipliers().head<3>());
        const std::size_t n = forces.size();
        if (n > 4 && scene.state.time > kEnd - kLast)
          zigzag = std::max(
              zigzag,
              (forces[n - 1] - 4 * forces[n - 2] + 6 * forces[n - 3] - 4 * forces[n - 4] + forces[n - 5]).norm() / 16 /
                  kWeight);
      },
      1e3);
  if (!course.reached) return {Outcome::unstable, {{"ended at, s", course.end}}, course.why};
  return {judged(zigzag, kLimit, 1e3),
          {{"zigzag of the pin's force in the last 0.5 s, of the weight", zigzag},
           {"energy error, J", course.energy_error},
           {"steps", static_cast<double>(course.steps)}}};
}
Cell plain(const std::string& name, double rho, const std::string& why) {
  return {name,
          [rho, why] {
            PlainAlpha method({.step = kStep, .spectral_radius = rho});
            Finding finding = judge(method);
            finding.why = why;
            return finding;
          },
          Role::also};
}

const Registered scene{with_candidates(
    {"F04",
     "unresolved stiff modes",
     {plain("trapezoidal rule (rho = 1)", 1, "roots of modulus 1 for all that is faster than the step"),
      plain("generalized-alpha rho = 0.98", 0.98, "damped, but slowly")}},
    {automatic(1e-6), radau(1e-6), alpha(kStep), alpha(kStep, 0.8, GeneralizedAlpha::Form::stabilized_index2),
     hht(kStep), linearly_implicit(kStep), rattle(kStep)},
    {1e-6, kStep}, judge)};

}  // namespace
}  // namespace lithe::lab
