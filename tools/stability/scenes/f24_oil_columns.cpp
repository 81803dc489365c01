// F24: a load held between two columns of oil in a cylinder: it hardly moves, and its oil sets the step of explicit
// methods.
#include "bodies/rigid_body.h"
#include "joints/forces/first_order_states.h"
#include "joints/hydraulics/hydraulic_cylinder.h"
#include "joints/prismatic_joint.h"
#include "tools/stability/bench.h"
#include "tools/stability/methods/explicit_index1.h"
#include "tools/stability/scenes/candidates.h"

namespace lithe::lab {
namespace {

// 20 kg on a cylinder of 80/50 mm with short lines; closed valves, pushed at 5 mm/s.
constexpr double kMass = 20, kSpeed = 5e-3, kDead = 2e-5, kStroke = 0.1, kAt = 0.05;
const double kCap = M_PI / 4 * 0.08 * 0.08, kRing = kCap - M_PI / 4 * 0.05 * 0.05;

class Load : public Bench {
 public:
  Load()
      : Bench({0, 0, 0}, [](SystemGraph& graph) {
          auto& load =
              graph.add<RigidBody>("load", {.mass = kMass, .position = {0, 0, 0.3 + kAt}, .velocity = {0, 0, kSpeed}});
          graph.add<PrismaticJoint>("slide", {graph.ground().marker(), load.marker()});
          auto& oil = graph.add<FirstOrderStates>("oil", {.start = HydraulicCylinder::start(2e6 * kRing / kCap, 2e6)});
          graph.add<HydraulicCylinder>("cylinder", {graph.ground().marker(), load.marker(), oil.point(0)},
                                       {.bore = 0.08,
                                        .rod = 0.05,
                                        .stroke = kStroke,
                                        .closed_length = 0.3,
                                        .cap_dead_volume = kDead,
                                        .rod_dead_volume = kDead});
        }) {}
};

/// rad/s, of the load on its oil.
double frequency() {
  const double by_cap = kCap * kCap / (kDead + kCap * kAt), by_ring = kRing * kRing / (kDead + kRing * (kStroke - kAt));
  return std::sqrt(HydraulicOil{}.bulk_modulus * (by_cap + by_ring) / kMass);
}
const double kTurned = 0.5 * kMass * kSpeed * kSpeed;  // J, between load and oil

/// Classical Runge-Kutta is stable to h ω = √8.
Finding beyond() {
  const auto lives = [](double h) {
    Load scene;
    ExplicitIndex1 method({.step = h, .stabilisation = ExplicitIndex1::Stabilisation::position_velocity});
    return scene.run(method, 2000 * h, {}, 20 * kTurned).reached;
  };
  const double limit = std::sqrt(8.0) / frequency();
  const double step = largest_stable_step(lives, 0.7 * limit, 1.4 * limit, 1e-2);
  return {lives(1.1 * step) ? Outcome::converged : Outcome::unstable,
          {{"h ω at which the energy runs away", step * frequency(), std::sqrt(8.0), 1}},
          "a step must be shorter than the oil's period over 2.2; implicit methods step over it",
          step};
}
Finding judge(Integrator& method) {
  Load scene;
  const auto course = scene.run(method, 0.5, {}, 20 * kTurned);
  return {course.reached ? judged(course.energy_error / kTurned, 0.1) : Outcome::unstable,
          {{"energy error to 0.5 s, of the load's", course.energy_error / kTurned},
           {"steps in a period", static_cast<double>(course.steps) / (0.5 * frequency() / (2 * M_PI))}},
          course.why};
}

const Registered scene{with_candidates(
    {"F24", "a load on columns of oil", {{"RK4 beyond its limit", beyond, Role::also}}},
    {automatic(1e-6), radau(1e-6), lie_bdf(1e-6), runge_kutta8(1e-6), alpha(5e-5)}, {1e-6, 5e-5}, judge)};

}  // namespace
}  // namespace lithe::lab
