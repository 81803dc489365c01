#include "tools/bench/scenes.h"

#include <stdexcept>

#include "bodies/flexible/readers/calculix.h"
#include "bodies/rigid_body.h"
#include "engine/assembly/batch_of.h"
#include "engine/assembly/evaluated.h"
#include "engine/model/joint_by_residual.h"
#include "joints/forces/bushing.h"
#include "joints/revolute_joint.h"
#include "joints/spherical_joint.h"
#include "joints/three_node_fixation.h"
#include "tools/bench/brick_mesh.h"

namespace lithe::bench {
namespace {

// A hinge turns about the z axes of its markers: here along the world's y axis.
const Matrix3 kAlongY = rotation_about({1, 0, 0}, -M_PI / 2);

struct DerivedBall final : JointByResidual<DerivedBall, 2, 3> {
  template <class S>
  void residual(std::span<const PoseOf<S>> m, S* g) const {
    for (int i = 0; i < 3; ++i) g[i] = m[1].p[i] - m[0].p[i];
  }
};

struct DerivedHinge final : JointByResidual<DerivedHinge, 2, 5> {
  template <class S>
  void residual(std::span<const PoseOf<S>> m, S* g) const {
    for (int i = 0; i < 3; ++i) g[i] = m[1].p[i] - m[0].p[i];
    g[3] = m[0].x().dot(m[1].z());
    g[4] = m[0].y().dot(m[1].z());
  }
};

}  // namespace

ChainJoint chain_joint(const std::string& name) {
  if (name == "spherical") return ChainJoint::spherical;
  if (name == "revolute") return ChainJoint::revolute;
  if (name == "spherical-derived") return ChainJoint::spherical_derived;
  if (name == "revolute-derived") return ChainJoint::revolute_derived;
  throw std::invalid_argument("no joint '" + name +
                              "'; known are spherical, revolute, spherical-derived, revolute-derived");
}

Marker draw_chain(SystemGraph& graph, int count, ChainJoint joint, std::vector<Marker>* ends) {
  const bool hinged = joint == ChainJoint::revolute || joint == ChainJoint::revolute_derived;
  const Matrix3 axes = hinged ? kAlongY : Matrix3(Matrix3::Identity());
  const Bushing::Parameters soft{.stiffness = Bushing::diagonal({1e6, 1e6, 1e6}, {0, 0, 0}),
                                 .damping = Bushing::diagonal({1e3, 1e3, 1e3}, {0, 0, 0})};
  Marker end = graph.ground().marker({0, 0, 0}, axes);
  for (int i = 0; i < count; ++i) {
    const std::string number = std::to_string(i + 1);
    auto& rod = graph.add<RigidBody>(
        "rod " + number, {.mass = 1, .inertia = {1.25e-3, 1.0 / 12, 1.0 / 12}, .position = {i + 0.5, 0, 0}});
    const Marker start = rod.marker({-0.5, 0, 0}, axes);
    switch (joint) {
      case ChainJoint::spherical:
        graph.add<SphericalJoint>("joint " + number, {end, start});
        break;
      case ChainJoint::revolute:
        graph.add<RevoluteJoint>("joint " + number, {end, start});
        break;
      case ChainJoint::bushing:
        graph.add<Bushing>("joint " + number, {end, start}, soft);
        break;
      case ChainJoint::spherical_derived:
        graph.add<DerivedBall>("joint " + number, {end, start});
        break;
      case ChainJoint::revolute_derived:
        graph.add<DerivedHinge>("joint " + number, {end, start});
        break;
    }
    end = rod.marker({0.5, 0, 0}, axes);
    if (ends) ends->push_back(end);
  }
  return end;
}

FiniteElementModel rod_model() {
  return read_calculix(std::string(LITHE_EXAMPLE_DATA) + "/pendulum/hex8i/calculix/matrices");
}

FiniteElementModel fine_rod_model() {
  return brick_model(
      {.bricks = {80, 6, 9}, .size = {0.1, 0.01, 0.015}, .young = 1e7, .poisson = 0.49, .density = 52000.0 / 3});
}

Marker draw_pendulum(SystemGraph& graph, const FiniteElementModel& model, const PendulumVariant& variant) {
  const std::vector<int>& edge = model.node_set("hinge");
  BodyFrame frame = HingeFrame{edge};
  if (variant.fixation) {
    const std::vector<int>& nodes = model.node_set("framea");
    frame = ThreeNodeFrame{nodes.at(0), nodes.at(1), nodes.at(2)};
  }
  auto& rod = graph.add<FlexibleBody>("rod", {.basis = make_basis(model, frame, variant.modes)});
  if (variant.fixation) {
    graph.add<ThreeNodeFixation>(
        "hinge", {graph.ground().marker(), rod.node(edge.at(0)), rod.node(edge.at(1)), rod.node(edge.at(2))});
  } else {
    Vector3 middle = Vector3::Zero();
    for (int id : edge) middle += model.nodes.col(model.node_index(id)) / static_cast<double>(edge.size());
    graph.add<RevoluteJoint>("hinge", {graph.ground().marker(middle, kAlongY), rod.average(edge, kAlongY)});
  }
  return rod.node(model.node_set("tip").front());
}

Cost measure(const Scene& scene, const Stepping& stepping) {
  Evaluator evaluator(scene.system);
  State state = scene.system.initial_state();
  GeneralizedAlpha integrator({.step = stepping.step,
                               .spectral_radius = stepping.spectral_radius,
                               .newton_tolerance = stepping.newton_tolerance,
                               .correct_start = false});  // as the hand-written programs start: comparable end points
  integrator.start(evaluator, state);
  const double started = cpu_seconds();
  for (long i = 1; i <= stepping.steps; ++i) {
    const StepResult result = integrator.step(evaluator, state, static_cast<double>(i) * stepping.step);
    if (!result.ok()) throw std::runtime_error(result.why);
  }
  Cost cost{.seconds = cpu_seconds() - started};
  const IntegratorStatistics& done = integrator.statistics();
  cost.steps = done.steps, cost.newton_iterations = done.newton_iterations, cost.factorizations = done.factorizations;
  evaluator.evaluate(state.time, state.q, state.v, Level::position);
  Eigen::Map<Vector3>(cost.tip) = marker_kinematics(evaluator, scene.tip, Level::position).p;
  return cost;
}

}  // namespace lithe::bench
