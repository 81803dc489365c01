// solve() of beams: it takes modes where they do and the exact beam where they do not, with as many elements as it
// takes.
#include <gtest/gtest.h>

#include <cmath>

#include "bodies/beam/slender_body.h"
#include "engine/observe/recorder.h"
#include "engine/run/simulation.h"
#include "integrators/radau.h"
#include "integrators/solve.h"
#include "joints/fixed_joint.h"
#include "joints/revolute_joint.h"
#include "tests/support/methods.h"
#include "tests/support/motion.h"

namespace lithe::test::solve_slender_test {
namespace {

/// A rod of 1 m and 1 kg, released level, on a hinge or clamped to the ground.
struct Rod {
  Rod(double bending_stiffness, bool clamped, int elements) {
    const double EA = 1e4 * bending_stiffness;
    const BeamSection section = BeamSection::diagonal(
        {EA, EA / 3, EA / 3, bending_stiffness, bending_stiffness, bending_stiffness}, 1, {2e-4, 1e-4, 1e-4});
    body = &graph.add<SlenderBody>("rod", {.beam = {.axis = BeamAxis::straight({0, 0, 0}, {1, 0, 0}, {0, 1, 0}),
                                                    .sections = {{0, section.damped(1e-3)}},
                                                    .elements = elements}});
    const Matrix3 along_y = rotation_about({1, 0, 0}, -M_PI / 2);
    if (clamped)
      graph.add<FixedJoint>(
          "clamp", {graph.ground().marker({0, 0, 0}, body->parameters().beam.axis.pose(0).axes), body->marker(0)});
    else
      graph.add<RevoluteJoint>("pin",
                               {graph.ground().marker({0, 0, 0}, along_y), body->marker_at_world({0, 0, 0}, along_y)});
    tip = body->marker(1);
  }
  SystemGraph graph;
  SlenderBody* body;
  Marker tip;
};

constexpr double kDuration = 0.8;
constexpr int kSamples = 50;

/// With elements so fine that what is left is known by the next finer one.
Table reference(double bending_stiffness, bool clamped) {
  Table samples[2];
  for (int i : {0, 1}) {
    Rod rod(bending_stiffness, clamped, 24 << i);
    const System system = assemble(rod.graph);
    Radau radau({.tolerance = {1e-7, 1e-9}});
    Recorder tip({position(rod.tip, "tip")});
    Simulation simulation(system, radau);
    simulation.observe(tip, every(kDuration / kSamples));
    State state = system.initial_state();
    simulation.run(state, kDuration);
    samples[i] = tip.table();
  }
  Table out = samples[1];
  for (std::size_t k = 0; k < out.values.size(); ++k)
    out.values[k] += (samples[1].values[k] - samples[0].values[k]) / 3;
  return out;
}

double apart(const Table& a, const Table& b) {
  EXPECT_EQ(a.row_count(), b.row_count());
  double most = 0;
  for (int row = 0; row < a.row_count(); ++row)
    most = std::max(most,
                    std::hypot(a.at(row, 1) - b.at(row, 1), a.at(row, 2) - b.at(row, 2), a.at(row, 3) - b.at(row, 3)));
  return most;
}

struct Found {
  Fidelity fidelity;
  double truth, stated;
};

Found ask(double bending_stiffness, bool clamped, double wanted, const Table& truth, int elements = 8) {
  Rod rod(bending_stiffness, clamped, elements);
  const Solution solution = solve(rod.graph, kDuration, {want(position(rod.tip, "tip"), percent(wanted))},
                                  {.samples = kSamples, .scene = "rod"});
  const Certificate& c = solution.certificate;
  EXPECT_TRUE(c.met()) << c.text();
  const double error = apart(solution.samples, truth), stated = c.quantities[0].error.total();
  EXPECT_LE(error, stated) << c.text();
  EXPECT_EQ(c.bodies.at(0).fidelity, rod.body->fidelity());
  if (std::getenv("LITHE_SHOW"))
    std::printf("EI %g, %g %%: true %.3g, stated %.3g\n%s\n", bending_stiffness, wanted, error, stated,
                c.text().c_str());
  return {rod.body->fidelity(), error, stated};
}

TEST(SolveSlender, AStiffRodMayBeRigid) {
  const Found found = ask(2e4, false, 1, reference(2e4, false));
  EXPECT_EQ(found.fidelity, Fidelity{});
}

TEST(SolveSlender, ARodThatBendsALittleTakesModes) {
  const Table truth = reference(100, true);
  for (const double wanted : {10.0, 2.0}) {
    const Found found = ask(100, true, wanted, truth);
    EXPECT_FALSE(found.fidelity.modes.empty());
  }
}

TEST(SolveSlender, ARodThatBendsMuchIsExactWithMoreElementsForMore) {
  const Table truth = reference(3, true);
  int elements = 0;
  for (const double wanted : {10.0, 1.0, 0.2}) {
    const Found found = ask(3, true, wanted, truth);
    EXPECT_EQ(found.fidelity.deflection, Deflection::exact);
    EXPECT_GE(found.fidelity.elements, elements);
    elements = found.fidelity.elements;
  }
  EXPECT_GT(elements, 8);
}

TEST(SolveSlender, ASoftPendulumIsExact) {
  const Found found = ask(2, false, 2, reference(2, false));
  EXPECT_EQ(found.fidelity.deflection, Deflection::exact);
}

}  // namespace
}  // namespace lithe::test::solve_slender_test
