// F28: a mass falls on a slack rope, which snaps taut, throws it back and goes slack, without damping. A step that is
// long beside the snap gives back another speed than came.
#include <numbers>

#include "bodies/rigid_body.h"
#include "joints/prismatic_joint.h"
#include "joints/rope/rope.h"
#include "tools/stability/bench.h"
#include "tools/stability/scenes/candidates.h"

namespace lithe::lab {
namespace {

constexpr double kMass = 1, kGravity = 9.81, kFall = 0.5, kLength = 1, kStiffness = 1e5;  // kg, m/s², m, m, N/m
constexpr int kSnaps = 10;
constexpr double kLimit = 0.01, kUnbounded = 0.5;

class Fall : public Bench {
 public:
  Fall()
      : Bench({0, 0, -kGravity}, [&](SystemGraph& graph) {
          auto& mass = graph.add<RigidBody>("mass", {.mass = kMass, .position = {0, 0, kFall - kLength}});
          graph.add<PrismaticJoint>("guide", {graph.ground().marker(), mass.marker()});
          reeve(graph, "rope", {{graph.ground().marker()}, {mass.marker()}},
                {.axial_stiffness = kStiffness * kLength, .length = kLength});
        }) {}
  double pull() {
    const double stretch = -state.q[2] - kLength;
    return stretch > 0 ? kStiffness * stretch : 0;
  }
};

Finding snaps(Integrator& method) {
  Fall fall;
  const double w = std::sqrt(kStiffness / kMass), speed = std::sqrt(2 * kGravity * kFall), weight = kMass * kGravity;
  // A flight up and down; taut, a swing about m g / k.
  const double flight = 2 * speed / kGravity, taut = 2 / w * (std::numbers::pi - std::atan(w * speed / kGravity));
  const double top = kMass * kGravity * kFall, start = fall.energy();
  double peak = 0, growth = 0;
  int snaps = 0;
  bool pulls = false;
  const Bench::Course course = fall.run(
      method, kSnaps * (flight + taut),
      [&] {
        peak = std::max(peak, fall.pull());
        growth = std::max(growth, (fall.energy() - start) / top);
        snaps += !pulls && fall.pull() > 0;
        pulls = fall.pull() > 0;
      },
      1e3 * top);
  const double error = course.energy_error / top;
  return {growth > kUnbounded ? Outcome::unstable : judged(error, kLimit),
          {{"largest change of the energy in 10 snaps, of m g h", error},
           {"largest pull, N; exact " + figure_text(weight + std::sqrt(weight * weight + 2 * kStiffness * top)), peak},
           {"snaps", static_cast<double>(snaps)},
           {"steps", static_cast<double>(course.steps)}},
          course.why};
}

const Registered scene{with_candidates({"F28", "a rope that goes slack and snaps", {}},
                                       {automatic(1e-7), radau(1e-7), runge_kutta8(1e-7), alpha(5e-3), alpha(1e-3),
                                        alpha(1e-4), hht(1e-3), linearly_implicit(1e-3)},
                                       {1e-7, 1e-3}, snaps)};

}  // namespace
}  // namespace lithe::lab
