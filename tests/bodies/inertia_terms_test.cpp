// Which inertia terms matter, and what a body does without the others.
#include "bodies/flexible/inertia_terms.h"

#include <gtest/gtest.h>

#include "bodies/flexible/flexible_body.h"
#include "engine/assembly/evaluated.h"
#include "engine/observe/recorder.h"
#include "engine/run/simulation.h"
#include "integrators/explicit_runge_kutta.h"
#include "joints/revolute_joint.h"
#include "tests/bodies/fe_models.h"

namespace lithe::test::inertia_terms_test {
namespace {

using enum InertiaGroup;
const std::vector<std::vector<InertiaGroup>> kSubsets{{C1}, {J1}, {J2}, {Ct, C0}, {Ct, C0, C1, J1, J2}};

std::string names(const std::vector<InertiaGroup>& groups) {
  std::string all;
  for (const InertiaGroup group : groups) all += to_string(group) + " ";
  return all;
}

std::shared_ptr<const ModalBasis> hinged(int modes, Deflection deflection = Deflection::linear) {
  const FiniteElementModel model = pendulum_from_calculix("hex8i");
  return make_basis(model, HingeFrame{model.node_set("hinge")}, modes, {.deflection = deflection});
}

/// The pendulum for half a second: its tip every millisecond, world axes.
struct Swing {
  Table tip;
  MotionBounds bounds;
  explicit Swing(const std::shared_ptr<const ModalBasis>& basis) {
    SystemGraph graph{{.gravity = {0, 0, -9.81}}};
    auto& rod = graph.add<FlexibleBody>("rod", {.basis = basis});
    const Matrix3 along_y = rotation_about({1, 0, 0}, -M_PI / 2);
    graph.add<RevoluteJoint>(
        "hinge", {graph.ground().marker({0, 0.005, 0}, along_y), rod.average(basis->node_set("hinge"), along_y)});
    const System system = assemble(graph);
    State state = system.initial_state();
    ExplicitRungeKutta integrator({.tolerance = {.relative = 1e-7, .absolute = 1e-9}});
    Recorder recorder({position(rod.node(basis->node_set("tip").front()), "tip")});
    MotionWatch watch(rod);
    Simulation simulation(system, integrator);
    simulation.observe(recorder, every(1e-3));
    simulation.observe(watch, every_step());
    simulation.run(state, 0.5);
    tip = recorder.table();
    bounds = watch.bounds();
  }
};
/// Largest distance of two motions, m.
double distance(const Table& a, const Table& b) {
  double most = 0;
  for (int i = 0; i < a.row_count(); ++i) {
    const auto at = [i](const Table& t) { return Vector3(t.at(i, 1), t.at(i, 2), t.at(i, 3)); };
    most = std::max(most, (at(a) - at(b)).norm());
  }
  return most;
}

TEST(InertiaTerms, what_is_said_of_a_group_is_no_less_than_what_leaving_it_out_does_to_the_tip) {
  const auto basis = hinged(4);
  const Swing whole(basis);
  const InertiaEffects effects = inertia_effects(*basis, whole.bounds);
  for (const auto& groups : kSubsets) {
    double stated = 0;
    for (const InertiaEffect& effect : effects.groups)
      if (std::ranges::count(groups, effect.group) > 0) stated += effect.largest();
    const Swing part(with_inertia(*basis, without(basis->integrals, groups)));
    const double error = distance(whole.tip, part.tip) / 0.2;  // of the way that the tip swings
    EXPECT_LT(error, stated) << names(groups);
  }
}

TEST(InertiaTerms, a_bound_leaves_out_the_smallest_and_says_by_how_much) {
  const auto basis = hinged(4);
  const Swing whole(basis);
  for (double bound : {0.0, 0.02, 0.1}) {
    const ReducedInertia reduced = reduced_to(bound, *basis, whole.bounds);
    EXPECT_LE(reduced.error, bound);
    EXPECT_EQ(std::ranges::count(reduced.left_out, J2), bound > 0);
    EXPECT_LE(distance(whole.tip, Swing(reduced.basis).tip), 0.2 * reduced.error);
  }
}

TEST(InertiaTerms, any_of_them_left_out_a_free_body_keeps_its_energy_and_momenta) {
  const FiniteElementModel model = pendulum_from_calculix("hex8i");
  const auto& n = model.node_set("frameA");
  const auto mean = make_basis(model, MeanAxisFrame{}, 5),
             three = make_basis(model, ThreeNodeFrame{n.at(0), n.at(1), n.at(2)}, 5);
  // In a frame off the centre of mass the groups balance each other: without one alone M is soon indefinite.
  const auto all = kSubsets.back();
  for (const auto& [basis, groups] :
       {std::pair(mean, kSubsets[0]), std::pair(mean, kSubsets[1]), std::pair(mean, kSubsets[2]),
        std::pair(three, kSubsets[2]), std::pair(three, all)}) {
    SystemGraph graph{{.gravity = {0, 0, 0}}};
    FlexibleBody::Parameters parameters{.basis = with_inertia(*basis, without(basis->integrals, groups))};
    parameters.velocity = {0.3, -0.2, 0.1};
    parameters.angular_velocity = {8, 5, -6};
    parameters.modal_coordinates = VectorX::Zero(5);
    parameters.modal_coordinates << 3e-4, -2e-4, 1e-4, 5e-5, 0;
    auto& body = graph.add<FlexibleBody>("rod", parameters);
    const System system = assemble(graph);
    Evaluator equations(system);
    State state = system.initial_state();
    ExplicitRungeKutta integrator(
        {.method = ExplicitRungeKutta::Method::dormand_prince8, .tolerance = {.relative = 1e-11, .absolute = 1e-12}});
    integrator.start(equations, state);
    const auto observed = [&] {
      equations.evaluate(state.time, state.q, state.v, Level::velocity);
      const BodyState s = body_state(equations, body);
      return std::tuple(equations.energy().total(), body.linear_momentum(s), body.angular_momentum(s));
    };
    const auto [e0, p0, l0] = observed();
    while (state.time < 0.5) {
      const StepResult result = integrator.step(equations, state, 0.5);
      ASSERT_TRUE(result.ok()) << result.why << names(groups);
    }
    const auto [e, p, l] = observed();
    EXPECT_LT(std::abs(e / e0 - 1), 1e-9) << names(groups);
    EXPECT_LT((p - p0).norm(), 1e-9 * p0.norm()) << names(groups);
    EXPECT_LT((l - l0).norm(), 1e-9 * l0.norm()) << names(groups);
  }
}

TEST(InertiaTerms, a_displacement_and_a_spin_bound_a_motion_before_it_is_run) {
  const auto basis = hinged(4);
  MotionBounds bounds = motion_of_displacement(*basis, 0.01);
  Vector3 largest = Vector3::Zero();
  for (int i = 0; i < basis->nodes.cols(); ++i)
    largest = largest.cwiseMax((basis->node_modes(i).col(0) * bounds.eta[0]).cwiseAbs());
  EXPECT_NEAR(largest.norm(), 0.01, 2e-3);
  EXPECT_GT(bounds.eta[0], bounds.eta[3]);
  const InertiaEffects still = inertia_effects(*basis, bounds);
  bounds.spin = {0, 0, 15};  // the first mode bends about z
  const InertiaEffects spun = inertia_effects(*basis, bounds);
  EXPECT_EQ(still.groups[3].deflection, 0);
  EXPECT_EQ(still.groups[4].deflection, 0);
  EXPECT_GT(spun.groups[3].deflection, 0);
  // Softening against stiffness: (spin / 2 pi f)² in the first mode, the softest, which has a fourth of the energy.
  const double ratio = std::pow(15 / (2 * M_PI * basis->frequencies[0]), 2);
  EXPECT_GT(spun.groups[4].deflection, 0.45 * ratio);
  EXPECT_LT(spun.groups[4].deflection, 0.55 * ratio);
}

TEST(InertiaTerms, those_that_hold_the_mass_matrix_together_are_not_left_out) {
  const FiniteElementModel model = pendulum_from_calculix("hex8i");
  const auto clamped = make_basis(model, TangentFrame{model.node_set("root_face")}, 40);
  expect_error<SceneError>([&] { without(clamped->integrals, {InertiaGroup::C0}); }, {"positive definite"});
  expect_error<SceneError>([&] { with_inertia(*hinged(3), clamped->integrals); }, {"40 modes", "has 3"});
  expect_error<SceneError>([&] { inertia_effects(*hinged(3, Deflection::stiffened), {}); }, {"quadratic deflection"});
}

}  // namespace
}  // namespace lithe::test::inertia_terms_test
