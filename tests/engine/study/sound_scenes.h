#pragma once

#include "bodies/integral_state.h"
#include "joints/forces/bushing.h"
#include "joints/forces/coordinate_spring.h"
#include "joints/forces/coordinate_stop.h"
#include "joints/forces/joint_friction.h"
#include "joints/forces/pid_controller.h"
#include "joints/planar_joint.h"
#include "joints/rolling_disc.h"
#include "joints/universal_joint.h"
#include "tests/engine/study/seeded_faults.h"

/// Scenes with no fault, about which a doctor must raise no alarm.
namespace lithe::test {

inline std::vector<Patient> sound_scenes() {
  std::vector<Patient> all;
  const auto add = [&](std::string name, StudyMethod method, double setting, double duration, Draw draw,
                       Vector3 gravity = {0, 0, -9.81}, double length = 1) {
    all.push_back({name,
                   Cause::unknown,
                   std::move(method),
                   setting,
                   {.name = name,
                    .duration = duration,
                    .gravity = gravity,
                    .characteristic_length = length,
                    .draw = std::move(draw)}});
  };
  const auto rk = runge_kutta_by_tolerance(), alpha = alpha_by_step(), ida = ida_by_tolerance();
  const auto watch_body = [](Body& body) { return std::vector<Sensor>{coordinates(body)}; };

  // ---- pendulums and chains ----
  const Draw pendulum = [=](SystemGraph& graph) { return watch_body(draw_pendulum(graph, 1)); };
  add("pendulum", rk, 1e-6, 5, pendulum);
  add("pendulum, IDA", ida, 1e-7, 3, pendulum);
  add("pendulum, generalized-alpha", alpha, 2e-3, 3, pendulum);
  add("pendulum, generalized-alpha of index 3", alpha_by_step(0.9, GeneralizedAlpha::Form::index3), 2e-3, 3, pendulum);
  add("pendulum, generalized-alpha by tolerance", alpha_by_tolerance(), 1e-6, 3, pendulum);
  add("pendulum, fixed Runge-Kutta steps", runge_kutta_by_step(), 0.01, 5, pendulum);
  add("pendulum that turns over", rk, 1e-7, 3,
      [=](SystemGraph& graph) { return watch_body(draw_pendulum(graph, 1, 12)); });
  add("pendulum of a ton", rk, 1e-6, 3,
      [=](SystemGraph& graph) { return watch_body(draw_pendulum(graph, 1, 0, 1000)); });
  const auto chain = [=](int links) {
    return [=](SystemGraph& graph) {
      Marker last = graph.ground().marker();
      RigidBody* bob = nullptr;
      for (int i = 1; i <= links; ++i) {
        bob = &graph.add<RigidBody>("bob " + std::to_string(i),
                                    {.mass = 1, .inertia = {0.1, 0.1, 0.1}, .position = Vector3(0.3 * i, 0, -0.1 * i)});
        graph.add<DistanceJoint>("rod " + std::to_string(i), {last, bob->marker()}, {});
        last = bob->marker();
      }
      return watch_body(*bob);
    };
  };
  add("chain of two", rk, 1e-8, 1, chain(2));
  add("chain of five", alpha, 1e-3, 0.5, chain(5));
  add("chain of twenty", rk, 1e-7, 0.3, chain(20));
  add("double pendulum, for a short time", rk, 1e-8, 3, [=](SystemGraph& graph) {
    auto& upper = draw_rod(graph, "upper", {0, 0, 0}, {1, 0, 0});
    auto& lower = draw_rod(graph, "lower", {1, 0, 0}, {2, 0, 0});
    graph.add<RevoluteJoint>("shoulder", {ground_at(graph, {0, 0, 0}), end_of(upper, 1, -1)});
    graph.add<SphericalJoint>("elbow", {end_of(upper, 1, 1), end_of(lower, 1, -1)});
    return watch_body(lower);
  });

  // ---- free bodies and tops ----
  const Draw tumbling = [=](SystemGraph& graph) {
    return watch_body(
        graph.add<RigidBody>("body", {.mass = 1, .inertia = {1, 2, 2.5}, .angular_velocity = {1, 2, -1}}));
  };
  add("tumbling body", rk, 1e-7, 5, tumbling, {0, 0, 0});
  add("tumbling body, generalized-alpha", alpha, 2e-3, 3, tumbling, {0, 0, 0});
  add("thrown body", ida, 1e-7, 1, tumbling);
  const Draw top = [=](SystemGraph& graph) {
    const Vector3 center(0, 0.3, 0), omega(0, 60, 1);
    auto& body = graph.add<RigidBody>("top", {.mass = 1,
                                              .inertia = {0.03, 0.01, 0.03},
                                              .position = center,
                                              .velocity = omega.cross(center),
                                              .angular_velocity = omega});
    graph.add<SphericalJoint>("tip", {graph.ground().marker(), body.marker(-center)});
    return watch_body(body);
  };
  add("heavy top", rk, 1e-7, 1, top);
  add("heavy top, IDA", ida, 1e-8, 0.5, top);
  add("shaft at 10000 rpm", rk, 1e-7, 0.2, [=](SystemGraph& graph) {
    auto& shaft =
        graph.add<RigidBody>("shaft", {.mass = 5, .inertia = {0.1, 0.1, 0.02}, .angular_velocity = {0, 0, 1047}});
    graph.add<RevoluteJoint>("bearing", {graph.ground().marker(), shaft.marker()});
    return std::vector<Sensor>{kinetic_energy()};
  });

  // ---- closed loops and drives ----
  const Draw four_bar = [=](SystemGraph& graph) {
    draw_parallelogram(graph, 1.2, 1, true);
    return std::vector<Sensor>{total_energy()};
  };
  add("four-bar", rk, 1e-7, 0.3, four_bar);
  add("four-bar, generalized-alpha", alpha, 1e-3, 0.3, four_bar);
  add("four-bar with redundant rows", rk, 1e-7, 0.3, [=](SystemGraph& graph) {
    draw_parallelogram(graph, 1.2, 1, false);
    return std::vector<Sensor>{total_energy()};
  });
  const auto slider_crank = [=](bool driven) {
    return [=](SystemGraph& graph) {
      auto& crank = draw_rod(graph, "crank", {0, 0, 0}, {0, 0, 0.5});
      auto& rod = draw_rod(graph, "rod", {0, 0, 0.5}, {std::sqrt(0.75), 0, 0});
      auto& pin = graph.add<RevoluteJoint>("main bearing", {ground_at(graph, {0, 0, 0}), end_of(crank, 0.5, -1)});
      graph.add<RevoluteJoint>("big end", {end_of(crank, 0.5, 1), end_of(rod, 1, -1)});
      graph.add<DistanceJoint>("guide", {graph.ground().marker({std::sqrt(0.75), 0, 100}), rod.marker({0.5, 0, 0})},
                               {});
      if (driven) graph.add<CoordinateDrive>("motor", {pin.angle()}, {.motion = ramp(-M_PI / 2, 5)});
      return watch_body(rod);
    };
  };
  add("driven slider-crank", alpha, 1e-3, 1, slider_crank(true));
  add("driven slider-crank, Runge-Kutta", rk, 1e-6, 1, slider_crank(true));
  add("falling slider-crank", rk, 1e-8, 0.3, slider_crank(false));
  add("arm moved to a place", alpha, 2e-3, 2, [=](SystemGraph& graph) {
    auto& rod = draw_rod(graph, "rod", {0, 0, 0}, {1, 0, 0});
    auto& pin = graph.add<RevoluteJoint>("pin", {ground_at(graph, {0, 0, 0}), end_of(rod, 1, -1)});
    graph.add<CoordinateDrive>("motor", {pin.angle()}, {.motion = smooth_step(0, 2, 0, 1)});
    return watch_body(rod);
  });
  add("cardan shaft", rk, 1e-7, 1, [=](SystemGraph& graph) {
    const Matrix3 bent = rotation_about({0, 1, 0}, 0.4);
    auto& in = graph.add<RigidBody>("in", {.mass = 1, .inertia = {0.1, 0.1, 0.05}});
    auto& out = graph.add<RigidBody>("out", {.mass = 1, .inertia = {0.1, 0.1, 0.05}, .orientation = bent});
    auto& bearing = graph.add<RevoluteJoint>("bearing", {graph.ground().marker(), in.marker()});
    graph.add<UniversalJoint>("cross", {in.marker(), out.marker()});
    graph.add<CoordinateMotor>("motor", {bearing.angle()}, {[](double, double, double) { return 0.2; }});
    return watch_body(out);
  });

  // ---- forces ----
  const auto oscillator = [=](double stiffness, double start) {
    return [=](SystemGraph& graph) {
      auto& block = graph.add<RigidBody>("block", {.mass = 1, .inertia = {0.01, 0.01, 0.01}});
      auto& slide = graph.add<PrismaticJoint>("slide", {graph.ground().marker(), block.marker()});
      graph.add<SpringDamper>("spring", {graph.ground().marker({0, 0, -1}), block.marker()},
                              {.stiffness = stiffness, .natural_length = 1 + start});
      return std::vector<Sensor>{coordinate(slide.displacement(), "x")};
    };
  };
  add("oscillator", rk, 1e-7, 5, oscillator(100, 0.1));
  add("oscillator of 100 Hz", rk, 1e-6, 0.5, oscillator(4e5, 0.01));
  add("stiff mount, generalized-alpha", alpha, 1e-3, 1, oscillator(1e9, 9.81e-9));
  add("spring pendulum", rk, 1e-8, 2, [=](SystemGraph& graph) {
    auto& bob = graph.add<RigidBody>("bob", {.mass = 1, .inertia = {0.1, 0.1, 0.1}, .position = {1, 0, 0}});
    graph.add<SpringDamper>("spring", {graph.ground().marker(), bob.marker()}, {.stiffness = 50, .damping = 0.1});
    return watch_body(bob);
  });
  add("block that bounces on a stop", rk, 1e-7, 2, [=](SystemGraph& graph) {
    auto& slide = draw_slide(graph, "block");
    graph.add<CoordinateStop>("stop", {slide.displacement()}, {.lower = -0.2, .stiffness = 2e4, .dissipation = 0.2});
    return std::vector<Sensor>{coordinate(slide.displacement(), "x")};
  });
  add("arm with friction in its bearing", alpha_by_tolerance(), 1e-6, 2, [=](SystemGraph& graph) {
    auto& rod = draw_rod(graph, "rod", {0, 0, 0}, {1, 0, 0});
    auto& pin = graph.add<RevoluteJoint>("pin", {ground_at(graph, {0, 0, 0}), end_of(rod, 1, -1)});
    graph.add<JointFriction>("rub", {pin.angle()},
                             {.joint = &pin, .coefficient = 0.1, .creep_speed = 0.03, .radius = 0.02});
    return watch_body(rod);
  });
  add("servo", rk, 1e-6, 2, [=](SystemGraph& graph) {
    auto& rod = draw_rod(graph, "rod", {0, 0, 0}, {1, 0, 0});
    auto& pin = graph.add<RevoluteJoint>("pin", {ground_at(graph, {0, 0, 0}), end_of(rod, 1, -1)});
    auto& memory = graph.add<IntegralState>("memory");
    graph.add<PidController>("servo", {pin.angle(), memory.coordinate()},
                             {.target = smooth_step(0, 1, 0, 1), .proportional = 60, .integral = 80, .derivative = 12});
    return watch_body(rod);
  });
  add("planet", rk, 1e-8, 6,
      [=](SystemGraph& graph) {
        auto& planet = graph.add<RigidBody>(
            "planet", {.mass = 1, .inertia = {0.1, 0.1, 0.1}, .position = {1, 0, 0}, .velocity = {0, 1.1, 0}});
        graph.add<UserForce>("sun", {planet.marker()},
                             {[](double, const MarkerView& m) { return force(-m.p / std::pow(m.p.norm(), 3)); }});
        return watch_body(planet);
      },
      {0, 0, 0});
  add("driven puck on a plane", rk, 1e-6, 3, [=](SystemGraph& graph) {
    auto& puck = graph.add<RigidBody>("puck", {.mass = 1, .inertia = {0.1, 0.1, 0.1}});
    graph.add<PlanarJoint>("table", {graph.ground().marker(), puck.marker()});
    graph.add<UserForce>("wind", {puck.marker()}, {[](double t, const MarkerView& m) {
                           return force({std::sin(3 * t) - 0.3 * m.v.x(), 0, 0});
                         }});
    return watch_body(puck);
  });
  add("rolling disc", rk, 1e-7, 2, [=](SystemGraph& graph) {
    const double r = 0.5, speed = 2;
    auto& disc = graph.add<RigidBody>("disc", {.mass = 1,
                                               .inertia = {0.0625, 0.0625, 0.125},
                                               .position = {0, 0, r},
                                               .orientation = rotation_about({1, 0, 0}, -M_PI / 2),
                                               .velocity = {speed * r, 0, 0},
                                               .angular_velocity = {0, 0, speed}});
    graph.add<RollingDisc>("contact", {graph.ground().marker(), disc.marker()}, {.radius = r});
    return watch_body(disc);
  });

  // ---- elastic bodies ----
  const auto bar = [=](double young) {
    return [=](SystemGraph& graph) {
      const FiniteElementModel model =
          bar_model({.size = {0.3, 0.04, 0.03}, .bricks = {4, 1, 1}, .young = young, .density = 1000});
      FlexibleBody::Parameters parameters{
          .basis = make_basis(model, ThreeNodeFrame{model.node_set("start")[0], model.node_set("end")[0], 2}, 4)};
      parameters.modal_coordinates = 1e-3 * VectorX::LinSpaced(4, 1, -0.5);
      parameters.angular_velocity = {8, 5, -6};
      return watch_body(graph.add<FlexibleBody>("bar", parameters));
    };
  };
  add("rubber bar", rk, 1e-6, 0.5, bar(3e6), {0, 0, 0});
  add("rubber bar, generalized-alpha", alpha, 5e-5, 0.05, bar(3e6), {0, 0, 0});
  return all;
}

}  // namespace lithe::test
