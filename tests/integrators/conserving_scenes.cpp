#include "tests/integrators/conserving_scenes.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "bodies/flexible/reduction.h"
#include "bodies/rigid_body.h"
#include "joints/coordinate_drive.h"
#include "joints/forces/joint_friction.h"
#include "joints/revolute_joint.h"
#include "joints/rolling_disc.h"
#include "joints/spherical_joint.h"
#include "tests/bodies/bar_model.h"
#include "tests/support/methods.h"

namespace lithe::test {

FlexibleBody& add_bar(SystemGraph& graph, const Vector3& velocity, const Vector3& angular_velocity, double deflection) {
  static const FiniteElementModel model =
      bar_model({.size = {0.3, 0.04, 0.03}, .bricks = {4, 1, 1}, .young = 3e6, .density = 1000});
  static const auto basis =
      make_basis(model, ThreeNodeFrame{model.node_set("start")[0], model.node_set("end")[0], 2}, 4);
  FlexibleBody::Parameters parameters{.basis = basis};
  parameters.velocity = velocity;
  parameters.angular_velocity = angular_velocity;
  parameters.modal_coordinates = deflection * VectorX::LinSpaced(4, 1, -0.5);
  return graph.add<FlexibleBody>("bar", parameters);
}

Scene flexible_pendulum() {
  return Scene({0, 0, -9.81}, [](SystemGraph& graph) {
    FlexibleBody& bar = add_bar(graph, {0, 0, 0}, {0, 0, 0});
    const Matrix3 axes = rotation_about({1, 0, 0}, M_PI / 2);
    const std::vector<int> start = bar.basis().node_set("start");
    graph.add<RevoluteJoint>("pin", {graph.ground().marker(Vector3::Zero(), axes), bar.average(start, axes)});
  });
}

Scene rolling_disc() {
  return Scene({0, 0, -9.81}, [](SystemGraph& graph) {
    const double radius = 0.3, lean = 0.4;
    const Matrix3 axes = rotation_about({1, 0, 0}, -M_PI / 2 + lean);
    const Vector3 turn = axes * Vector3(0.3, 0.5, 6), up(0, -radius * std::sin(lean), radius * std::cos(lean));
    auto& disc = graph.add<RigidBody>("disc", {.mass = 2,
                                               .inertia = {0.045, 0.045, 0.09},
                                               .position = {0, 0, radius * std::cos(lean)},
                                               .orientation = axes,
                                               .velocity = turn.cross(up),
                                               .angular_velocity = Vector3(axes.transpose() * turn)});
    graph.add<RollingDisc>("rolling", {graph.ground().marker(), disc.marker()}, {.radius = radius});
  });
}

Scene driven_with_friction() {
  return Scene({0, 0, -9.81}, [](SystemGraph& graph) {
    const Matrix3 axes = rotation_about({1, 0, 0}, M_PI / 2);
    auto& crank = graph.add<RigidBody>("crank", {.mass = 1, .inertia = {0.01, 0.02, 0.02}, .position = {0.2, 0, 0}});
    auto& link = graph.add<RigidBody>("link", {.mass = 1, .inertia = {0.01, 0.02, 0.02}, .position = {0.6, 0, 0}});
    auto& hinge =
        graph.add<RevoluteJoint>("hinge", {graph.ground().marker({}, axes), crank.marker({-0.2, 0, 0}, axes)});
    graph.add<CoordinateDrive>("drive", {hinge.angle()}, {.motion = harmonic(0.5, 3)});
    auto& pin = graph.add<RevoluteJoint>("pin", {crank.marker({0.2, 0, 0}, axes), link.marker({-0.2, 0, 0}, axes)});
    graph.add<JointFriction>("rub", {pin.angle()},
                             {.joint = &pin, .coefficient = 0.3, .creep_speed = 1.5, .radius = 0.1});
  });
}

Errors difference(const State& a, const State& b) {
  return {(a.q - b.q).norm(), (a.v - b.v).norm(), (a.lambda - b.lambda).norm()};
}

void expect_order_two(const std::string& what, const Errors& coarse, const Errors& fine, double tolerance) {
  expect_below(what + ", order of q off 2 by", std::abs(std::log2(coarse.q / fine.q) - 2), tolerance);
  expect_below(what + ", order of v off 2 by", std::abs(std::log2(coarse.v / fine.v) - 2), tolerance);
  expect_below(what + ", order of λ off 2 by", std::abs(std::log2(coarse.lambda / fine.lambda) - 2), tolerance);
}

EnergyRecord record_energy(Scene& scene, Integrator& method, double end, int samples) {
  const double start = scene.energy();
  double sum_t = 0, sum_e = 0, sum_tt = 0, sum_te = 0, deviation = 0;
  for (int k = 1; k <= samples; ++k) {
    scene.run(method, end * k / samples);
    const double t = static_cast<double>(k) / samples - 0.5, e = scene.energy() - start;
    sum_t += t, sum_e += e, sum_tt += t * t, sum_te += t * e;
    deviation = std::max(deviation, std::abs(e));
  }
  return {(sum_te - sum_t * sum_e / samples) / (sum_tt - sum_t * sum_t / samples), deviation};
}

Scene free_pair() {
  return Scene(Vector3::Zero(), [](SystemGraph& graph) {
    auto& a = graph.add<RigidBody>("a", {.mass = 1, .inertia = {0.1, 0.2, 0.15}, .angular_velocity = {1, 2, 3}});
    auto& b = graph.add<RigidBody>("b", {.mass = 2,
                                         .inertia = {0.2, 0.1, 0.25},
                                         .position = {1, 0, 0},
                                         .velocity = Vector3(1, 2, 3).cross(Vector3(1, 0, 0)),
                                         .angular_velocity = {1, 2, 3}});
    graph.add<SphericalJoint>("joint", {a.marker({0.4, 0.2, 0}), b.marker({-0.6, 0.2, 0})});
  });
}

Vector6 momenta_of_pair(const Scene& scene) {
  const Vector3 inertia[] = {{0.1, 0.2, 0.15}, {0.2, 0.1, 0.25}};
  Vector6 sum = Vector6::Zero();
  for (int i = 0; i < 2; ++i) {
    const Vector3 P = (i + 1) * scene.state.v.segment<3>(6 * i);
    const Vector3 l = inertia[i].cwiseProduct(scene.state.v.segment<3>(6 * i + 3));
    sum.head<3>() += P;
    sum.tail<3>() += scene.position(i).cross(P) + rotation_matrix(scene.state.q.segment<4>(7 * i + 3)) * l;
  }
  return sum;
}

}  // namespace lithe::test
