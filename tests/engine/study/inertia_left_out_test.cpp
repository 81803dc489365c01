// What a body's candidate modes leave out of its deformation by inertia and gravity, beside many more of them.
#include "engine/study/inertia_left_out.h"

#include <gtest/gtest.h>

#include "bodies/flexible/elements/meshes.h"
#include "bodies/flexible/flexible_body.h"
#include "engine/observe/recorder.h"
#include "engine/run/simulation.h"
#include "integrators/automatic.h"
#include "integrators/solve.h"

namespace lithe::test::inertia_left_out_test {
namespace {

constexpr int kMany = 60;

const FiniteElementModel& plate() {
  static const FiniteElementModel model = brick_mesh({.size = {0.2, 0.1, 0.04},
                                                      .divisions = {6, 3, 2},
                                                      .type = "C3D8I",
                                                      .material = {.young = 2e6, .poisson = 0.3, .density = 1150}});
  return model;
}

/// A soft plate that spins, free or held at an end of it.
struct Spun {
  Spun(const BodyFrame& frame, int modes, const Vector3& spin) : graph({.gravity = {0, 0, 0}}) {
    body = &graph.add<FlexibleBody>("plate", {.basis = make_basis(plate(), frame, modes),
                                              .damping = {.stiffness_proportional = 1e-4},
                                              .position = {-0.1, -0.05, -0.02},
                                              .velocity = -spin.cross(Vector3(0.1, 0.05, 0.02)),
                                              .angular_velocity = spin});
  }
  SystemGraph graph;
  FlexibleBody* body;
};

/// One state of a rigid plate with this motion, as a run has it.
ModelRun at(SystemGraph& graph, FlexibleBody& body, const Vector3& omega, const Vector6& v_dot) {
  BodyModels bodies(graph);
  bodies.set(bodies.rigid());
  const System system = assemble(graph);
  ModelRun run;
  run.models = bodies.rigid();
  run.slices = system.layout().bodies();
  run.states = {system.initial_state()};
  const int v = system.layout().slice(body).v;
  run.states[0].v.segment<3>(v + 3) = omega;
  run.states[0].v_dot = VectorX::Zero(system.layout().v_count());
  run.states[0].v_dot.segment<6>(v) = v_dot;
  return run;
}

TEST(InertiaLeftOut, is_at_least_what_more_modes_add_and_not_much_more) {
  const BodyFrame frames[] = {MeanAxisFrame{}, TangentFrame{plate().node_set("x_min")}};
  const Vector3 spins[] = {{0, 20, 0}, {3, 20, -5}, {0, 0, 10}};
  for (const BodyFrame& frame : frames)
    for (const Vector3& spin : spins)
      for (const int few : {6, 16}) {
        SCOPED_TRACE(std::to_string(frame.index()) + ", " + std::to_string(few) + " modes");
        Spun poor(frame, few, {0, 0, 0}), rich(frame, kMany, {0, 0, 0});
        Vector6 v_dot = Vector6::Zero();
        v_dot.tail<3>() = Vector3(7, -4, 20);
        if (frame.index() > 0) v_dot.head<3>() = Vector3(-3, 1, 9);  // free bodies balance their inertia
        ModelRun run = at(poor.graph, *poor.body, spin, v_dot), same = at(rich.graph, *rich.body, spin, v_dot);
        BodyModels bodies(poor.graph);
        const double stated = inertia_left_out(poor.graph, bodies, run).at(0);
        // Static response of the modes that the poor body lacks.
        auto cache = rich.body->make_cache();
        const BodyState now{same.states[0].q.data(), same.states[0].v.data(), cache.get()};
        rich.body->evaluate(now, Level::velocity);
        const VectorX added = rich.body->candidate_forces(now, same.states[0].v_dot.data(), {}, Vector3::Zero())
                                  .tail(kMany - few)
                                  .cwiseQuotient(rich.body->candidate_stiffness().tail(kMany - few));
        EXPECT_GE(stated, added.norm());
        EXPECT_LE(stated, 12 * added.norm());  // a bound: as if all of it were at the lowest frequency that lacks
      }
}

TEST(InertiaLeftOut, is_in_the_statement_for_a_plate_that_turns_over) {
  // Spun about its middle axis: inertia stretches it along directions that the candidates know little of.
  constexpr double kEnd = 1.2, kInterval = 0.012;
  const Vector3 spin(0.3, 20, 0.3);
  Spun poor(MeanAxisFrame{}, 16, spin), rich(MeanAxisFrame{}, kMany, spin);
  const Solution answer = solve(poor.graph, kEnd, {want(position(poor.body->node(1), "corner"), percent(0.1))},
                                {.samples = 100, .small_deflection = true});
  const System system = assemble(rich.graph);
  State state = system.initial_state();
  Recorder recorder({position(rich.body->node(1), "corner")});
  Automatic automatic({.tolerance = {1e-8, 1e-10}});
  Simulation simulation(system, automatic);
  simulation.observe(recorder, every(kInterval));
  simulation.run(state, kEnd);
  double off = 0;
  for (int row = 0; row < answer.samples.row_count(); ++row) {
    Vector3 apart;
    for (int i = 0; i < 3; ++i) apart[i] = answer.samples.at(row, 1 + i) - recorder.table().at(row, 1 + i);
    off = std::max(off, apart.norm());
  }
  const CertifiedQuantity& corner = answer.certificate.quantities.at(0);
  EXPECT_GT(off, 1e-4 * corner.change);
  EXPECT_GE(corner.error.total(), off) << answer.certificate.text();
  EXPECT_LE(corner.error.total(), 20 * off);
}

}  // namespace
}  // namespace lithe::test::inertia_left_out_test
