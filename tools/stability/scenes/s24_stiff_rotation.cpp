// S24: a mass on a stiff spring that goes round: rules that are unconditionally stable on linear systems blow up. A
// step's equations have several solutions; which of them Newton finds depends on where it starts.
#include "bodies/rigid_body.h"
#include "joints/forces/spring_damper.h"
#include "tools/stability/bench.h"
#include "tools/stability/methods/plain_alpha.h"
#include "tools/stability/methods/theta_rule.h"
#include "tools/stability/scenes/candidates.h"

namespace lithe::lab {
namespace {

constexpr double kMass = 10, kLength = 3.0443, kStiffness = 1e10 / kLength, kSpeed = 7.72, kEnd = 30;
constexpr double kLimit = 1.01, kExploded = 1e3;  // of max E/E₀
constexpr double kSteps[] = {0.1, 0.05, 0.02, 0.01};

class Whirl : public Bench {
 public:
  Whirl()
      : Bench(Vector3::Zero(), [](SystemGraph& graph) {
          auto& mass = graph.add<RigidBody>(
              "mass", {.mass = kMass, .inertia = {1, 1, 1}, .position = {0, -kLength, 0}, .velocity = {kSpeed, 0, 0}});
          graph.add<SpringDamper>("spring", {graph.ground().marker(), mass.marker()},
                                  {.stiffness = kStiffness, .natural_length = kLength});
        }) {}
};

struct Result {
  double most = 0;  // E/E₀ after the start
  double end = 0;   // s, where the step began that ended the run
};
Result whirl(Integrator& method) {
  Whirl scene;
  const double start = scene.energy();
  double most = 0, before = 0, now = 0;
  const auto course = scene.run(
      method, kEnd,
      [&] {
        before = now, now = scene.state.time;
        most = std::max(most, scene.energy() / start);
      },
      kExploded * start);
  return {course.reached || most > kExploded ? most : INFINITY, before};
}

struct Published {
  double most[4] = {NAN, NAN, NAN, NAN};  // for each of kSteps
  double end[4] = {NAN, NAN, NAN, NAN};   // s, where the energy passes a thousand times the first
};
/// The worst of all steps is judged, by the figure of `first`, which is shown first.
template <class Make>
Finding over_steps(Make&& make, const Published& published, int first, const std::string& why) {
  std::vector<Figure> figures;
  double worst = 0;
  for (int i = 0; i < 4; ++i) {
    const Result r = whirl(*make(kSteps[i]));
    worst = std::max(worst, r.most);
    const std::string h = "h = " + figure_text(kSteps[i]);
    const Figure most{"max E/E₀, " + h, r.most, published.most[i]};
    const Figure end{"time at which E passes a thousand E₀, " + h + ", s", r.end, published.end[i]};
    figures.insert(i == first ? figures.begin() : figures.end(), r.most > kExploded ? end : most);
  }
  return {judged(worst, kLimit, kExploded), figures, why};
}

auto plain(double rho) {
  return [rho](double h) {
    return std::make_unique<PlainAlpha>(PlainAlpha::Parameters{
        .step = h, .spectral_radius = rho, .newton_tolerance = 1e-12, .max_newton = 60, .straight_guess = true});
  };
}
Method midpoint(double h) { return std::make_unique<ThetaRule>(ThetaRule::Parameters{.step = h}); }

Finding judge(Integrator& method) {
  const Result r = whirl(method);
  return {judged(r.most, kLimit, kExploded), {{"max E/E₀", r.most}}};
}

const Registered scene{with_candidates(
    {"S24",
     "nonlinear instability of the trapezoidal rule",
     {{"trapezoidal rule",
       [] {
         return over_steps(plain(1), {.most = {9.3, 79, NAN, NAN}, .end = {NAN, NAN, 8.7, 8.3}}, 0,
                           "A-stability says nothing about rotating stiff directions; smaller steps do not cure it");
       }},
      {"implicit midpoint",
       [] {
         return over_steps(midpoint, {.end = {NAN, 0.3, 1.28, 3.06}}, 1, "the same");
       }},
      {"generalized-alpha rho = 0.8",
       [] {
         return over_steps(plain(0.8), {.most = {141, 0.9976, 0.99958, 0.99989}}, 0,
                           "damping too small for the largest step");
       }},
      {"generalized-alpha rho = 0.5",
       [] {
         return over_steps(plain(0.5), {.most = {0.96, 0.99, 0.998, 0.9996}}, 0, "high-frequency damping");
       }}}},
    {automatic(1e-6), radau(1e-6), alpha(0.01), alpha(0.01, 0.5), hht(0.01), linearly_implicit(0.01)}, {1e-6, 0.01},
    judge)};

}  // namespace
}  // namespace lithe::lab
