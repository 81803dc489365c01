#include "tools/endurance/scenes.h"

#include <cmath>
#include <string>

#include "bodies/flexible/flexible_body.h"
#include "bodies/flexible/reduction.h"
#include "bodies/rigid_body.h"
#include "joints/contact/contact.h"
#include "joints/coordinate_drive.h"
#include "joints/prismatic_joint.h"
#include "joints/revolute_joint.h"
#include "joints/spherical_joint.h"
#include "tools/bench/brick_mesh.h"

namespace lithe::endurance {

void add_rigid_chains(SystemGraph& graph, int bodies) {
  constexpr int kLinks = 4;
  constexpr double kLength = 20, kMass = 100;
  const Vector3 half(kLength / 2, 0, 0);
  for (int i = 0; i < bodies; i += kLinks) {
    const int chain = i / kLinks;
    Vector3 end(100.0 * (chain % 50), 100.0 * (chain / 50), 0);
    Marker last = graph.ground().marker(end);
    for (int k = 0; k < std::min(kLinks, bodies - i); ++k) {
      const Matrix3 R = rotation_about(Vector3::UnitZ(), 0.7 * chain) *
                        rotation_about(Vector3::UnitY(), 0.3 + 0.1 * k + 0.01 * (chain % 40));
      auto& rod =
          graph.add<RigidBody>("rod " + std::to_string(i + k),
                               {.mass = kMass,
                                .inertia = {kMass, kMass * kLength * kLength / 12, kMass * kLength * kLength / 12},
                                .position = end + R * half,
                                .orientation = R});
      graph.add<SphericalJoint>("ball " + std::to_string(i + k), {last, rod.marker(-half)});
      last = rod.marker(half);
      end += R * Vector3(kLength, 0, 0);
    }
  }
}

std::vector<FlexibleBody*> add_flexible_pairs(SystemGraph& graph, int bodies, int modes) {
  // Of steel: they bend at 10 rad/s, and what they fall by turns them at 6 rad/s at most. Linear modes of a rod that
  // turns faster than it bends grow without bound.
  const FiniteElementModel bar = bench::brick_model(
      {.bricks = {10, 1, 1}, .size = {10, 0.2, 0.2}, .young = 2.1e11, .poisson = 0.3, .density = 7800});
  const auto faces = [&](double x) {
    std::vector<int> ids;
    for (int i = 0; i < bar.nodes.cols(); ++i)
      if (std::abs(bar.nodes(0, i) - x) < 1e-9) ids.push_back(bar.node_ids[static_cast<std::size_t>(i)]);
    return ids;
  };
  const std::vector<int> start = faces(0), end = faces(10);
  const auto basis = make_basis(bar, TangentFrame{start}, modes);
  const Matrix3 y_axis = rotation_about(Vector3::UnitX(), -M_PI / 2);
  std::vector<FlexibleBody*> rods;
  Marker last;
  for (int i = 0; i < bodies; ++i) {
    const int pair = i / 2;
    const Vector3 pin(0, 5.0 * pair, 0);
    const Matrix3 R = rotation_about(Vector3::UnitY(), 0.2 + 0.01 * (pair % 40));
    auto& rod =
        graph.add<FlexibleBody>("rod " + std::to_string(i),
                                {.basis = basis, .position = pin + R * Vector3(i % 2 * 10.0, 0, 0), .orientation = R});
    if (i % 2 == 0) last = graph.ground().marker(pin + R * Vector3(0, 0.1, 0.1), y_axis);
    graph.add<RevoluteJoint>("pin " + std::to_string(i), {last, rod.average(start, y_axis)});
    last = rod.average(end, y_axis);
    rods.push_back(&rod);
  }
  return rods;
}

const Contact& add_shaken_boxes(SystemGraph& graph, int contacts) {
  constexpr int kCorners = 4, kInRow = 50;
  const Matrix3 along_x = rotation_about(Vector3::UnitY(), M_PI / 2);
  auto& table = graph.add<RigidBody>("table", {.mass = 1e5, .inertia = {1e5, 1e5, 1e5}});
  auto& rail = graph.add<PrismaticJoint>("rail", {graph.ground().marker({}, along_x), table.marker({}, along_x)});
  graph.add<CoordinateDrive>("shaker", {rail.displacement()}, {.motion = harmonic(0.05, 8)});
  std::vector<Collider> colliders{{table.marker(), shape::half_space()}};
  for (int i = 0; i < contacts / kCorners; ++i) {
    auto& box =
        graph.add<RigidBody>("box " + std::to_string(i), {.mass = 1,
                                                          .inertia = {1e-2, 1e-2, 1e-2},
                                                          .position = {2.0 * (i % kInRow), 2.0 * (i / kInRow), 0.1},
                                                          .orientation = rotation_about(Vector3::UnitZ(), 0.7 * i)});
    colliders.push_back({box.marker(), shape::box({0.3, 0.2, 0.2})});
  }
  return graph.add<Contact>("touch", std::move(colliders), {.law = RigidSurfaces{}, .friction = {.coefficient = 0.3}});
}

}  // namespace lithe::endurance
