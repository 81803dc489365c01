// F30: a satellite unfolds a panel by a spring; a latch locks it at a right angle. Its momentum is zero all the time:
// how far the hub has turned then follows from the angle alone. A latch at the end of a step locks too late.
#include "bodies/rigid_body.h"
#include "engine/run/simulation.h"
#include "joints/forces/coordinate_spring.h"
#include "joints/forces/coordinate_stop.h"
#include "joints/revolute_joint.h"
#include "tools/stability/bench.h"
#include "tools/stability/scenes/candidates.h"

namespace lithe::lab {
namespace {

constexpr double kHub = 20, kHubInertia = 8, kPanel = 5, kPanelInertia = 1.7;  // kg, kg m²
constexpr double kHinge = 0.5, kArm = 1, kOpen = M_PI / 2;                     // m, m, rad
constexpr double kLimit = 1e-4;                                                // rad

/// Hub and panel, folded back by a right angle: the hinge turns from -π/2 to 0.
class Satellite : public Bench {
 public:
  explicit Satellite(double stop = 0)
      : Bench({0, 0, 0}, [&](SystemGraph& graph) {
          auto& hub = graph.add<RigidBody>("hub", {.mass = kHub, .inertia = {kHubInertia, kHubInertia, kHubInertia}});
          auto& panel = graph.add<RigidBody>("panel", {.mass = kPanel,
                                                       .inertia = {kPanelInertia, kPanelInertia, kPanelInertia},
                                                       .position = {kHinge, -kArm, 0},
                                                       .orientation = rotation_about({0, 0, 1}, -kOpen)});
          hinge = &graph.add<RevoluteJoint>("hinge", {hub.marker({kHinge, 0, 0}), panel.marker({-kArm, 0, 0})});
          graph.add<CoordinateSpring>("spring", {hinge->angle()}, {.stiffness = 3, .free_value = 0.5});
          if (stop > 0)
            graph.add<CoordinateStop>("latch", {hinge->angle()}, {.upper = 0, .stiffness = stop, .exponent = 1});
        }) {}
  double angle() {
    Snapshot now{system, state};
    return coordinate(hinge->angle(), "angle").value(now, 0);
  }
  double turned() const { return 2 * std::atan2(state.q[6], state.q[3]); }

  RevoluteJoint* hinge;
};

/// θ' = -φ' I_φ(φ) / I(φ), of zero angular momentum about the common centre, m = m_h m_p / (m_h + m_p):
///   I = J_h + J_p + m (a² + b² + 2 a b cos φ),   I_φ = J_p + m (b² + a b cos φ)
/// by Simpson's rule.
double hub_turn() {
  constexpr int kParts = 2000;
  const double m = kHub * kPanel / (kHub + kPanel), h = kOpen / kParts;
  double sum = 0;
  for (int i = 0; i <= kParts; ++i) {
    const double c = std::cos(-kOpen + i * h);
    const double whole = kHubInertia + kPanelInertia + m * (kHinge * kHinge + kArm * kArm + 2 * kHinge * kArm * c);
    const double panel = kPanelInertia + m * (kArm * kArm + kHinge * kArm * c);
    sum += (i == 0 || i == kParts ? 1 : i % 2 == 1 ? 4 : 2) * panel / whole;
  }
  return -sum * h / 3;
}

Finding judge(Satellite& satellite, std::string why = {}) {
  const double turned = satellite.turned(), expected = hub_turn();
  return {judged(turned - expected, kLimit),
          {{"hub turned beyond what it should, rad", turned - expected},
           {"it should, rad", expected},
           {"angle of the panel where it locks, rad", satellite.angle()}},
          std::move(why)};
}

Finding located(Integrator& method) {
  Satellite satellite;
  Simulation simulation{satellite.system, method};
  simulation.on({.name = "latch",
                 .function = watch(coordinate(satellite.hinge->angle(), "angle")),
                 .direction = Event::Direction::rising,
                 .action = Event::Action::stop});
  simulation.run(satellite.state, 100);
  return judge(satellite);
}

Finding at_the_end_of_a_step(double step) {
  Satellite satellite;
  const Method method = alpha_index2(step);
  method->start(satellite.equations, satellite.state);
  while (satellite.state.time < 100 && satellite.angle() < 0)
    if (const StepResult result = method->step(satellite.equations, satellite.state, 100); !result.ok())
      return {Outcome::refused, {{"stopped at, s", satellite.state.time}}, result.why};
  return judge(satellite, "locks where the step ends");
}

/// A stiff stop instead of a latch: the panel comes back.
Finding stop(double stiffness) {
  Satellite satellite(stiffness);
  const Method method = radau(1e-7).make();
  const Bench::Course course = satellite.run(*method, 20);
  return course.reached ? judge(satellite, "bounces for ever")
                        : Finding{Outcome::refused, {{"stopped at, s", course.end}}, course.why};
}

const Registered scene{
    with_candidates({"F30",
                     "a panel that locks",
                     {{"locked at the end of a step of 0.1 s", [] { return at_the_end_of_a_step(0.1); }, Role::also},
                      {"locked at the end of a step of 0.01 s", [] { return at_the_end_of_a_step(0.01); }, Role::also},
                      {"stop of 1e5 N m/rad", [] { return stop(1e5); }, Role::also}}},
                    {automatic(1e-6), radau(1e-6), runge_kutta8(1e-6), alpha(0.01)}, {1e-6, 0.01}, located)};

}  // namespace
}  // namespace lithe::lab
