// S26: the double pendulum from 135 degrees: perturbations grow 1.6 a second, and no double carries it to 20 s.
#include "integrators/runge_kutta_tableau.h"
#include "joints/distance_joint.h"
#include "tools/stability/bench.h"
#include "tools/stability/scenes/candidates.h"
#include "tools/stability/scenes/pendulum.h"

namespace lithe::lab {
namespace {

/// Two masses of 1 kg on rods of 1 m, at rest at `angle` (rad) from the downward vertical; the first turned by `more`.
class DoublePendulum : public Bench {
 public:
  explicit DoublePendulum(double angle)
      : Bench({0, -kGravity, 0}, [&](SystemGraph& graph) {
          Marker last = graph.ground().marker();
          for (int i = 1; i <= 2; ++i) {
            const Vector3 p = i * Vector3(std::sin(angle), -std::cos(angle), 0);
            auto& mass =
                graph.add<RigidBody>("mass " + std::to_string(i), {.mass = 1, .inertia = {1, 1, 1}, .position = p});
            graph.add<DistanceJoint>("rod " + std::to_string(i), {last, mass.marker()}, {.length = 1});
            last = mass.marker();
          }
        }) {}
  Vector3 tip() const { return state.q.segment<3>(7); }
};

using Complex = std::complex<double>;
using Angles = Eigen::Matrix<Complex, 4, 1>;  // θ₁, θ₂ and their rates

Angles rates(const Angles& y) {
  const Complex s = std::sin(y[0] - y[1]), c = std::cos(y[0] - y[1]),
                f1 = -s * y[3] * y[3] - 2 * kGravity * std::sin(y[0]), f2 = s * y[2] * y[2] - kGravity * std::sin(y[1]),
                det = 2.0 - c * c;
  return {y[2], y[3], (f1 - c * f2) / det, (2.0 * f2 - c * f1) / det};
}

/// What a small change of θ₁(0) has become of (θ₁, θ₂, rates) by `end`, largest over the change: the imaginary part of
/// a motion started at θ₁ + i ε carries the derivative exactly.
double growth(double end) {
  const RungeKuttaTableau& T = dormand_prince8();
  constexpr double kTiny = 1e-30;
  const long count = std::lround(end / 2e-3);
  const double h = end / static_cast<double>(count);
  Angles y(Complex(3 * M_PI / 4, kTiny), 3 * M_PI / 4, 0, 0), k[16];
  for (long n = 0; n < count; ++n) {
    Angles z = y;
    for (int i = 0; i < T.stages; ++i) {
      z = y;
      for (int j = 0; j < i; ++j) z += h * T.a[i][j] * k[j];
      k[i] = rates(z);
    }
    y = z;  // the last stage is the step's end
  }
  return y.head<2>().imag().cwiseAbs().maxCoeff() / kTiny;
}

constexpr double kRoundOff = 1e-16;

/// The tip with half the step (or a hundredth of the tolerance) against the tip with the whole one, m.
struct Differences {
  double early, late;  // at 10 and 20 s
};
Differences halve(const std::function<Method(double)>& make, double h) {
  Vector3 tips[2][2];
  for (int i = 0; i < 2; ++i) {
    DoublePendulum scene(3 * M_PI / 4);
    const Method method = make(i == 0 ? h : h / 2);
    scene.run(*method, 10);
    tips[i][0] = scene.tip();
    scene.go_on(*method, 20);
    tips[i][1] = scene.tip();
  }
  return {(tips[1][0] - tips[0][0]).norm(), (tips[1][1] - tips[0][1]).norm()};
}

Method order8(double h) {
  return std::make_unique<ExplicitRungeKutta>(
      ExplicitRungeKutta::Parameters{.method = ExplicitRungeKutta::Method::dormand_prince8, .step = h});
}
const Differences& differences() {
  static const Differences d = halve(order8, 2e-3);
  return d;
}

Finding beyond() {
  // Of an infinitesimal change; the published 5.8e12 is of one of 1e-12, which by then is as large as the motion.
  const double floor = kRoundOff * growth(20);
  return {judged(differences().late, 1e-6),
          {{"difference of the tip, h and h/2, at 20 s, m", differences().late}, {"round-off times growth, m", floor}},
          "no method can: the pass is to say so"};
}
/// Rounding happens in every one of thousands of steps: a hundred times the floor of one is still the floor.
Finding until_ten() {
  const double floor = kRoundOff * growth(10);
  return {judged(differences().early, 100 * floor),
          {{"difference of the tip, h and h/2, at 10 s, m", differences().early},
           {"round-off times growth, m", floor, 1e-9, 0},
           {"growth to 10 s", growth(10), 1.3e7, 1},
           {"growth to 8 s", growth(8), 3.4e5, 1}},
          "the floor of double precision"};
}
Finding automatic_until_ten() {
  const Differences d = halve([](double tolerance) { return automatic(tolerance).make(); }, 1e-12);
  return {judged(d.early, 1e-6),
          {{"difference of the tip, tolerance 1e-12 and half of it, at 10 s, m", d.early}, {"at 20 s", d.late}},
          "the tolerance times growth, 1e-5 m, bounds it"};
}

const Registered scene{{"S26",
                        "chaos",
                        {{"any method, double, beyond 14 s", beyond},
                         {"any method, double, to 10 s", until_ten},
                         {"default (automatic, tolerance 1e-12), to 10 s", automatic_until_ten, Role::ours}}}};

}  // namespace
}  // namespace lithe::lab
