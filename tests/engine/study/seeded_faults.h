#pragma once

#include <limits>

#include "bodies/flexible/flexible_body.h"
#include "bodies/flexible/reduction.h"
#include "engine/motion/projection.h"
#include "joints/coordinate_drive.h"
#include "joints/cylindrical_joint.h"
#include "joints/distance_joint.h"
#include "joints/fixed_joint.h"
#include "joints/forces/coordinate_motor.h"
#include "joints/forces/point_force.h"
#include "joints/forces/spring_damper.h"
#include "joints/forces/user_force.h"
#include "joints/prismatic_joint.h"
#include "joints/spherical_joint.h"
#include "tests/bodies/bar_model.h"
#include "tests/engine/study/doctor_scenes.h"

/// Scenes with one fault each, and the cause that a doctor must name first.
namespace lithe::test {

/// Explicit Euler in the chart, for free bodies: gains energy at any step (stability laboratory S21).
class ExplicitEuler final : public Integrator {
 public:
  explicit ExplicitEuler(double step) : step_(step) {}
  std::string name() const override { return "explicit Euler"; }
  const IntegratorStatistics& statistics() const override { return statistics_; }

 protected:
  void prepare(EquationsOfMotion& equations, State& state) override {
    statistics_ = {};
    Projector(equations).accelerations(state.time, state.q, state.v, state.v_dot, state.lambda);
  }
  StepResult advance(EquationsOfMotion& equations, State& state, double t_stop) override {
    const double h = std::min(step_, t_stop - state.time);
    const VectorX d = h * state.v;
    equations.layout().retract(state.q, d, state.q);
    state.v += h * state.v_dot;
    state.time = h < step_ ? t_stop : state.time + h;
    Projector(equations).accelerations(state.time, state.q, state.v, state.v_dot, state.lambda);
    ++statistics_.steps;
    return {};
  }

