// F26: a block at rest on a slide that its friction holds, for a minute. Regularised friction creeps, by exactly what
// it takes to be as large as the load; set-valued friction and bristles hold.
#include "bodies/rigid_body.h"
#include "integrators/moreau_jean.h"
#include "integrators/nonsmooth_generalized_alpha.h"
#include "joints/forces/joint_bristles.h"
#include "joints/forces/joint_coulomb_friction.h"
#include "joints/forces/joint_friction.h"
#include "joints/prismatic_joint.h"
#include "tools/stability/bench.h"
#include "tools/stability/scenes/candidates.h"

namespace lithe::lab {
namespace {

constexpr double kFriction = 0.3, kSlope = 0.28, kMass = 2, kEnd = 60, kGravity = 9.81;  // tan 0.28 = 0.2876
constexpr double kLimit = 1e-6;                                                          // m

enum class Law { regularised, bristles, set_valued };

class Block : public Bench {
 public:
  explicit Block(Law law, double creep_speed = 0)
      : Bench({0, 0, -kGravity}, [&](SystemGraph& graph) {
          const Matrix3 along = rotation_about({0, 1, 0}, M_PI / 2 + kSlope);
          auto& block = graph.add<RigidBody>("block", {.mass = kMass});
          auto& slide = graph.add<PrismaticJoint>("slide", {graph.ground().marker({}, along), block.marker({}, along)});
          if (law == Law::regularised)
            graph.add<JointFriction>("rub", {slide.displacement()},
                                     {.joint = &slide, .coefficient = kFriction, .creep_speed = creep_speed});
          if (law == Law::bristles) {
            // Hung as the slope asks.
            const VectorX start =
                JointBristles::start(kMass * kGravity * std::cos(kSlope), {std::tan(kSlope) / kFriction, 0, 0});
            add_joint_bristles(graph, "rub", {slide.displacement()},
                               graph.add<FirstOrderStates>("bristles", {.start = start}),
                               {.joint = &slide, .coefficient = kFriction});
          }
          if (law == Law::set_valued)
            add_joint_coulomb_friction(graph, "rub", {slide.displacement()},
                                       {.joint = &slide, .coefficient = kFriction});
        }) {}
};

Finding creep(Law law, Integrator& method, double creep_speed = 0) {
  Block block(law, creep_speed);
  const Bench::Course course = block.run(method, kEnd);
  const double moved = block.state.q.head<3>().norm();
  Figure figure{"creep in a minute, m", moved};
  if (law == Law::regularised) figure.published = kEnd * creep_speed / 3 * std::atanh(std::tan(kSlope) / kFriction);
  return {course.reached ? judged(moved, kLimit, 1) : Outcome::unstable, {figure}, course.why};
}

template <class Stepper>
Cell set_valued(const std::string& name, double step) {
  return {"set-valued, " + name + ", h = " + figure_text(step),
          [step] {
            Stepper method({.step = step});
            return creep(Law::set_valued, method);
          },
          Role::also};
}

Finding smoothed(double creep_speed) {
  const Method method = radau(1e-8).make();
  return creep(Law::regularised, *method, creep_speed);
}

const Registered scene{with_candidates({"F26",
                                        "a block at rest on a slide",
                                        {{"friction smoothed below 3 mm/s", [] { return smoothed(3e-3); }, Role::also},
                                         {"friction smoothed below 10 µm/s", [] { return smoothed(1e-5); }, Role::also},
                                         set_valued<MoreauJean>("Moreau-Jean", 1e-2),
                                         set_valued<NonsmoothGeneralizedAlpha>("nonsmooth generalized-alpha", 1e-2)}},
                                       {automatic(1e-7), radau(1e-7), alpha(1e-2)}, {1e-7, 1e-2},
                                       [](Integrator& method) { return creep(Law::bristles, method); })};

}  // namespace
}  // namespace lithe::lab
