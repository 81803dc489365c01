// F01: a flexible pendulum under explicit methods: the highest mode kept sets the step, each method by the piece of the
// imaginary axis that it bears.
#include "joints/revolute_joint.h"
#include "tools/stability/methods/dense_equations.h"
#include "tools/stability/methods/explicit_index1.h"
#include "tools/stability/methods/ordinary.h"
#include "tools/stability/scenes/beam.h"
#include "tools/stability/scenes/candidates.h"

namespace lithe::lab {
namespace {

constexpr double kLength = 1;                                          // m; steel, 10 x 10 mm
constexpr int kSteps = 3000;                                           // that a run has to live
constexpr double kSwing = 7850 * 1e-4 * kLength * 9.81 * kLength / 2;  // J, from horizontal to hanging

class FlexiblePendulum : public Bench {
 public:
  explicit FlexiblePendulum(int modes)
      : Bench({0, -9.81, 0}, [&](SystemGraph& graph) {
          auto& rod =
              graph.add<FlexibleBody>("rod", {.basis = cantilever(kLength, square(0.01, 2.1e11, 0.3, 7850), modes)});
          graph.add<RevoluteJoint>("pin", {graph.ground().marker(), rod.frame()});
        }) {}

  /// The highest frequency of the pinned rod, rad/s, by power iteration on M⁻¹ K within what the pin leaves free.
  double highest_frequency() {
    const int nv = system.layout().v_count(), rows = system.layout().row_count();
    const VectorX rest = VectorX::Zero(nv), none = VectorX::Zero(rows);
    equations.evaluate(0, state.q, state.v, Level::velocity);
    const MatrixX K = dense_parts(equations, rest, none).K;
    equations.factorize({0, 0, 1}, rest, none, nullptr);
    VectorX x = VectorX::Ones(nv), reaction(rows);
    double squared = 0;
    for (int k = 0; k < 100; ++k) {
      x = K * x.normalized();
      reaction.setZero();
      equations.solve(x, reaction);
      squared = x.norm();
    }
    return std::sqrt(squared);
  }
};

/// |R(i y)| of a Runge-Kutta method: what a step makes of ẏ = i ω y, h ω = y.
double amplification(const RungeKuttaTableau& T, double y) {
  std::complex<double> k[16], x;
  for (int i = 0; i < T.stages; ++i) {
    x = 1;
    for (int j = 0; j < i; ++j) x += T.a[i][j] * k[j];
    k[i] = std::complex<double>(0, y) * x;
  }
  return std::abs(x);
}
double amplification_rk4(double y) {
  const std::complex<double> z(0, y);
  return std::abs(1.0 + z * (1.0 + z / 2.0 * (1.0 + z / 3.0 * (1.0 + z / 4.0))));
}
/// The h ω at which an oscillation of some 1e-6 J grows beyond the swing's energy within kSteps.
double predicted(const std::function<double(double y)>& amplification) {
  for (double y = 0.05; y < 10; y += 1e-3)
    if (2 * kSteps * std::log(amplification(y)) > std::log(1e6)) return y;
  return NAN;
}

/// By method and by the number of modes: the step at which the energy runs away, bisected, and predicted by theory.
struct Explicit {
  std::function<Method(double h)> make;
  std::function<double(double y)> amplification;
};
Explicit order(ExplicitRungeKutta::Method method) {
  const RungeKuttaTableau& T =
      method == ExplicitRungeKutta::Method::dormand_prince5 ? dormand_prince5() : dormand_prince8();
  return {[method](double h) {
            return std::make_unique<ExplicitRungeKutta>(ExplicitRungeKutta::Parameters{.method = method, .step = h});
          },
          [&T](double y) { return amplification(T, y); }};
}
Explicit classical() {
  return {[](double h) { return std::make_unique<ExplicitIndex1>(ExplicitIndex1::Parameters{.step = h}); },
          amplification_rk4};
}

bool lives(const Explicit& method, int modes, double h) {
  FlexiblePendulum scene(modes);
  return scene.run(*method.make(h), kSteps * h, {}, 2 * kSwing).reached;
}
struct Limit {
  double measured, predicted, step;
};
Limit limit(const Explicit& method, int modes) {
  const double fastest = FlexiblePendulum(modes).highest_frequency(), theory = predicted(method.amplification);
  const double step = largest_stable_step([&](double h) { return lives(method, modes, h); }, 0.7 * theory / fastest,
                                          1.4 * theory / fastest, 5e-3);
  return {step * fastest, theory, step};
}
/// Theory takes the place of published figures, to so many digits.
Finding beyond(const Explicit& method, int digits) {
  const Limit three = limit(method, 3), nine = limit(method, 9);
  return {lives(method, 3, 1.1 * three.step) ? Outcome::converged : Outcome::unstable,
          {{"h ω_max at which the energy runs away, 3 modes", three.measured, three.predicted, digits},
           {"9 modes", nine.measured, nine.predicted, digits},
           {"largest step, 3 modes, s", three.step},
           {"9 modes", nine.step}},
          "as |R(i y)| of the method has it over 3000 steps (that of order 5 grows so slowly that the start counts "
          "too); six "
          "modes more that hardly move cost a factor of 9 in the step",
          nine.step};
}
Finding judge(Integrator& method) {
  FlexiblePendulum scene(9);
  const auto course = scene.run(method, 1, {}, 2 * kSwing);
  return {course.reached ? judged(course.energy_error / kSwing, 1e-2) : Outcome::unstable,
          {{"energy error to 1 s, of the swing", course.energy_error / kSwing},
           {"steps", static_cast<double>(course.steps)},
           {"evaluations", static_cast<double>(method.statistics().evaluations)}},
          course.why};
}

using enum ExplicitRungeKutta::Method;
const Registered scene{with_candidates(
    {"F01",
     "reduced body under explicit methods",
     {{"RK4 beyond its limit", [] { return beyond(classical(), 1); }, Role::also},
      {"explicit Runge-Kutta 5(4) beyond its limit", [] { return beyond(order(dormand_prince5), 1); }, Role::also},
      {"explicit Runge-Kutta 8(5,3) beyond its limit", [] { return beyond(order(dormand_prince8), 2); }, Role::also}}},
    {automatic(1e-4), runge_kutta5(1e-4), radau(1e-4), alpha(1e-3)}, {1e-4, 1e-3}, judge)};

}  // namespace
}  // namespace lithe::lab
