#pragma once

#include <cstdio>

#include "lithe/lithe.h"
#include "plugins/cam_follower/cam_follower.cpp"
#include "plugins/massless_rod/massless_rod.cpp"

/// What the code blocks of the catalogue find: each is the body of a function of a scene of its own, derived from this.
namespace lithe::catalogue {

struct Scene {
  /// Eigenmodes of a steel rod along x, 0.5 m, with static modes of its ends; node sets "x_min" and "x_max".
  static std::shared_ptr<const ModalBasis> rod_basis() {
    static const std::shared_ptr<const ModalBasis> basis = make_basis(
        brick_mesh(
            {.size = {0.5, 0.02, 0.02}, .divisions = {5, 1, 1}, .type = "C3D8I", .material = {2.07e11, 0.3, 7800}}),
        MeanAxisFrame{}, 4);
    return basis;
  }

  SystemGraph graph{{.gravity = {0, 0, -9.81}}};
  Ground& ground = graph.ground();
  RigidBody& link = graph.add<RigidBody>("link", {.mass = 2, .inertia = {0.01, 0.2, 0.2}, .position = {0.5, 0, 0}});
  RigidBody& slider = graph.add<RigidBody>("slider", {.mass = 1, .position = {1, 0, 0}});
  FlexibleBody& rod = graph.add<FlexibleBody>("rod", {.basis = rod_basis(), .position = {0, 1, 0}});

  /// z along the world's -y, and along its x.
  const Matrix3 hinge = rotation_about({1, 0, 0}, M_PI / 2), along = rotation_about({0, 1, 0}, M_PI / 2);
  const Marker A = ground.marker({}, hinge), B = link.marker({-0.5, 0, 0}, hinge);
  RevoluteJoint& pin = graph.add<RevoluteJoint>("pin", {A, B});
  PrismaticJoint& slide =
      graph.add<PrismaticJoint>("slide", {ground.marker({1, 0, 0}, along), slider.marker({}, along)});

  System system = assemble(graph);
  State state = system.initial_state();
  Recorder recorder{{coordinate(pin.angle(), "angle")}};
};

}  // namespace lithe::catalogue
