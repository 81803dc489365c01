#include "bodies/beam/beam.h"
#include "bodies/beam/beam_model.h"
#include "bodies/cable/cable.h"
#include "bodies/flexible/flexible_body.h"
#include "bodies/point_mass.h"
#include "engine/observe/sensors.h"
#include "joints/contact/contact.h"
#include "joints/fixed_joint.h"
#include "joints/forces/bushing.h"
#include "joints/forces/coordinate_spring.h"
#include "joints/forces/spring_damper.h"
#include "joints/forces/user_force.h"
#include "joints/prismatic_joint.h"
#include "joints/revolute_joint.h"
#include "joints/spherical_joint.h"
#include "tests/doctor_judged/seeded_errors.h"

namespace lithe::test {
std::vector<JudgedScene> sound_oddities() {
  return {
      {{.name = "a resonator of 100 µm and 1 µg at 16 kHz",
        .duration = 1e-3,
        .characteristic_length = 1e-6,
        .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
          auto& mass = graph.add<RigidBody>(
              "proof mass", {.mass = 1e-9, .inertia = {1e-18, 1e-18, 1.5e-18}, .velocity = {1e-2, 0, 0}});
          auto& slide = tie<PrismaticJoint>(graph, "slide", graph.ground(), mass, kO, kAlong);
          graph.add<CoordinateSpring>("suspension", {slide.displacement()}, {.stiffness = 10, .damping = 1e-6});
          return {coordinate(slide.displacement(), "displacement")};
        }},
       "automatic",
       1e-9},
      {{.name = "a ship of 20,000 t moored by fenders",
        .duration = 20,
        .characteristic_length = 100,
        .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
          auto& ship =
              graph.add<RigidBody>("ship", {.mass = 2e7, .inertia = {2e9, 4e10, 4e10}, .velocity = {0, 0.2, 0}});
          graph.add<Bushing>("water and fenders", {graph.ground().marker(), ship.marker()},
                             {.stiffness = Bushing::diagonal({2e6, 5e6, 3e7}, {3e9, 6e10, 5e9}),
                              .damping = Bushing::diagonal({1e6, 5e6, 2e7}, {3e8, 1e10, 1e9})});
          return {position(ship.marker(), "ship")};
        }}},
      {{.name = "a satellite unfolds its panel in free flight",
        .duration = 5,
        .gravity = {0, 0, 0},
        .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
          auto& bus = graph.add<RigidBody>("bus", {.mass = 400, .inertia = {90, 80, 70}});
          auto& panel = graph.add<RigidBody>("panel", {.mass = 15, .inertia = {5, 2, 7}, .position = {0.5, 0, 1.5}});
          auto& hinge = tie<RevoluteJoint>(graph, "hinge", bus, panel, {0.5, 0, 0.5});
          graph.add<CoordinateSpring>("spring", {hinge.angle()}, {.stiffness = 2, .damping = 3, .free_value = 1.57});
          return {coordinate(hinge.angle(), "angle"), angular_velocity(bus.marker(), "bus")};
        }}},
      {{.name = "a thrown stone",
        .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
          auto& stone = graph.add<RigidBody>(
              "stone",
              {.mass = 0.4, .inertia = {2e-4, 3e-4, 4e-4}, .velocity = {8, 0, 6}, .angular_velocity = {3, 0.1, 20}});
          return {position(stone.marker(), "stone")};
        }}},
      {{.name = "a top spins fast on its point",
        .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
          const Matrix3 tilt = rotation_about(kAcross, 0.3);
          auto& top = graph.add<RigidBody>("top", {.mass = 0.3,
                                                   .inertia = {4e-4, 4e-4, 2e-4},
                                                   .position = tilt * Vector3(0, 0, 0.05),
                                                   .orientation = tilt,
                                                   .angular_velocity = {0, 0, 300}});
          graph.add<SphericalJoint>("point", {graph.ground().marker(), top.marker({0, 0, -0.05})});
          return {position(top.marker({0, 0, 0.05}), "head")};
        }}},
      {{.name = "a machine tool: a tip of 2 g on a bed of 50 t",
        .duration = 0.2,
        .characteristic_length = 0.01,
        .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
          auto& bed = graph.add<RigidBody>("bed", {.mass = 5e4, .inertia = {6e4, 9e4, 9e4}});
          graph.add<Bushing>("feet", {graph.ground().marker(), bed.marker()},
                             {.stiffness = Bushing::diagonal({1e9, 1e9, 1e9}, {1e9, 1e9, 1e9}),
                              .damping = Bushing::diagonal({1e6, 1e6, 1e6}, {1e6, 1e6, 1e6})});
          auto& tip = graph.add<RigidBody>(
              "tip", {.mass = 2e-3, .inertia = {4e-8, 4e-8, 4e-8}, .position = {0, 0, 1}, .velocity = {0.01, 0, 0}});
          auto& slide = tie<PrismaticJoint>(graph, "quill", bed, tip, {0, 0, 1}, kAlong);
          graph.add<CoordinateSpring>("collet", {slide.displacement()}, {.stiffness = 1e4, .damping = 1});
          return {coordinate(slide.displacement(), "tip")};
        }},
       "Radau IIA 5"},
      {{.name = "two valve springs, one inside the other",
        .characteristic_length = 0.05,
        .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
          auto& valve =
              graph.add<RigidBody>("valve", {.mass = 0.08, .inertia = {5e-5, 5e-5, 1e-5}, .position = {0, 0, 0.04}});
          tie<PrismaticJoint>(graph, "stem", graph.ground(), valve, {0, 0, 0.04}, kUp);
          for (const auto& [name, stiffness] : {std::pair{"outer", 3000.0}, std::pair{"inner", 1200.0}})
            graph.add<SpringDamper>(name, {graph.ground().marker(), valve.marker()},
                                    {.stiffness = stiffness, .damping = 2, .natural_length = 0.045});
          return {height(valve.marker(), "valve")};
        }}},
      {{.name = "a soft seat that sags by a quarter of its height, as designed",
        .duration = 3,
        .characteristic_length = 0.4,
        .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
          auto& seat = graph.add<RigidBody>("seat", {.mass = 80, .inertia = {6, 6, 4}, .position = {0, 0, 0.4}});
          tie<PrismaticJoint>(graph, "rail", graph.ground(), seat, {0, 0, 0.4}, kUp);
          graph.add<SpringDamper>("cushion", {graph.ground().marker(), seat.marker()},
                                  {.stiffness = 7848, .damping = 500});
          return {height(seat.marker(), "seat")};
        }}},
      {{.name = "a flexible cantilever with six modes under its end load",
        .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
          SystemGraph drawing;
          const Beam& beam =
              drawing.add<Beam>("beam", {.axis = BeamAxis::straight(kO, kAlong, kAcross),
                                         .sections = {{0, BeamSection::rectangle(0.02, 0.01, {7e10, 0.3, 2700})}},
                                         .elements = 10});
          auto& boom = graph.add<FlexibleBody>(
              "boom", {.basis = make_basis(beam, TangentFrame{{1}}, 6), .damping = {.modal_ratios = {0.02}}});
          graph.add<FixedJoint>("clamp", {graph.ground().marker(), boom.node(1)});
          auto& load =
              graph.add<RigidBody>("load", {.mass = 0.5, .inertia = {1e-4, 1e-4, 1e-4}, .position = {1, 0, 0}});
          graph.add<FixedJoint>("hook", {boom.node(11), load.marker()});
          return {height(load.marker(), "load")};
        }},
       "Radau IIA 5"},
      {{.name = "a strip of spring steel swings from a hinge, far bent",
        .duration = 0.5,
        .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
          auto& strip =
              graph.add<Beam>("strip", {.axis = BeamAxis::straight(kO, kAlong, kAcross),
                                        .sections = {{0, BeamSection::rectangle(0.02, 5e-4, {2.1e11, 0.3, 7850})}},
                                        .elements = 8});
          graph.add<RevoluteJoint>(
              "hinge", {graph.ground().marker(kO, axes_of(kAcross)), strip.marker_at_world(kO, axes_of(kAcross))});
          return {position(strip.marker(1), "end")};
        }},
       "Radau IIA 5",
       1e-5},
      {{.name = "a rope with a stone at its end",
        .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
          auto& rope = graph.add<Cable>("rope", {.from = {0, 0, 0},
                                                 .to = {0.7, 0, -0.7},
                                                 .elements = 10,
                                                 .mass_per_length = 0.1,
                                                 .axial_stiffness = 2e4,
                                                 .axial_damping = 5});
          auto& stone = graph.add<PointMass>("stone", {.mass = 1, .position = {0.7, 0, -0.7}});
          graph.add<SphericalJoint>("eye", {graph.ground().marker(), rope.start()});
          graph.add<SphericalJoint>("knot", {rope.end(), stone.marker()});
          return {position(stone.marker(), "stone")};
        }},
       "Radau IIA 5",
       1e-5},
      {{.name = "a rubber ball bounces on the floor",
        .duration = 1.5,
        .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
          auto& ball =
              graph.add<RigidBody>("ball", {.mass = 0.3, .inertia = {1e-3, 1e-3, 1e-3}, .position = {0, 0, 0.6}});
          graph.add<Contact>("floor",
                             {{graph.ground().marker(), shape::half_space()}, {ball.marker(), shape::sphere(0.1)}},
                             {.law = Compliance{.stiffness = 2e5, .restitution = 0.7}});
          return {height(ball.marker(), "ball")};
        }}},
      {{.name = "a steel ball lies on the floor, pressed in by its weight",
        .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
          const double depth = std::pow(4 * 9.81 / 1e7, 2.0 / 3);
          auto& ball = graph.add<RigidBody>(
              "ball", {.mass = 4, .inertia = {0.016, 0.016, 0.016}, .position = {0, 0, 0.1 - depth}});
          graph.add<Contact>("floor",
                             {{graph.ground().marker(), shape::half_space()}, {ball.marker(), shape::sphere(0.1)}},
                             {.law = Compliance{.stiffness = 1e7, .restitution = 0.5}});
          return {height(ball.marker(), "ball")};
        }}},
  };
}

}  // namespace lithe::test
