#include "bodies/beam/slender_body.h"

#include <gtest/gtest.h>

#include "bodies/beam/beam_model.h"
#include "bodies/rigid_body.h"
#include "engine/analysis/left_out.h"
#include "engine/observe/recorder.h"
#include "engine/run/simulation.h"
#include "integrators/radau.h"
#include "joints/fixed_joint.h"
#include "joints/forces/point_force.h"
#include "joints/revolute_joint.h"
#include "tests/support/body_checks.h"
#include "tests/support/methods.h"
#include "tests/support/motion.h"

/// One drawing at every fidelity: it owes what bodies owe, and is the Beam or the FlexibleBody drawn by hand.
namespace lithe::test::slender_body_test {
namespace {

const Matrix3 kAlongY = rotation_about({1, 0, 0}, -M_PI / 2);

Beam::Parameters curved() {
  return {.axis = BeamAxis::curved({{1, 2, 3}, rotation_exp({0.3, 0.2, -0.5})}, {0.1, 0.05, 0.2}, 2),
          .sections = {{0, BeamSection::diagonal({4e3, 3e3, 3e3, 20, 30, 40}, 1.5, {0.03, 0.02, 0.01}).damped(1e-3)}},
          .elements = 4,
          .stations = {1.2},
          .velocity = {0.3, -0.2, 0.1},
          .angular_velocity = {0.5, 0.2, -0.4}};
}

const std::vector<Fidelity> kFidelities = {
    {},
    {.modes = {0, 1, 2, 3}},
    {.modes = {0, 1, 2, 3}, .deflection = Deflection::stiffened},
    {.modes = {1, 3}, .deflection = Deflection::stiffened, .elements = 8},
    {.deflection = Deflection::exact},
    {.deflection = Deflection::exact, .elements = 7},
};

TEST(SlenderBody, OwesWhatEveryBodyOwesAtEveryFidelity) {
  for (const Fidelity& fidelity : kFidelities) {
    SCOPED_TRACE(std::to_string(fidelity.modes.size()) + " modes, " + std::to_string(fidelity.elements) + " elements");
    SystemGraph graph{{.gravity = {1, 2, -9.81}}};
    auto& body = graph.add<SlenderBody>("body", {.beam = curved()});
    const std::vector<Marker> markers = {body.marker(0), body.marker(1.2, kAlongY), body.marker(2), body.body_frame()};
    body.set_fidelity(fidelity);
    check_body(graph, body, markers,
               {.mass = 3, .deformation = 0.01, .dissipation = fidelity == Fidelity{} ? 0.0 : 1.0});
  }
}

/// On a hinge, with a load and a bob: the path of the tip for half a second.
template <class Draw>
Table path(const Draw& draw) {
  SystemGraph graph;
  const auto [start, middle, tip] = draw(graph);
  auto& bob = graph.add<RigidBody>("bob", {.mass = 0.2,
                                           .inertia = {1e-3, 1e-3, 1e-3},
                                           .position = {2, 0, 0},
                                           .velocity = {0, 0, -2},
                                           .angular_velocity = {0, 1, 0}});
  graph.add<RevoluteJoint>("pin", {graph.ground().marker({0, 0, 0}, kAlongY), start});
  graph.add<FixedJoint>("weld", {tip, bob.marker()});
  graph.add<PointForce>("push", {middle}, {.force = {0, 3, 1}});
  const System system = assemble(graph);
  Recorder recorder({position(tip, "tip")});
  Radau radau({.tolerance = {1e-6, 1e-8}});
  Simulation simulation(system, radau);
  simulation.observe(recorder, every(0.1));
  State state = system.initial_state();
  simulation.run(state, 0.5);
  return recorder.table();
}

Beam::Parameters straight(int elements) {
  return {.axis = BeamAxis::straight({0, 0, 0}, {2, 0, 0}, {0, 1, 0}),
          .sections = {{0, BeamSection::diagonal({4e5, 3e5, 3e5, 200, 300, 400}, 1.5, {0.03, 0.02, 0.01})}},
          .elements = elements,
          .stations = {1.2},
          .angular_velocity = {0, 1, 0}};
}

struct Ends {
  Marker start, middle, tip;
};

TEST(SlenderBody, IsTheBeamOrTheReducedBodyDrawnByHand) {
  const auto slender = [](const Fidelity& fidelity) {
    return path([&](SystemGraph& graph) {
      auto& body = graph.add<SlenderBody>("rod", {.beam = straight(6)});
      const Ends ends{body.marker_at_world({0, 0, 0}, kAlongY),
                      body.marker(1.2, body.parameters().beam.axis.pose(0).axes.transpose()),
                      body.marker_at_world({2, 0, 0})};
      body.set_fidelity(fidelity);
      return ends;
    });
  };
  const Table exact = path([](SystemGraph& graph) {
    auto& beam = graph.add<Beam>("rod", straight(9));
    return Ends{beam.marker_at_world({0, 0, 0}, kAlongY), beam.marker(1.2, {}, beam.axes(0).transpose()),
                beam.marker_at_world({2, 0, 0})};
  });
  EXPECT_EQ(slender({.deflection = Deflection::exact, .elements = 9}).values, exact.values);
  const Table modal = path([](SystemGraph& graph) {
    const Beam beam(straight(6));
    auto& body = graph.add<FlexibleBody>(
        "rod", {.basis = make_basis(beam, TangentFrame{{1}}, 12, {.deflection = Deflection::stiffened}),
                .angular_velocity = {0, 1, 0}});
    body.set_fidelity({.modes = {0, 1, 2}, .deflection = Deflection::stiffened});
    int middle = 0;
    while (std::abs(beam.arc(middle) - 1.2) > 1e-9) ++middle;
    return Ends{body.node(1, kAlongY), body.node(middle + 1), body.node(beam.node_count())};
  });
  EXPECT_EQ(slender({.modes = {0, 1, 2}, .deflection = Deflection::stiffened}).values, modal.values);
}

TEST(SlenderBody, SaysWhatIsWrong) {
  const auto refused = [](const SlenderBody::Parameters& parameters) { SlenderBody body(parameters); };
  EXPECT_THROW(refused({.beam = curved(), .held = 0.7}), SceneError);
  EXPECT_THROW(refused({.beam = curved(), .mode_count = 0}), SceneError);
  EXPECT_THROW(refused({.beam = curved(), .mode_count = 31}), SceneError);
  SystemGraph graph;
  auto& body = graph.add<SlenderBody>("rod", {.beam = straight(6)});
  EXPECT_THROW(body.marker(0.5), SceneError);
  EXPECT_THROW(body.marker_at_world({1, 0.1, 0}), SceneError);
  EXPECT_THROW(body.set_fidelity({.modes = {0}, .deflection = Deflection::exact}), SceneError);
  EXPECT_THROW(body.set_fidelity({.modes = {0}, .deflection = Deflection::quadratic}), SceneError);
  EXPECT_THROW(body.set_fidelity({.modes = {12}}), SceneError);
  EXPECT_THROW(body.set_fidelity({.elements = -1}), SceneError);
  // What failed has changed nothing.
  EXPECT_EQ(body.fidelity(), (Fidelity{.deflection = Deflection::exact, .elements = 6}));
  EXPECT_NE(body.beam(), nullptr);
}

}  // namespace
}  // namespace lithe::test::slender_body_test
