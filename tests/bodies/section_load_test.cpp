#include "bodies/beam/section_load.h"

#include "engine/analysis/equilibrium.h"
#include "engine/run/simulation.h"
#include "joints/fixed_joint.h"
#include "joints/forces/point_force.h"
#include "joints/revolute_joint.h"
#include "tests/support/message_of.h"
#include "tests/support/methods.h"

namespace lithe::test::section_load_test {
namespace {

constexpr double kMass = 2;  // kg/m
const BeamSection kSection = BeamSection::diagonal({1e8, 4e7, 4e7, 1e4, 1e4, 1e4}, kMass, {2e-3, 1e-3, 1e-3});

struct BeamCantilever {
  SystemGraph graph;
  Beam& beam;
  BeamCantilever(const Vector3& gravity, int elements, std::vector<double> stations = {})
      : graph({.gravity = gravity}),
        beam(graph.add<Beam>("beam", {.axis = BeamAxis::straight({0, 0, 0}, {2, 0, 0}, {0, 1, 0}),
                                      .sections = {{0, kSection}},
                                      .elements = elements,
                                      .stations = std::move(stations)})) {
    graph.add<FixedJoint>("clamp", {graph.ground().marker(), beam.marker(0)});
  }
};

TEST(SectionLoad, IsWhatStaticsSayOfLoadsAtStations) {
  // Elements of any number between the stations: one has its own arm.
  for (const int elements : {2, 3, 10}) {
    BeamCantilever scene({0, 0, 0}, elements, {1});
    const Vector3 F(3, 0.02, -0.01), G(1, -0.01, 0.02);
    scene.graph.add<PointForce>("end", {scene.beam.marker(2)}, {.force = F});
    scene.graph.add<PointForce>("middle", {scene.beam.marker(1)}, {.force = G});
    const System system = assemble(scene.graph);
    Snapshot now(system, find_equilibrium(system, system.initial_state()).state);
    for (const double s : {0.0, 0.3, 0.9999, 1.0, 1.7, 2.0}) {
      const Vector3 p(s, 0, 0), force = s < 1 ? Vector3(F + G) : F;
      Vector3 moment = (Vector3(2, 0, 0) - p).cross(F);
      if (s < 1) moment += (Vector3(1, 0, 0) - p).cross(G);
      const Vector6 found = section_load(scene.beam, now.body_state(scene.beam), s);
      // The beam bends by 3e-6 of its length under loads of 0.01 N.
      expect_below("force at " + std::to_string(s), (found.head<3>() - force).norm(), 3e-5);
      expect_below("moment at " + std::to_string(s), (found.tail<3>() - moment).norm(), 3e-5);
    }
  }
}

TEST(SectionLoad, CarriesTheWeightBeyond) {
  const Vector3 g(5, 0, -9.81);
  BeamCantilever scene(g, 20);
  const System system = assemble(scene.graph);
  Snapshot now(system, find_equilibrium(system, system.initial_state()).state);
  for (const double s : {0.0, 0.42, 1.0, 1.5}) {
    const Vector6 found = section_load(scene.beam, now.body_state(scene.beam), s);
    const double rest = 2 - s, scale = kMass * 9.81 * 2;
    expect_below("N", std::abs(found[0] - kMass * g[0] * rest) / scale, 5e-3);
    expect_below("V", std::abs(found[2] - kMass * g[2] * rest) / scale, 1e-3);
    expect_below("M", std::abs(found[4] + kMass * g[2] * rest * rest / 2) / scale, 4e-3);
  }
}

TEST(SectionLoad, OfASpinningBeamIsTheCentrifugalForce) {
  SystemGraph graph{{.gravity = Vector3::Zero()}};
  auto& beam = graph.add<Beam>("beam", {.axis = BeamAxis::straight({0, 0, 0}, {2, 0, 0}, {0, 1, 0}),
                                        .sections = {{0, kSection.damped(1e-4)}},
                                        .elements = 20,
                                        .angular_velocity = {0, 0, 20}});
  const Marker root = beam.marker(0);
  graph.add<RevoluteJoint>("hub", {graph.ground().marker(), root});
  const System system = assemble(graph);
  State state = system.initial_state();
  const Method method = index3(1e-4);
  Simulation(system, *method).run(state, 0.02);  // the waves of the start are damped by then
  Snapshot now(system, state);
  const double spin = now.marker(root).w[2];
  EXPECT_NEAR(spin, 20, 0.1);
  for (const double s : {0.0, 0.4, 1.0, 1.73}) {
    const double wanted = 0.5 * kMass * spin * spin * (4 - s * s);
    expect_below("N at " + std::to_string(s),
                 std::abs(section_load(beam, s).value(now) - wanted) / (2 * kMass * spin * spin), 2e-3);
  }
}

/// A slender body with all modes of its mesh is that mesh: cantilever with loads at its end and middle, against statics
/// and against the exact beam, which is the same sensor after set_fidelity().
TEST(SectionLoad, OfASlenderBodyIsThatOfItsModes) {
  SystemGraph graph{{.gravity = {0, 0, 0}}};
  constexpr int kElements = 6;
  auto& body = graph.add<SlenderBody>("beam", {.beam = {.axis = BeamAxis::straight({0, 0, 0}, {2, 0, 0}, {0, 1, 0}),
                                                        .sections = {{0, kSection}},
                                                        .elements = kElements,
                                                        .stations = {1}},
                                               .mode_count = 6 * kElements});
  const Marker root = body.marker(0), middle = body.marker(1), end = body.marker(2);
  graph.add<FixedJoint>("clamp", {graph.ground().marker(), root});
  const Vector3 F(3, 0.02, -0.01), G(1, -0.01, 0.02), T(0.03, 0, 0);
  graph.add<PointForce>("end", {end}, {.force = F, .torque = T});
  graph.add<PointForce>("middle", {middle}, {.force = G});
  std::vector<Sensor> loads;
  for (const double s : {0.1, 0.5, 0.9, 1.3, 1.9}) loads.push_back(section_load(body, s));
  std::vector<int> all;
  for (int k = 0; k < 6 * kElements; ++k) all.push_back(k);
  for (const Fidelity& fidelity : {Fidelity{.deflection = Deflection::exact}, Fidelity{.modes = all},
                                   Fidelity{.modes = all, .deflection = Deflection::stiffened}}) {
    body.set_fidelity(fidelity);
    const System system = assemble(graph);
    Snapshot now(system, find_equilibrium(system, system.initial_state()).state);
    std::size_t k = 0;
    for (const double s : {0.1, 0.5, 0.9, 1.3, 1.9}) {
      const Vector3 p(s, 0, 0), force = s < 1 ? Vector3(F + G) : F;
      Vector3 moment = (Vector3(2, 0, 0) - p).cross(F) + T;
      if (s < 1) moment += (Vector3(1, 0, 0) - p).cross(G);
      Vector6 found;
      for (int i = 0; i < 6; ++i) found[i] = loads[k].value(now, i);
      ++k;
      EXPECT_LT((found.head<3>() - force).norm(), 5e-5) << fidelity.modes.size() << " modes, " << s;
      EXPECT_LT((found.tail<3>() - moment).norm(), 5e-5) << fidelity.modes.size() << " modes, " << s;
    }
  }
  body.set_fidelity({});
  const System rigid = assemble(graph);
  Snapshot now(rigid, rigid.initial_state());
  EXPECT_EQ(loads[0].value(now, 4), 0);
  expect_says(message_of<SceneError>([&] { section_load(body, 2.5); }), {"'beam'", "2.5", "0 to 2"});
}

TEST(SectionLoad, SaysWhereTheBeamEnds) {
  BeamCantilever scene({0, 0, 0}, 4);
  expect_says(message_of<SceneError>([&] { section_load(scene.beam, 2.5); }), {"'beam'", "2.5", "0 to 2"});
  EXPECT_EQ(section_load(scene.beam, 1, "mid").columns().front(), "mid_n_1");
}

}  // namespace
}  // namespace lithe::test::section_load_test
