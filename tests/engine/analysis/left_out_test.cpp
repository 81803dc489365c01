// What modes that bodies have and do not use leave out of statics and of linearization, as the answer tells it.
#include "engine/analysis/left_out.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "bodies/flexible/elements/meshes.h"
#include "bodies/flexible/flexible_body.h"
#include "bodies/rigid_body.h"
#include "engine/analysis/equilibrium.h"
#include "engine/analysis/linearization.h"
#include "engine/base/log.h"
#include "engine/study/modes_left_out.h"
#include "joints/fixed_joint.h"
#include "joints/forces/point_force.h"

namespace lithe::test::left_out_test {
namespace {

using testing::HasSubstr;

/// A thin cantilever on edge with a dead load at its tip; clamped by its frame, or by a joint alone.
struct Cantilever {
  SystemGraph graph;
  FlexibleBody* beam;
  Cantilever(int used, double load, Deflection deflection, bool mean_axes = false, double gravity = 0)
      : graph({.gravity = {0, -gravity, 0}}) {
    static const FiniteElementModel model =
        brick_mesh({.size = {1, 0.1, 0.01}, .divisions = {16, 2, 1}, .type = "C3D20", .material = {73e9, 0.3, 2700}});
    static const auto linear = make_basis(model, TangentFrame{model.node_set("x_min")}, 20);
    static const auto mean = make_basis(model, MeanAxisFrame{}, 20);
    static const auto stiffened = make_basis(model, TangentFrame{model.node_set("x_min")}, 20,
                                             {.deflection = Deflection::stiffened, .deflection_tolerance = 2e-3});
    beam = &graph.add<FlexibleBody>("beam", {.basis = mean_axes                          ? mean
                                                      : deflection == Deflection::linear ? linear
                                                                                         : stiffened,
                                             .mode_count = used});
    graph.add<FixedJoint>("clamp", {graph.ground().marker({0, 0.05, 0.005}), beam->average(model.node_set("x_min"))});
    graph.add<PointForce>("load", {beam->average(model.node_set("x_max"))}, {.force = {0, -load, 0}});
  }
};

struct Found {
  DeflectionLeftOut estimate, truth;
  double frequency_estimate, frequency_truth;
};

Found found(Cantilever& scene) {
  const System system = assemble(scene.graph);
  const Equilibrium rest = find_equilibrium(system, system.initial_state());
  const double frequency = linearize(system, rest.state).frequency_left_out;
  const ModesLeftOut all = find_modes_left_out(scene.graph, system, rest);
  return {rest.left_out.at(0), all.bodies.at(0), frequency, all.frequency_error};
}

/// Supports that are statically determinate and a frame in the clamp: each mode answers for itself.
TEST(left_out, is_exact_for_a_linear_cantilever) {
  for (double gravity : {0.0, 9.81}) {
    Cantilever scene(3, 100, Deflection::linear, false, gravity);
    const Found f = found(scene);
    EXPECT_EQ(f.estimate.name, "beam");
    EXPECT_EQ(f.estimate.used, 3);
    EXPECT_EQ(f.estimate.candidates, 20);
    ASSERT_GT(f.truth.missing, 1e-3 * f.truth.deflection);
    EXPECT_NEAR(f.estimate.missing, f.truth.missing, 1e-6 * f.truth.missing);
    EXPECT_NEAR(f.estimate.deflection, f.truth.deflection, 1e-6 * f.truth.deflection);
  }
}

/// On mean axes the clamp's reaction loads all modes; it is known, the support being determinate.
TEST(left_out, is_exact_on_mean_axes_and_near_in_frequency) {
  for (int used : {5, 8, 12}) {
    Cantilever scene(used, 100, Deflection::linear, true);
    const Found f = found(scene);
    ASSERT_GT(f.truth.missing, 0.05 * f.truth.deflection);
    EXPECT_NEAR(f.estimate.missing, f.truth.missing, 1e-3 * f.truth.missing);
    ASSERT_GT(f.frequency_truth, 0.02);
    EXPECT_GT(f.frequency_estimate, f.frequency_truth / 2);
    EXPECT_LT(f.frequency_estimate, f.frequency_truth * 2);
  }
}

/// Near the lateral buckling load the frequency is what few modes make too high.
TEST(left_out, shows_in_the_frequency_near_a_critical_load) {
  Cantilever scene(6, 2600, Deflection::stiffened);
  const Found f = found(scene);
  ASSERT_GT(f.frequency_truth, 0.02);
  EXPECT_GT(f.frequency_estimate, f.frequency_truth / 2);
  EXPECT_LT(f.frequency_estimate, f.frequency_truth * 2);
}

TEST(left_out, is_told_in_the_log_where_it_is_large) {
  Cantilever scene(1, 100, Deflection::linear);
  const System system = assemble(scene.graph);
  const Equilibrium rest = find_equilibrium(system, system.initial_state());
  EXPECT_GT(rest.left_out.at(0).share(), kLeftOutToTell);
  EXPECT_THAT(log::last_warning(), HasSubstr("'beam' uses 1 of 20 modes"));
}

TEST(left_out, of_a_frequency_is_told_in_the_log) {
  Cantilever scene(6, 2600, Deflection::stiffened);
  const System system = assemble(scene.graph);
  linearize(system, find_equilibrium(system, system.initial_state()).state);
  EXPECT_THAT(log::last_warning(), HasSubstr("would lower the lowest frequency by some 14 %"));
}

TEST(left_out, is_not_known_with_all_modes_and_nothing_without_deformable_bodies) {
  Cantilever scene(20, 100, Deflection::linear);
  const System system = assemble(scene.graph);
  const Equilibrium rest = find_equilibrium(system, system.initial_state());
  EXPECT_FALSE(rest.left_out.at(0).known());
  EXPECT_EQ(rest.left_out[0].missing, 0);
  EXPECT_EQ(linearize(system, rest.state).frequency_left_out, 0);

  SystemGraph rigid;
  auto& block = rigid.add<RigidBody>("block", {.mass = 1, .inertia = {1, 1, 1}});
  rigid.add<FixedJoint>("clamp", {rigid.ground().marker(), block.marker()});
  const System still = assemble(rigid);
  EXPECT_TRUE(find_equilibrium(still, still.initial_state()).left_out.empty());
}

}  // namespace
}  // namespace lithe::test::left_out_test
