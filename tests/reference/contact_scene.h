#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bodies/rigid_body.h"
#include "engine/model/system_graph.h"
#include "engine/observe/contact_sensors.h"
#include "engine/run/simulation.h"
#include "integrators/automatic.h"
#include "integrators/moreau_jean.h"
#include "integrators/nonsmooth_generalized_alpha.h"
#include "joints/contact/contact.h"
#include "joints/coordinate_drive.h"
#include "joints/forces/spring_damper.h"
#include "joints/prismatic_joint.h"

namespace lithe::test {

enum class Stepper { moreau_jean, generalized_alpha };

/// Bodies that touch, stepped by one of the methods for rigid contacts: draw, start(), step() or run().
class ContactScene {
 public:
  explicit ContactScene(const Vector3& gravity = {0, 0, -9.81}) : graph({.gravity = gravity}) {}

  /// A uniform ball.
  RigidBody& sphere(const std::string& name, double radius, double mass, const Vector3& position,
                    const Vector3& velocity = Vector3::Zero(), const Vector3& spin = Vector3::Zero()) {
    const double J = 0.4 * mass * radius * radius;
    return graph.add<RigidBody>(
        name,
        {.mass = mass, .inertia = {J, J, J}, .position = position, .velocity = velocity, .angular_velocity = spin});
  }
  /// A uniform box.
  RigidBody& box(const std::string& name, const Vector3& edges, double mass, const Vector3& position,
                 const Matrix3& orientation = Matrix3::Identity(), const Vector3& velocity = Vector3::Zero()) {
    const Vector3 squares = edges.cwiseAbs2();
    return graph.add<RigidBody>(name, {.mass = mass,
                                       .inertia = Vector3(mass / 12 * (Vector3::Constant(squares.sum()) - squares)),
                                       .position = position,
                                       .orientation = orientation,
                                       .velocity = velocity});
  }
  Collider plane(const Point& position = {}, const Matrix3& axes = Matrix3::Identity()) {
    return {graph.ground().marker(position, axes), shape::half_space()};
  }
  Contact& contact(const std::vector<Collider>& colliders, double friction, double restitution = 0,
                   double rest_speed = 1e-3) {
    return graph.add<Contact>("contact", colliders,
                              {.law = RigidSurfaces{.restitution = restitution, .rest_speed = rest_speed},
                               .friction = {.coefficient = friction}});
  }

  void start(Stepper stepper, double step, ContactImpulses::Parameters parameters = {}) {
    step_ = step;
    system_.emplace(assemble(graph));
    if (stepper == Stepper::moreau_jean)
      integrator_ = std::make_unique<MoreauJean>(MoreauJean::Parameters{.step = step, .contact = parameters});
    else
      integrator_ = std::make_unique<NonsmoothGeneralizedAlpha>(
          NonsmoothGeneralizedAlpha::Parameters{.step = step, .contact = parameters});
    simulation_.emplace(*system_, *integrator_);
    snapshot_.emplace(*system_);
    state_ = system_->initial_state();
  }
  void step() { run(++steps_ * step_); }
  void run(double time) { simulation_->run(state_, time); }
  void set(const State& state) { state_ = state; }
  const State& state() const { return state_; }
  const System& system() const { return *system_; }
  const std::vector<EventRecord>& events() const { return simulation_->events(); }
  /// Axes of a body, by its place among those that move.
  Matrix3 axes(int body) const { return rotation_matrix(state_.q.segment<4>(7 * body + 3)); }
  double read(const Sensor& sensor, int column = 0) {
    snapshot_->evaluate(state_);
    return sensor.value(*snapshot_, column);
  }

  SystemGraph graph;

 private:
  double step_ = 0;
  long steps_ = 0;
  std::optional<System> system_;
  std::unique_ptr<Integrator> integrator_;
  std::optional<Simulation> simulation_;
  std::optional<Snapshot> snapshot_;
  State state_;
};

}  // namespace lithe::test
