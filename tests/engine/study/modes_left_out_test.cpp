// What the modes in use leave out of an equilibrium and of the stiffness about it.
#include "engine/study/modes_left_out.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "bodies/flexible/elements/meshes.h"
#include "bodies/flexible/flexible_body.h"
#include "engine/analysis/linearization.h"
#include "engine/base/log.h"
#include "joints/fixed_joint.h"
#include "joints/forces/point_force.h"

namespace lithe::test::modes_left_out_test {
namespace {

using testing::HasSubstr;

/// A thin cantilever on edge, clamped by its frame, with a dead load at its tip.
struct Cantilever {
  SystemGraph graph{{.gravity = {0, 0, 0}}};
  FlexibleBody* beam;
  Cantilever(int used, double load, Deflection deflection) {
    static const FiniteElementModel model =
        brick_mesh({.size = {1, 0.1, 0.01}, .divisions = {16, 2, 1}, .type = "C3D20", .material = {73e9, 0.3, 2700}});
    static const auto linear = make_basis(model, TangentFrame{model.node_set("x_min")}, 20);
    static const auto stiffened = make_basis(model, TangentFrame{model.node_set("x_min")}, 20,
                                             {.deflection = Deflection::stiffened, .deflection_tolerance = 2e-3});
    beam = &graph.add<FlexibleBody>(
        "beam", {.basis = deflection == Deflection::linear ? linear : stiffened, .mode_count = used});
    graph.add<FixedJoint>("clamp", {graph.ground().marker({0, 0.05, 0.005}), beam->average(model.node_set("x_min"))});
    graph.add<PointForce>("load", {beam->average(model.node_set("x_max"))}, {.force = {0, -load, 0}});
  }
  ModesLeftOut left_out(double fraction = 0.05) {
    const System system = assemble(graph);
    return find_modes_left_out(graph, system, find_equilibrium(system, system.initial_state()), fraction);
  }
};

/// By hand: the same scene drawn with all modes, and the coordinates of both.
TEST(modes_left_out, are_those_of_the_scene_drawn_with_all_modes) {
  Cantilever poor(3, 100, Deflection::linear), rich(20, 100, Deflection::linear);
  const VectorX reach = rich.beam->candidate_reach();
  const auto eta = [](Cantilever& scene, int modes) {
    const System system = assemble(scene.graph);
    const Equilibrium found = find_equilibrium(system, system.initial_state());
    VectorX all = VectorX::Zero(20);
    all.head(modes) = found.state.q.tail(modes);
    return std::pair(all, linearize(system, found.state).lowest_stiffness());
  };
  const auto [few, soft] = eta(poor, 3);
  const auto [all, whole] = eta(rich, 20);
  const ModesLeftOut found = poor.left_out();
  ASSERT_EQ(found.bodies.size(), 1u);
  EXPECT_EQ(found.bodies[0].name, "beam");
  EXPECT_EQ(found.bodies[0].used, 3);
  EXPECT_EQ(found.bodies[0].candidates, 20);
  const double missing = reach.dot((all - few).cwiseAbs()), deflection = reach.dot(all.cwiseAbs());
  ASSERT_GT(missing, 1e-3 * deflection);
  EXPECT_NEAR(found.bodies[0].missing, missing, 1e-6 * deflection);
  EXPECT_NEAR(found.bodies[0].deflection, deflection, 1e-6 * deflection);
  EXPECT_NEAR(found.lowest_stiffness / soft, 1, 1e-6);
  EXPECT_NEAR(found.richer_stiffness / whole, 1, 1e-6);
  EXPECT_EQ(poor.beam->mode_count(), 3) << "the graph has its models again";
}

/// Of a linear clamped body under its tip's load each mode answers for itself: what is missing is Σ reach F φ/ω² of
/// the others.
TEST(modes_left_out, miss_the_static_response_of_each_mode) {
  constexpr double load = 100;
  Cantilever scene(4, load, Deflection::linear);
  const VectorX reach = scene.beam->candidate_reach(), stiffness = scene.beam->candidate_stiffness();
  const ModesLeftOut found = scene.left_out();
  const VectorX eta = found.richer.state.q.tail(20);
  EXPECT_NEAR(found.bodies[0].missing, reach.tail(16).dot(eta.tail(16).cwiseAbs()), 1e-9 * found.bodies[0].deflection);
  // energy: ½ F u of all modes, Σ ½ ω² η²
  EXPECT_GT(stiffness.dot(eta.cwiseAbs2()), 0);
}

/// Near the lateral buckling load few modes are too stiff, which the lowest frequency shows and the log tells.
TEST(modes_left_out, show_in_the_stiffness_near_a_critical_load) {
  Cantilever few(6, 2600, Deflection::stiffened);
  const ModesLeftOut found = few.left_out(0.02);
  EXPECT_GT(found.lowest_stiffness, 1.05 * found.richer_stiffness);
  EXPECT_GT(found.frequency_error, 0.02);
  EXPECT_GE(found.largest(), found.frequency_error);
  EXPECT_THAT(log::last_warning(), HasSubstr("modes left out matter"));
  EXPECT_THAT(found.text(), HasSubstr("beam: 6 of 20 modes"));
}

TEST(modes_left_out, are_not_known_where_all_candidates_are_in_use) {
  Cantilever all(20, 100, Deflection::linear);
  const ModesLeftOut found = all.left_out();
  EXPECT_FALSE(found.bodies[0].known());
  EXPECT_LT(found.bodies[0].missing, 1e-9 * found.bodies[0].deflection);
  EXPECT_THAT(log::last_warning(), HasSubstr("is not known"));
  EXPECT_THAT(found.text(), HasSubstr("all 20 modes"));
}

}  // namespace
}  // namespace lithe::test::modes_left_out_test
