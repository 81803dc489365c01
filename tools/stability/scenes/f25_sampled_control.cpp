// F25: a mass under sampled control: stable gains end where the sampling does not follow, and sooner with a delay. No
// method cures that: the integration between samples is exact.
#include "bodies/rigid_body.h"
#include "engine/base/dense.h"
#include "engine/run/simulation.h"
#include "joints/control/sampled_controller.h"
#include "joints/forces/coordinate_motor.h"
#include "joints/prismatic_joint.h"
#include "tools/stability/bench.h"
#include "tools/stability/scenes/candidates.h"

namespace lithe::lab {
namespace {

constexpr double kInterval = 0.02, kDamping = 30, kStart = 0.1;  // s; 1/s; m
constexpr int kSamples = 150;

/// Place of 1 kg after some samples, in parts of where it began: force -k x - d v, held; `delay` in intervals.
double amplitude(double stiffness, double delay, Integrator& method) {
  PrismaticJoint* slide = nullptr;
  Input* force = nullptr;
  Bench scene({0, 0, 0}, [&](SystemGraph& graph) {
    auto& mass = graph.add<RigidBody>("mass", {.mass = 1, .position = {0, 0, kStart}});
    slide = &graph.add<PrismaticJoint>("slide", {graph.ground().marker(), mass.marker()});
    force = &graph.add<Input>("force", {.unit = "N"});
    graph.add<CoordinateMotor>("motor", {slide->displacement()}, {.effort = *force});
  });
  SampledController controller(
      {.name = "pd",
       .interval = kInterval,
       .delay = delay * kInterval,
       .inputs = {{coordinate(slide->displacement(), "x")}, {coordinate_rate(slide->displacement(), "v")}},
       .outputs = {force},
       .law = discrete_state_space(MatrixX(0, 0), MatrixX(0, 2), MatrixX(1, 0), MatrixX{{-stiffness, -kDamping}})});
  Simulation simulation{scene.system, method};
  controller.join(simulation);
  double largest = 0;
  for (int k = 0; k < kSamples; ++k) {
    simulation.run(scene.state, kInterval * (k + 1));
    if (k > kSamples / 2) largest = std::max(largest, std::abs(scene.state.q[2]));
  }
  return largest / kStart;
}
/// Largest |z| of the sampled system (x, v, last force): force of the sample before with a delay of one interval.
double radius(double stiffness, bool delayed) {
  const double T = kInterval;
  MatrixX A{{1, T, 0}, {0, 1, 0}, {-stiffness, -kDamping, 0}};
  const Vector3 by_force(T * T / 2, T, 0);
  if (delayed)
    A.col(2) += by_force;
  else
    A += by_force * A.row(2);
  return Eigen::EigenSolver<MatrixX>(A, false).eigenvalues().cwiseAbs().maxCoeff();
}
/// By bisection of a growing function.
double level_crossing(const std::function<bool(double)>& stable, double low, double high) {
  for (int i = 0; i < 30; ++i) (stable(0.5 * (low + high)) ? low : high) = 0.5 * (low + high);
  return low;
}

Finding at(double share, bool delayed) {
  const double limit = level_crossing([&](double k) { return radius(k, delayed) < 1; }, 1, 1e5);
  const Method method = radau(1e-8).make();
  const double size = amplitude(share * limit, delayed, *method);
  const double found = level_crossing(
      [&](double k) {
        const Method each = radau(1e-8).make();
        const double first = amplitude(k, delayed, *each);
        return first < 1;
      },
      0.8 * limit, 1.2 * limit);
  return {
      judged(size, 0.5, 1),
      {{"largest gain k T / 2 d by runs", found * kInterval / (2 * kDamping), limit * kInterval / (2 * kDamping), 1},
       {"amplitude after 1.5 s to 3 s, of the start", size}},
      "sampled gains end at the unit circle, whatever integrates between"};
}
Finding judge(Integrator& method) {
  const double limit = level_crossing([&](double k) { return radius(k, false) < 1; }, 1, 1e5);
  const double size = amplitude(0.8 * limit, 0, method);
  return {judged(size, 0.5, 1), {{"amplitude, of the start", size}}};
}

const Registered scene{with_candidates(
    {"F25",
     "sampled control at its limit",
     {{"gain 8 % beyond its limit", [] { return at(1.08, false); }, Role::also},
      {"gain 15 % beyond its limit with a delay of one sample", [] { return at(1.15, true); }, Role::also},
      {"a gain that is stable without the delay, with it",
       [] {
         const Method method = radau(1e-8).make();
         const double limit = level_crossing([&](double k) { return radius(k, false) < 1; }, 1, 1e5);
         const double size = amplitude(0.8 * limit, 1, *method);
         return Finding{judged(size, 0.5, 1), {{"amplitude, of the start", size}}};
       },
       Role::also}}},
    {automatic(1e-6), radau(1e-6), runge_kutta8(1e-6), alpha(1e-3)}, {1e-6, 1e-3}, judge)};

}  // namespace
}  // namespace lithe::lab
