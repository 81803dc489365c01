// F27: a rod leans in a slot that its tip slides along (Painlevé's rod in a joint, C07). From μ = 4/3 on its friction
// loads itself without bound: no acceleration solves the equations, the tip jams in no time.
#include "bodies/rigid_body.h"
#include "integrators/moreau_jean.h"
#include "integrators/nonsmooth_generalized_alpha.h"
#include "joints/forces/joint_coulomb_friction.h"
#include "joints/forces/joint_friction.h"
#include "joints/point_on_line_joint.h"
#include "tools/stability/bench.h"
#include "tools/stability/scenes/candidates.h"

namespace lithe::lab {
namespace {

constexpr double kFriction = 1.4, kEnd = 1e-3;  // s
const double kLean = std::atan(2.0);
// About the tip, of a bar whose middle moved with -1 m/s: (1/12 + 1/4) ω = sin / 2.
const double kTurns = 1.5 * std::sin(kLean);

class Rod : public Bench {
 public:
  explicit Rod(double creep_speed)
      : Bench({0, 0, -9.81}, [&](SystemGraph& graph) {
          const Vector3 arm(std::cos(kLean) / 2, 0, std::sin(kLean) / 2);
          const Matrix3 along = rotation_about({0, 1, 0}, M_PI / 2);
          auto& rod = graph.add<RigidBody>(
              "rod", {.mass = 1, .inertia = {1, 1.0 / 12, 1}, .position = arm, .velocity = {-1, 0, 0}});
          auto& slot = graph.add<PointOnLineJoint>("slot", {graph.ground().marker({}, along), rod.marker(-arm)});
          if (creep_speed > 0)
            graph.add<JointFriction>("rub", {slot.displacement()},
                                     {.joint = &slot, .coefficient = kFriction, .creep_speed = creep_speed});
          else
            add_joint_coulomb_friction(graph, "rub", {slot.displacement()}, {.joint = &slot, .coefficient = kFriction});
        }) {}
};

Finding jams(Integrator& method, double creep_speed = 0) {
  Rod rod(creep_speed);
  const double start = rod.energy();
  double highest = start;
  const Bench::Course course = rod.run(
      method, kEnd, [&] { highest = std::max(highest, rod.energy()); }, 10 * start);
  if (!course.reached) return {Outcome::refused, {{"stopped at, s", course.end}}, course.why};
  const double turns = -rod.state.v[4];
  const double free = kEnd * 1.5 * 9.81 * std::cos(kLean);  // gravity goes on about the tip
  return {judged(turns / (kTurns - free) - 1, 0.01, 1),
          {{"turns after it has jammed, rad/s", turns, kTurns - free, 2}, {"energy gained, J", highest - start}}};
}

template <class Stepper>
Cell set_valued(const std::string& name, double step) {
  return {"set-valued, " + name + ", h = " + figure_text(step),
          [step] {
            Stepper method({.step = step});
            return jams(method);
          },
          Role::also};
}
Cell smoothed(const Candidate& candidate, double creep_speed) {
  return {"friction smoothed below " + figure_text(creep_speed) + " m/s, " + candidate.name,
          [candidate, creep_speed] {
            const Method method = candidate.make();
            return jams(*method, creep_speed);
          },
          Role::also};
}

const Registered scene{under_every_method(
    {"F27",
     "a joint that jams",
     {set_valued<MoreauJean>("Moreau-Jean", 1e-4),
      set_valued<NonsmoothGeneralizedAlpha>("nonsmooth generalized-alpha", 1e-4), smoothed(automatic(1e-6), 1e-3),
      smoothed(radau(1e-6), 1e-3), smoothed(alpha(1e-5), 1e-3)}},
    {1e-6, 1e-4}, [](Integrator& method) { return jams(method, method.handles_rigid_contacts() ? 0 : 1e-3); })};

}  // namespace
}  // namespace lithe::lab
