#include "tests/support/scenes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "bodies/rigid_body.h"
#include "joints/distance_joint.h"
#include "joints/revolute_joint.h"
#include "joints/spherical_joint.h"

namespace lithe::test {

Scene::Scene(const Vector3& gravity, const std::function<void(SystemGraph&)>& draw)
    : graph({.gravity = gravity}),
      system((draw(graph), assemble(graph))),
      equations(system),
      state(system.initial_state()) {}

Scene::~Scene() = default;

void Scene::run(Integrator& integrator, double t) {
  if (!started_) integrator.start(equations, state);
  started_ = true;
  while (state.time < t) {
    const StepResult result = integrator.step(equations, state, t);
    ASSERT_TRUE(result.ok()) << integrator.name() << " at t = " << state.time << ": " << result.why;
  }
}

double Scene::energy() {
  equations.evaluate(state.time, state.q, state.v, Level::velocity);
  return equations.energy().total();
}

double Scene::violation(Level level) {
  VectorX out(system.layout().row_count());
  equations.evaluate(state.time, state.q, state.v, Level::velocity);
  equations.constraint(level, out);
  return out.size() > 0 ? out.cwiseAbs().maxCoeff() : 0;
}

Vector3 Scene::position(int body) const { return state.q.segment<3>(7 * body); }

Scene mass_chain(std::initializer_list<double> angles) {
  return Scene({0, -9.81, 0}, [&](SystemGraph& graph) {
    Marker last = graph.ground().marker();
    Vector3 p = Vector3::Zero();
    int i = 0;
    for (double angle : angles) {
      const std::string number = std::to_string(++i);
      p += Vector3(std::sin(angle), -std::cos(angle), 0);
      auto& mass = graph.add<RigidBody>("mass " + number, {.mass = 1, .inertia = {1, 1, 1}, .position = p});
      graph.add<DistanceJoint>("rod " + number, {last, mass.marker()}, {.length = 1});
      last = mass.marker();
    }
  });
}

Scene box_chain(int links, bool revolute) {
  return Scene({0, 0, -9.81}, [&](SystemGraph& graph) {
    constexpr double length = 0.25, side = 0.025, mass = 500 * length * side * side;
    const double across = mass * (length * length + side * side) / 12;
    const Vector3 omega(0, 0, revolute ? 0 : 1);
    const auto axes = [&](int i) -> Matrix3 {
      if (!revolute) return Matrix3::Identity();
      return rotation_about(Vector3::UnitX(), i % 2 ? -M_PI / 2 : -M_PI / 4);
    };
    Marker last;
    for (int i = 1; i <= links; ++i) {
      const Vector3 center(length * (i - 0.5), 0, 0), half(length / 2, 0, 0);
      auto& link =
          graph.add<RigidBody>("link " + std::to_string(i), {.mass = mass,
                                                             .inertia = {mass * side * side / 6, across, across},
                                                             .position = center,
                                                             .velocity = omega.cross(center),
                                                             .angular_velocity = omega});
      const std::string name = "joint " + std::to_string(i);
      if (i == 1) last = graph.ground().marker(Vector3::Zero(), axes(1));
      const Marker here = link.marker(-half, axes(i));
      if (revolute)
        graph.add<RevoluteJoint>(name, {last, here});
      else
        graph.add<SphericalJoint>(name, {last, here});
      last = link.marker(half, axes(i + 1));
    }
  });
}

Vector3 link_end(const Scene& chain, int i) {
  if (i == 0) return Vector3::Zero();
  const Vector4 e = chain.state.q.segment<4>(7 * (i - 1) + 3);
  return chain.position(i - 1) + 0.125 * rotation_matrix(e).col(0);
}

Scene heavy_top(double mass, double length, double across, double axial, const Vector3& omega) {
  return Scene({0, 0, -9.81}, [&](SystemGraph& graph) {
    const Vector3 center(0, length, 0);
    auto& top = graph.add<RigidBody>("top", {.mass = mass,
                                             .inertia = {across, axial, across},
                                             .position = center,
                                             .velocity = omega.cross(center),
                                             .angular_velocity = omega});
    graph.add<SphericalJoint>("tip", {graph.ground().marker(), top.marker(-center)});
  });
}

Scene free_body(const Vector3& inertia, const Vector3& omega) {
  return Scene(Vector3::Zero(), [&](SystemGraph& graph) {
    graph.add<RigidBody>("body", {.mass = 1, .inertia = inertia, .angular_velocity = omega});
  });
}

}  // namespace lithe::test
