// F07: a thin beam under explicit methods: waves of stretch and shear from node to node set the step, however slowly
// the beam bends.
#include "bodies/beam/beam.h"
#include "joints/spherical_joint.h"
#include "tools/stability/bench.h"
#include "tools/stability/methods/dense_equations.h"
#include "tools/stability/methods/explicit_index1.h"
#include "tools/stability/scenes/candidates.h"

namespace lithe::lab {
namespace {

// A strip of spring steel on a pin, 1 m, 20 x 1 mm, level at first.
constexpr double kLength = 1, kWidth = 0.02, kThickness = 1e-3;
const Material kSteel{2.1e11, 0.3, 7850};
const double kSwing = kSteel.density * kWidth * kThickness * kLength * 9.81 * kLength / 2;     // J, down to hanging
const double kBending = 15.4182 * std::sqrt(kSteel.young / kSteel.density / 12) * kThickness;  // rad/s, pinned-free

class Strip : public Bench {
 public:
  explicit Strip(int elements)
      : Bench({0, 0, -9.81}, [&](SystemGraph& graph) {
          auto& strip = graph.add<Beam>("strip", {.axis = BeamAxis::straight({0, 0, 0}, {kLength, 0, 0}, {0, 1, 0}),
                                                  .sections = {{0, BeamSection::rectangle(kWidth, kThickness, kSteel)}},
                                                  .elements = elements});
          graph.add<SphericalJoint>("pin", {graph.ground().marker(), strip.marker(0)});
        }) {}

  /// The highest frequency, rad/s, by power iteration on M⁻¹ K within what the pin leaves free.
  double highest_frequency() {
    const int nv = system.layout().v_count(), rows = system.layout().row_count();
    const VectorX rest = VectorX::Zero(nv), none = VectorX::Zero(rows);
    equations.evaluate(0, state.q, state.v, Level::velocity);
    const MatrixX K = dense_parts(equations, rest, none).K;
    equations.factorize({0, 0, 1}, rest, none, nullptr);
    VectorX x = VectorX::LinSpaced(nv, 1, 2), reaction(rows);
    double squared = 0;
    for (int k = 0; k < 400; ++k) {
      x = K * x.normalized();
      reaction.setZero();
      equations.solve(x, reaction);
      squared = x.norm();
    }
    return std::sqrt(squared);
  }
};

constexpr int kSteps = 2000;  // that a run has to live
bool lives(int elements, double h) {
  Strip scene(elements);
  ExplicitIndex1 method({.step = h, .stabilisation = ExplicitIndex1::Stabilisation::position_velocity});
  return scene.run(method, kSteps * h, {}, 2 * kSwing).reached;
}
/// Classical Runge-Kutta is stable to h ω = √8.
Finding beyond() {
  std::vector<Figure> figures;
  double steps[2], fastest[2];
  for (const int i : {0, 1}) {
    const int elements = 8 << i;
    fastest[i] = Strip(elements).highest_frequency();
    const double limit = std::sqrt(8.0) / fastest[i];
    steps[i] = largest_stable_step([&](double h) { return lives(elements, h); }, 0.7 * limit, 1.4 * limit, 1e-2);
    figures.push_back({"h ω_max at which the energy runs away, " + std::to_string(elements) + " elements",
                       steps[i] * fastest[i], std::sqrt(8.0), 1});
  }
  const double wave = 2 * 8 / kLength * std::sqrt(kSteel.young / kSteel.density);
  figures.push_back({"ω_max over 2 c/ℓ of stretch, 8 elements", fastest[0] / wave});
  figures.push_back({"steps in a period of bending, 8 elements", 2 * M_PI / kBending / steps[0]});
  figures.push_back({"in the same, 16 elements", 2 * M_PI / kBending / steps[1]});
  return {lives(8, 1.1 * steps[0]) ? Outcome::converged : Outcome::unstable, figures,
          "a wave of stretch or shear must not cross an element within a step; implicit methods step over it",
          steps[1]};
}
Finding judge(Integrator& method) {
  Strip scene(8);
  const auto course = scene.run(method, 0.5, {}, 2 * kSwing);
  return {course.reached ? judged(course.energy_error / kSwing, 1e-2) : Outcome::unstable,
          {{"energy error to 0.5 s, of the swing", course.energy_error / kSwing},
           {"steps", static_cast<double>(course.steps)},
           {"evaluations", static_cast<double>(method.statistics().evaluations)}},
          course.why};
}

const Registered scene{with_candidates(
    {"F07", "explicit methods and the stretch of a beam", {{"RK4 beyond its limit", beyond, Role::also}}},
    {automatic(1e-4), radau(1e-4), alpha(2e-4), runge_kutta8(1e-4)}, {1e-4, 2e-4}, judge)};

}  // namespace
}  // namespace lithe::lab
