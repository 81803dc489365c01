#pragma once

#include <cstdio>
#include <filesystem>

#include "bodies/flexible/surface_mesh.h"
#include "engine/base/interrupt.h"
#include "engine/observe/contact_sensors.h"
#include "engine/run/mode_freezing.h"
#include "joints/contact/contact.h"
#include "lithe/lithe.h"

/// What the code blocks of the pages find: each is the body of a function of a scene of its own, derived from this.
namespace lithe::page {

/// The rod of example 02 as CalculiX writes it, put into the working folder as rod.inp, rod.sti, rod.mas, rod.dof.
inline FiniteElementModel rod_model() {
  for (const char* part : {".inp", ".sti", ".mas", ".dof"})
    std::filesystem::copy_file(std::string(LITHE_EXAMPLE_DATA) + "/pendulum/hex8i/calculix/matrices" + part,
                               std::string("rod") + part, std::filesystem::copy_options::overwrite_existing);
  return read_calculix("rod");
}

/// A flexible rod on a hinge; a hub on another one.
struct Scene {
  FiniteElementModel rod_of_file = rod_model();
  std::shared_ptr<const ModalBasis> basis = make_basis(rod_of_file, HingeFrame{rod_of_file.node_set("hinge")}, 6);
  const Matrix3 along_y = rotation_about({1, 0, 0}, -M_PI / 2);

  SystemGraph graph{{.gravity = {0, 0, -9.81}}};
  FlexibleBody& beam = graph.add<FlexibleBody>("beam", {.basis = basis, .damping = {.modal_ratios = {0.02}}});
  RigidBody& wheel = graph.add<RigidBody>("wheel", {.inertia = {0.1, 0.1, 0.1}, .position = {0.5, 1, 0}});
  RevoluteJoint& hinge = graph.add<RevoluteJoint>(
      "hinge", {graph.ground().marker({0, 0.005, 0}, along_y), beam.average(rod_of_file.node_set("hinge"), along_y)});
  RevoluteJoint& axle = graph.add<RevoluteJoint>(
      "axle", {graph.ground().marker({0, 1, 0}, along_y), wheel.marker({-0.5, 0, 0}, along_y)});
  const Marker tip = beam.average(rod_of_file.node_set("tip")), hub = wheel.marker();
  Contact::Parameters law{.law = Compliance{.stiffness = 1e6}};

  System system = assemble(graph);
  State state = system.initial_state();
  ExplicitRungeKutta::Parameters parameters;
  ExplicitRungeKutta stepper{parameters};
  Simulation simulation{system, stepper};
  Recorder recorder{{position(tip, "tip")}};
  /// A scene for studies.
  StudyScene study{.name = "pendulum", .duration = 0.5, .draw = [](SystemGraph& drawn) -> std::vector<Sensor> {
                     auto& mass = drawn.add<RigidBody>("mass", {.position = {1, 0, 0}});
                     drawn.add<DistanceJoint>("rod", {drawn.ground().marker(), mass.marker()});
                     return {position(mass.marker(), "bob")};
                   }};
  void run() {}  // of scenes whose block is a part of a class
};

}  // namespace lithe::page