 private:
  double step_;
  IntegratorStatistics statistics_;
};

/// Two rods and a coupler of equal lengths, hinges about y: a parallelogram on feet 1 m apart, cranks at `angle` from
/// the x axis, turning at `speed`.
inline void draw_parallelogram(SystemGraph& graph, double angle, double speed, bool spherical) {
  const Vector3 foot(1, 0, 0), arm(std::cos(angle), 0, std::sin(angle)), omega(0, -speed, 0);
  const Vector3 at_end = omega.cross(arm);
  auto& left = draw_rod(graph, "left", {0, 0, 0}, arm, 1, at_end / 2, -speed);
  auto& right = draw_rod(graph, "right", foot, foot + arm, 1, at_end / 2, -speed);
  auto& bar = draw_rod(graph, "bar", arm, foot + arm, 1, at_end, 0);
  graph.add<RevoluteJoint>("left foot", {ground_at(graph, {0, 0, 0}), end_of(left, 1, -1)});
  graph.add<RevoluteJoint>("left elbow", {end_of(left, 1, 1), end_of(bar, 1, -1)});
  if (spherical) {  // 17 rows, none of which repeats another
    graph.add<SphericalJoint>("right elbow", {end_of(bar, 1, 1), end_of(right, 1, 1)});
    graph.add<CylindricalJoint>("right foot", {ground_at(graph, foot), end_of(right, 1, -1)});
  } else {
    graph.add<RevoluteJoint>("right elbow", {end_of(bar, 1, 1), end_of(right, 1, 1)});
    graph.add<RevoluteJoint>("right foot", {ground_at(graph, foot), end_of(right, 1, -1)});
  }
}

/// A block of 1 kg on a slide along world z, `first` its start.
inline PrismaticJoint& draw_slide(SystemGraph& graph, const std::string& name, double speed = 0, double mass = 1) {
  auto& block = graph.add<RigidBody>(name, {.mass = mass, .inertia = {0.01, 0.01, 0.01}, .velocity = {0, 0, speed}});
  return graph.add<PrismaticJoint>(name + " slide", {graph.ground().marker(), block.marker()});
}

inline std::vector<Patient> seeded_faults() {
  std::vector<Patient> all;
  const auto add = [&](std::string name, Cause cause, StudyMethod method, double setting, double duration, Draw draw,
                       Vector3 gravity = {0, 0, -9.81}, double length = 1) {
    all.push_back({name,
                   cause,
                   std::move(method),
                   setting,
                   {.name = name,
                    .duration = duration,
                    .gravity = gravity,
                    .characteristic_length = length,
                    .draw = std::move(draw)}});
  };
  const auto rk = runge_kutta_by_tolerance();
  const auto watch_body = [](Body& body) { return std::vector<Sensor>{coordinates(body)}; };

  // ---- rows that repeat others ----
  add("four-bar of spatial hinges", Cause::redundant_rows, alpha_by_step(), 1e-2, 1, [=](SystemGraph& graph) {
    draw_parallelogram(graph, 1.2, 1, false);
    return std::vector<Sensor>{total_energy()};
  });
  add("door on two hinges", Cause::redundant_rows, rk, 1e-6, 1, [=](SystemGraph& graph) {
    auto& door = graph.add<RigidBody>("door", {.mass = 20,
                                               .inertia = {5, 2, 7},
                                               .position = {0.4, 0, 1},
                                               .velocity = {0, 0.4, 0},
                                               .angular_velocity = {0, 0, 1}});
    for (double z : {-0.8, 0.8})
      graph.add<RevoluteJoint>(z < 0 ? "lower hinge" : "upper hinge",
                               {graph.ground().marker({0, 0, 1 + z}), door.marker({-0.4, 0, z})});
    return watch_body(door);
  });
  add("two clamps on one arm", Cause::redundant_rows, rk, 1e-6, 1, [=](SystemGraph& graph) {
    auto& rod = draw_pendulum(graph, 1);
    auto& load = graph.add<RigidBody>("load", {.mass = 1,
                                               .inertia = {0.01, 0.01, 0.01},
                                               .position = Vector3(std::sin(1.0), 0, -std::cos(1.0)),
                                               .orientation = rod.parameters().orientation});
    for (const char* name : {"clamp", "second clamp"})
      graph.add<FixedJoint>(name, {rod.marker({0.5, 0, 0}), load.marker()});
    return watch_body(load);
  });

  // ---- singular positions ----
  add("parallelogram started flat", Cause::singular_position, alpha_by_step(), 1e-3, 0.5, [=](SystemGraph& graph) {
    draw_parallelogram(graph, 0, 1, true);
    return std::vector<Sensor>{total_energy()};
  });
  add("two rods stretched between walls", Cause::singular_position, rk, 1e-6, 0.5, [=](SystemGraph& graph) {
    auto& knee = graph.add<RigidBody>(
        "knee", {.mass = 1, .inertia = {0.1, 0.1, 0.1}, .position = {1, 0, 0}, .velocity = {0, 0, 1}});
    graph.add<DistanceJoint>("left rod", {graph.ground().marker({0, 0, 0}), knee.marker()}, {});
    graph.add<DistanceJoint>("right rod", {graph.ground().marker({2, 0, 0}), knee.marker()}, {});
    return watch_body(knee);
  });

  // ---- the start ----
  add("velocity along the rod", Cause::inconsistent_start, rk, 1e-6, 1, [=](SystemGraph& graph) {
    auto& rod = draw_rod(graph, "rod", {0, 0, 0}, {1, 0, 0}, 1, {0.5, 0, 0}, 0);
    graph.add<RevoluteJoint>("pin", {ground_at(graph, {0, 0, 0}), end_of(rod, 1, -1)});
    return watch_body(rod);
  });
  add("spin without the speed that belongs to it", Cause::inconsistent_start, alpha_by_step(), 1e-2, 1,
      [=](SystemGraph& graph) {
        auto& top = graph.add<RigidBody>(
            "top", {.mass = 1, .inertia = {0.1, 0.02, 0.1}, .position = {0, 0.5, 0}, .angular_velocity = {0, 10, 3}});
        graph.add<SphericalJoint>("tip", {graph.ground().marker(), top.marker({0, -0.5, 0})});
        return watch_body(top);
      });
  add("omega given in the wrong axes", Cause::inconsistent_start, rk, 1e-6, 1, [=](SystemGraph& graph) {
    auto& rod = graph.add<RigidBody>("rod", {.mass = 1,
                                             .inertia = {0.001, 0.1, 0.1},
                                             .position = {0, 0.5, 0},
                                             .orientation = rotation_about({0, 0, 1}, M_PI / 2),
                                             .velocity = Vector3(2, 0, 0).cross(Vector3(0, 0.5, 0)),
                                             .angular_velocity = {2, 0, 0}});
    graph.add<SphericalJoint>("ball", {graph.ground().marker(), rod.marker({-0.5, 0, 0})});
    return watch_body(rod);
  });

  // ---- joints that do not close ----
  add("pin a centimetre off", Cause::open_joint, rk, 1e-6, 1, [=](SystemGraph& graph) {
    auto& rod = draw_rod(graph, "rod", {0, 0, 0}, {1, 0, 0});
    graph.add<RevoluteJoint>("pin", {ground_at(graph, {0, 0, 0.01}), end_of(rod, 1, -1)});
    return watch_body(rod);
  });
  add("loop with a gap", Cause::open_joint, alpha_by_step(), 1e-2, 1, [=](SystemGraph& graph) {
    auto& left = draw_rod(graph, "left", {0, 0, 0}, {0, 0, 1});
    auto& bar = draw_rod(graph, "bar", {0, 0, 1}, {1.1, 0, 1});
    graph.add<RevoluteJoint>("foot", {ground_at(graph, {0, 0, 0}), end_of(left, 1, -1)});
    graph.add<RevoluteJoint>("elbow", {end_of(left, 1, 1), end_of(bar, 1.1, -1)});
    graph.add<DistanceJoint>("stay", {graph.ground().marker({1, 0, 0}), bar.marker({0.55, 0, 0})}, {.length = 0.8});
    return watch_body(bar);
  });
  add("rods too short to meet", Cause::open_joint, rk, 1e-6, 1, [=](SystemGraph& graph) {
    auto& bob = graph.add<RigidBody>("bob", {.mass = 1, .inertia = {0.1, 0.1, 0.1}, .position = {1, 0, 0.3}});
    graph.add<DistanceJoint>("left", {graph.ground().marker({0, 0, 0}), bob.marker()}, {.length = 0.8});
    graph.add<DistanceJoint>("right", {graph.ground().marker({3, 0, 0}), bob.marker()}, {.length = 1.1});
    return watch_body(bob);
  });

  // ---- stiff pairs under explicit methods ----
  add("bump stop of steel", Cause::stiff, rk, 1e-6, 5, [=](SystemGraph& graph) {
    auto& rod = draw_pendulum(graph, 0.5);
    auto& bob = graph.add<RigidBody>(
        "bob",
        {.mass = 0.1, .inertia = {1e-3, 1e-3, 1e-3}, .position = Vector3(std::sin(0.5), 0, -std::cos(0.5) - 0.1)});
    graph.add<SpringDamper>("wire", {rod.marker({0.5, 0, 0}), bob.marker()}, {.stiffness = 1e8, .damping = 100});
    return watch_body(bob);
  });
  add("damper far too strong", Cause::stiff, rk, 1e-6, 5, [=](SystemGraph& graph) {
    auto& slide = draw_slide(graph, "block", 1, 0.01);
    auto& frame = graph.add<RigidBody>("frame", {.mass = 0.01, .inertia = {1e-3, 1e-3, 1e-3}, .position = {0, 0, 1}});
    graph.add<PrismaticJoint>("guide", {graph.ground().marker(), frame.marker()});
    graph.add<SpringDamper>("dashpot", {slide.markers()[1], frame.marker()}, {.stiffness = 10, .damping = 2e3});
    return watch_body(frame);
  });
  add("elastic bar with stiff modes", Cause::stiff, runge_kutta_by_step(), 1e-3, 1,
      [=](SystemGraph& graph) {
        static const FiniteElementModel model =
            bar_model({.size = {0.3, 0.04, 0.03}, .bricks = {4, 1, 1}, .young = 2e9, .density = 1000});
        static const auto basis =
            make_basis(model, ThreeNodeFrame{model.node_set("start")[0], model.node_set("end")[0], 2}, 4);
        FlexibleBody::Parameters parameters{.basis = basis};
        parameters.modal_coordinates = 1e-4 * VectorX::LinSpaced(4, 1, -0.5);
        return watch_body(graph.add<FlexibleBody>("bar", parameters));
      },
      {0, 0, 0});
  add("fixed step above the limit of a spring", Cause::stiff, runge_kutta_by_step(), 0.01, 5, [=](SystemGraph& graph) {
    auto& slide = draw_slide(graph, "block", 1);
    graph.add<SpringDamper>("spring", {graph.ground().marker({0, 0, -1}), slide.markers()[1]}, {.stiffness = 2e5});
    return std::vector<Sensor>{coordinate(slide.displacement(), "x")};
  });
  add("stiff law of the user's own", Cause::stiff, rk, 1e-6, 5, [=](SystemGraph& graph) {
    auto& bob = graph.add<RigidBody>("bob", {.mass = 1, .inertia = {0.1, 0.1, 0.1}, .velocity = {0, 0, 1e-3}});
    graph.add<UserForce>("glue", {bob.marker()},
                         {[](double, const MarkerView& m) { return force(-1e9 * m.p - 1e3 * m.v); }});
    return watch_body(bob);
  });

  // ---- laws that jump ----
  add("dry friction without smoothing", Cause::discontinuity, rk, 1e-6, 3, [=](SystemGraph& graph) {
    auto& slide = draw_slide(graph, "block", 2);
    graph.add<CoordinateMotor>("rub", {slide.displacement()},
                               {[](double, double, double rate) { return rate > 0 ? -12.0 : 12.0; }});
    return std::vector<Sensor>{coordinate(slide.displacement(), "x")};
  });
  add("relay control", Cause::discontinuity, ida_by_tolerance(), 1e-6, 5, [=](SystemGraph& graph) {
    auto& slide = draw_slide(graph, "block");
    graph.add<CoordinateMotor>("relay", {slide.displacement()},
                               {[](double, double x, double rate) { return x + rate > 0.1 ? -30.0 : 30.0; }});
    return std::vector<Sensor>{coordinate(slide.displacement(), "x")};
  });
  add("sign of a speed in a user's force", Cause::discontinuity, alpha_by_tolerance(), 1e-6, 3,
      [=](SystemGraph& graph) {
        auto& puck = graph.add<RigidBody>("puck", {.mass = 1, .inertia = {0.1, 0.1, 0.1}, .velocity = {1, 0, 0}});
        graph.add<UserForce>("rub", {puck.marker()}, {[](double, const MarkerView& m) {
                               return force({m.v.x() > 0 ? -3.0 : 3.0, 0, 0});
                             }});
        return watch_body(puck);
      },
      {0, 0, 0});

  add("thrust switched on and off", Cause::discontinuity, rk, 1e-9, 2, [=](SystemGraph& graph) {
    auto& rod = draw_pendulum(graph, 1);
    graph.add<UserForce>("thrust", {rod.marker()}, {[](double t, const MarkerView&) {
                           return force({std::fmod(t, 0.1) < 0.037 ? 5.0 : 0.0, 0, 0});
                         }});
    return watch_body(rod);
  });

  // ---- methods ----
  add("Euler's method on a tumbling body", Cause::unstable_method,
      {"Euler", StudyMethod::Setting::step, [](double h) { return std::make_unique<ExplicitEuler>(h); }}, 1.0 / 240, 15,
      [=](SystemGraph& graph) {
        return watch_body(
            graph.add<RigidBody>("body", {.mass = 1, .inertia = {1, 2, 3 - 1e-6}, .angular_velocity = {0.1, 10, 0.1}}));
      },
      {0, 0, 0});
  add("undamped trapezoidal rule on index 3", Cause::unstable_method,
      alpha_by_step(0.99999, GeneralizedAlpha::Form::index3), 0.005, 20, [=](SystemGraph& graph) {
        auto& bob = graph.add<RigidBody>("bob", {.mass = 1, .inertia = {0.1, 0.1, 0.1}, .position = {1, 0, 0}});
        graph.add<DistanceJoint>("string", {graph.ground().marker(), bob.marker()}, {});
        return watch_body(bob);
      });
  add("step too long for the motion", Cause::step_too_large, alpha_by_step(), 0.25, 10,
      [=](SystemGraph& graph) { return watch_body(draw_pendulum(graph, 2.5)); });
  add("tolerance too loose", Cause::step_too_large, rk, 0.3, 10,
      [=](SystemGraph& graph) { return watch_body(draw_pendulum(graph, 2.5)); });
  add("tolerance of 1e-16", Cause::below_round_off, rk, 1e-16, 1,
      [=](SystemGraph& graph) { return watch_body(draw_pendulum(graph, 1)); });
  add("tolerance of 1e-15, IDA", Cause::below_round_off, ida_by_tolerance(), 1e-15, 1,
      [=](SystemGraph& graph) { return watch_body(draw_pendulum(graph, 1)); });
  add("double pendulum for a minute", Cause::chaos, rk, 1e-6, 40, [=](SystemGraph& graph) {
    auto& upper = draw_rod(graph, "upper", {0, 0, 0}, {0, 0, 1});
    auto& lower = draw_rod(graph, "lower", {0, 0, 1}, {1, 0, 1});
    graph.add<RevoluteJoint>("shoulder", {ground_at(graph, {0, 0, 0}), end_of(upper, 1, -1)});
    graph.add<RevoluteJoint>("elbow", {end_of(upper, 1, 1), end_of(lower, 1, -1)});
    return watch_body(lower);
  });

  // ---- units ----
  add("gravity in millimetres", Cause::bad_unit, rk, 1e-6, 0.5,
      [=](SystemGraph& graph) { return watch_body(draw_pendulum(graph, 1)); }, {0, 0, -9810});
  add("inertia in kg mm²", Cause::bad_unit, rk, 1e-6, 1, [=](SystemGraph& graph) {
    auto& rod = graph.add<RigidBody>("rod", {.mass = 1, .inertia = {100, 83333, 83333}, .position = {0.5, 0, 0}});
    graph.add<RevoluteJoint>("pin", {ground_at(graph, {0, 0, 0}), rod.marker({-0.5, 0, 0}, along_y())});
    return watch_body(rod);
  });
  add(
      "lengths in millimetres", Cause::bad_unit, rk, 1e-6, 1,
      [=](SystemGraph& graph) {
        auto& link =
            graph.add<RigidBody>("link", {.mass = 3.9, .inertia = {6500, 332000, 332000}, .position = {500, 0, 0}});
        graph.add<RevoluteJoint>("pin", {ground_at(graph, {0, 0, 0}), link.marker({-500, 0, 0}, along_y())});
        return watch_body(link);
      },
      {0, 0, -9.81}, 1000);
  add("stiffness in the wrong unit", Cause::bad_unit, alpha_by_step(), 1e-3, 0.5, [=](SystemGraph& graph) {
    auto& slide = draw_slide(graph, "block");
    graph.add<SpringDamper>("mount", {graph.ground().marker({0, 0, -0.1}), slide.markers()[1]}, {.stiffness = 2.1e17});
    return std::vector<Sensor>{coordinate(slide.displacement(), "x")};
  });
  add("inertia of another sign convention", Cause::bad_parameter, rk, 1e-6, 1, [=](SystemGraph& graph) {
    return watch_body(graph.add<RigidBody>("rod", {.mass = 1, .inertia = {1, 0.1, 0.1}}));
  });
  add("negative mass", Cause::bad_parameter, rk, 1e-6, 1,
      [=](SystemGraph& graph) { return watch_body(graph.add<RigidBody>("rod", {.mass = -1})); });

  // ---- masses ----
  add("pin of a microgram between tons", Cause::mass_ratio, rk, 1e-6, 0.2, [=](SystemGraph& graph) {
    auto& rod = draw_pendulum(graph, 1, 0, 5000);
    auto& pin = graph.add<RigidBody>(
        "hook", {.mass = 1e-6, .inertia = {1e-9, 1e-9, 1e-9}, .position = Vector3(std::sin(1.0), 0, -std::cos(1.0))});
    graph.add<SphericalJoint>("eye", {rod.marker({0.5, 0, 0}), pin.marker()});
    return watch_body(rod);
  });
  add("body next to without inertia", Cause::mass_ratio, rk, 1e-6, 0.2, [=](SystemGraph& graph) {
    auto& rod = draw_pendulum(graph, 1);
    auto& bead = graph.add<RigidBody>(
        "bead", {.mass = 1, .inertia = {1e-14, 1e-14, 1e-14}, .position = Vector3(std::sin(1.0), 0, -std::cos(1.0))});
    graph.add<SphericalJoint>("eye", {rod.marker({0.5, 0, 0}), bead.marker()});
    return watch_body(bead);
  });

  // ---- ties ----
  add("forgotten joint", Cause::free_body, rk, 1e-6, 1, [=](SystemGraph& graph) {
    draw_pendulum(graph, 1);
    auto& cup = graph.add<RigidBody>("cup", {.mass = 1, .inertia = {0.01, 0.01, 0.01}, .position = {1, 0, 0}});
    return watch_body(cup);
  });
  add("two bodies tied to each other alone", Cause::free_body, rk, 1e-6, 1, [=](SystemGraph& graph) {
    auto& a = draw_rod(graph, "a", {0, 0, 0}, {1, 0, 0});
    auto& b = draw_rod(graph, "b", {1, 0, 0}, {2, 0, 0});
    graph.add<RevoluteJoint>("elbow", {end_of(a, 1, 1), end_of(b, 1, -1)});
    return watch_body(a);
  });
  add("truss", Cause::locked, rk, 1e-6, 1, [=](SystemGraph& graph) {
    auto& left = draw_rod(graph, "left", {0, 0, 0}, {0.5, 0, 0.8});
    auto& right = draw_rod(graph, "right", {1, 0, 0}, {0.5, 0, 0.8});
    const double L = std::sqrt(0.89);
    graph.add<RevoluteJoint>("left foot", {ground_at(graph, {0, 0, 0}), end_of(left, L, -1)});
    graph.add<RevoluteJoint>("right foot", {ground_at(graph, {1, 0, 0}), end_of(right, L, -1)});
    graph.add<DistanceJoint>("top", {left.marker({L / 2, 0, 0}), graph.ground().marker({0.5, 1, 0.8})}, {});
    graph.add<DistanceJoint>("stay", {right.marker({L / 2, 0, 0}), graph.ground().marker({1.5, 0, 0.8})}, {});
    return watch_body(left);
  });

  // ---- drives ----
  add("two drives of one shaft", Cause::incompatible_drive, rk, 1e-6, 1, [=](SystemGraph& graph) {
    auto& rod = draw_rod(graph, "rod", {0, 0, 0}, {1, 0, 0});
    auto& pin = graph.add<RevoluteJoint>("pin", {ground_at(graph, {0, 0, 0}), end_of(rod, 1, -1)});
    graph.add<CoordinateDrive>("motor", {pin.angle()}, {.motion = ramp(0, 1)});
    graph.add<CoordinateDrive>("brake", {pin.angle()}, {.motion = ramp(0, 2)});
    return watch_body(rod);
  });
  add("slider driven beyond the reach of its crank", Cause::incompatible_drive, alpha_by_step(), 1e-2, 2,
      [=](SystemGraph& graph) {
        auto& crank = draw_rod(graph, "crank", {0, 0, 0}, {0, 0, 0.5});
        auto& rod = draw_rod(graph, "rod", {0, 0, 0.5}, {std::sqrt(0.75), 0, 0});
        graph.add<RevoluteJoint>("foot", {ground_at(graph, {0, 0, 0}), end_of(crank, 0.5, -1)});
        graph.add<RevoluteJoint>("big end", {end_of(crank, 0.5, 1), end_of(rod, 1, -1)});
        const JointCoordinate reach{JointCoordinate::Kind::distance, graph.ground().marker({0, 0, 0}),
                                    rod.marker({0.5, 0, 0})};
        graph.add<CoordinateDrive>("piston", {reach}, {.motion = ramp(std::sqrt(0.75), 0.5)});
        return watch_body(rod);
      });

  // ---- a value that is not finite ----
  add("force that divides by zero at the start", Cause::no_number, rk, 1e-6, 1, [=](SystemGraph& graph) {
    auto& bob = graph.add<RigidBody>("bob", {.mass = 1, .inertia = {0.1, 0.1, 0.1}});
    graph.add<UserForce>("charge", {bob.marker()},
                         {[](double, const MarkerView& m) { return force(m.p / m.p.squaredNorm()); }});
    return watch_body(bob);
  });
  add("root of what becomes negative", Cause::no_number, alpha_by_step(), 1e-2, 2, [=](SystemGraph& graph) {
    auto& slide = draw_slide(graph, "block");
    graph.add<CoordinateMotor>("pump", {slide.displacement()},
                               {[](double, double x, double) { return std::sqrt(1 + x); }});
    return std::vector<Sensor>{coordinate(slide.displacement(), "x")};
  });
  add("table that ends", Cause::no_number, rk, 1e-6, 2, [=](SystemGraph& graph) {
    auto& rod = draw_pendulum(graph, 1);
    graph.add<UserForce>("wind", {rod.marker()}, {[](double t, const MarkerView&) {
                           return force({t < 0.7 ? 1.0 : std::numeric_limits<double>::quiet_NaN(), 0, 0});
                         }});
    return watch_body(rod);
  });
  return all;
}

}  // namespace lithe::test
