#include "bodies/beam/beam_mesh.h"

#include <gtest/gtest.h>

#include "engine/analysis/equilibrium.h"
#include "engine/observe/snapshot.h"
#include "joints/fixed_joint.h"
#include "joints/forces/point_force.h"
#include "tests/support/methods.h"

/// Meshes that are coarse where the strain is constant, and what error they have.
namespace lithe::test::beam_mesh_test {
namespace {

const Material kSteel{2.1e11, 0.3, 7850};
constexpr double kLength = 2, kLoad = 1;

/// A cantilever without weight, pulled down at an arc length by a force that bends it little.
struct Cantilever {
  SystemGraph graph{{.gravity = Vector3::Zero()}};
  Beam* beam;

  Cantilever(Beam::Parameters p, double at, double moment = 0) {
    p.sections = {{0, BeamSection::rectangle(0.02, 0.02, kSteel)}};
    if (p.axis.length == 0) p.axis = BeamAxis::straight({0, 0, 0}, {kLength, 0, 0});
    beam = &graph.add<Beam>("beam", std::move(p));
    graph.add<FixedJoint>("clamp", {graph.ground().marker({0, 0, 0}, beam->axes(0)), beam->marker(0)});
    graph.add<PointForce>("load", {beam->marker(at)}, {.force = Vector3(0, 0, -kLoad)});
    graph.add<PointForce>("moment", {beam->marker(beam->length())}, {.torque = Vector3(0, moment, 0)});
  }
};

struct Rest {
  double error, deflection;  // estimated; where the load is, m
  BeamMesh mesh;
};

Rest at_rest(Beam::Parameters p, double at, double wanted = 1e-3, double moment = 0) {
  Cantilever scene(std::move(p), at, moment);
  const Marker load = scene.beam->marker(at);
  const System system = assemble(scene.graph);
  Snapshot now(system, find_equilibrium(system, system.initial_state(), {.tolerance = 1e-12}).state);
  const BodyState state = now.body_state(*scene.beam);
  return {energy_error(*scene.beam, state), -now.marker(load).p[2], coarsened(*scene.beam, state, wanted)};
}

/// The estimate is the true error, 1/(4 n²), of the energy that the mesh has, 1 - 1/(4 n²) of the true one.
TEST(BeamMesh, ErrorOfACantileverIsKnown) {
  for (const int n : {4, 8, 16}) {
    const Rest rest = at_rest({.elements = n}, kLength);
    EXPECT_NEAR(rest.error * (4 * n * n - 1), 1, 1e-4) << n;
    const double exact = at_rest({.elements = 256}, kLength).deflection;
    EXPECT_NEAR((1 - rest.deflection / exact) * 4 * n * n, 1, 0.01) << n;
  }
}

/// Behind the load the beam is straight: one element; before it as many as the error asks, and it is met.
TEST(BeamMesh, IsCoarseWhereTheBeamIsStraight) {
  constexpr double kPlace = kLength / 4;
  const Rest fine = at_rest({.elements = 1024, .stations = {kPlace}}, kPlace);  // its own error 4e-6
  int last = 1000;
  for (const double wanted : {1e-2, 1e-3, 1e-4}) {
    const BeamMesh mesh = at_rest({.elements = 128, .stations = {kPlace}}, kPlace, wanted).mesh;
    EXPECT_LE(mesh.error, wanted);
    EXPECT_EQ(mesh.stations.back(), kPlace);  // nothing behind it
    EXPECT_NEAR(mesh.element_count(), 1 + std::sqrt(1 / (4 * wanted)), 2);
    const Rest coarse = at_rest({.elements = 1, .stations = mesh.stations}, kPlace);
    EXPECT_LE(std::abs(1 - coarse.deflection / fine.deflection), wanted);
    EXPECT_GT(std::abs(1 - coarse.deflection / fine.deflection), 0.2 * wanted);  // not finer than asked
    // Equal elements all along need four times as many.
    EXPECT_NEAR(at_rest({.elements = 4 * (mesh.element_count() - 1), .stations = {kPlace}}, kPlace).error / mesh.error,
                1, 0.2);
    last = mesh.element_count();
  }
  EXPECT_GE(last, 50);
}

/// Constant curvature is exact at any length: no element turns by more than a radian.
TEST(BeamMesh, KeepsArcsInFewElements) {
  const BeamSection section = BeamSection::rectangle(0.02, 0.02, kSteel);
  SystemGraph graph{{.gravity = Vector3::Zero()}};
  Beam& beam = graph.add<Beam>(
      "beam", {.axis = BeamAxis::straight({0, 0, 0}, {kLength, 0, 0}), .sections = {{0, section}}, .elements = 32});
  graph.add<FixedJoint>("clamp", {graph.ground().marker({0, 0, 0}, beam.axes(0)), beam.marker(0)});
  const double turn = 3;  // rad
  const Vector3 moment = beam.axes(0) * Vector3(0, section.stiffness(4, 4) * turn / kLength, 0);
  graph.add<PointForce>("moment", {beam.marker(kLength)}, {.torque = moment});
  const System system = assemble(graph);
  Snapshot now(system, find_equilibrium(system, system.initial_state()).state);
  const BodyState state = now.body_state(beam);
  expect_below("estimate under a moment", energy_error(beam, state), 1e-8);
  const BeamMesh mesh = coarsened(beam, state, 1e-3);
  EXPECT_GE(mesh.element_count(), 3);
  EXPECT_LE(mesh.element_count(), 5);
  EXPECT_THROW(coarsened(beam, state, 0), SceneError);
  EXPECT_THROW(coarsened(beam, state, std::nan("")), SceneError);
}

}  // namespace
}  // namespace lithe::test::beam_mesh_test
