// Modes that stand still while they are quiet: what freezing keeps, what it takes, and that it lets go in time.
#include "engine/run/mode_freezing.h"
#include "engine/study/certificate.h"

#include <gtest/gtest.h>

#include <map>

#include "bodies/flexible/elements/meshes.h"
#include "bodies/flexible/flexible_body.h"
#include "bodies/rigid_body.h"
#include "engine/assembly/evaluated.h"
#include "engine/motion/make_integrator.h"
#include "engine/motion/projection.h"
#include "engine/observe/sensors.h"
#include "engine/run/simulation.h"
#include "integrators/explicit_runge_kutta.h"
#include "integrators/generalized_alpha.h"
#include "integrators/radau.h"
#include "joints/fixed_joint.h"
#include "joints/forces/point_force.h"
#include "joints/forces/user_force.h"
#include "joints/revolute_joint.h"
#include "joints/spherical_joint.h"
#include "tests/support/scenes.h"

namespace lithe::test::mode_freezing_test {
namespace {

constexpr int kModes = 6;
const Matrix3 kAcross = rotation_exp({M_PI / 2, 0, 0});  // a hinge along y
const Vector3 kGravity(0, 0, -9.81);

/// A steel bar of half a metre along x: 210 Hz to some kHz free, 34 Hz and up clamped. Of a square one the modes come
/// in pairs of one frequency, and round-off chose the directions in which they bend.
constexpr double kWidth = 0.012, kHeight = 0.01;
FiniteElementModel bar() {
  return brick_mesh(
      {.size = {0.5, kWidth, kHeight}, .divisions = {8, 1, 1}, .type = "C3D20", .material = {2.07e11, 0.3, 7800}});
}

std::shared_ptr<const ModalBasis> basis(Deflection deflection, bool clamped) {
  static std::map<std::pair<Deflection, bool>, std::shared_ptr<const ModalBasis>> made;
  auto& basis = made[{deflection, clamped}];
  if (basis) return basis;
  const FiniteElementModel model = bar();
  const BodyFrame frame = clamped ? BodyFrame{TangentFrame{model.node_set("x_min")}} : BodyFrame{MeanAxisFrame{}};
  return basis = make_basis(model, frame, kModes, {.deflection = deflection});
}

FlexibleBody::Parameters drawn(Deflection deflection, bool clamped, double damping = 0) {
  FlexibleBody::Parameters p{.basis = basis(deflection, clamped), .position = {0, -kWidth / 2, -kHeight / 2}};
  if (damping > 0) p.damping.modal_ratios = {damping};
  return p;
}

/// η of modes that each move their largest node by a displacement.
VectorX displaced(const FlexibleBody& body, const std::vector<double>& displacements) {
  VectorX eta = VectorX::Zero(kModes);
  const VectorX reach = body.candidate_reach();
  for (size_t k = 0; k < displacements.size(); ++k)
    eta[static_cast<int>(k)] = displacements[k] / reach[static_cast<int>(k)];
  return eta;
}

std::unique_ptr<Integrator> explicit_method(double relative = 1e-8, double absolute = 1e-10) {
  return std::make_unique<ExplicitRungeKutta>(
      ExplicitRungeKutta::Parameters{.tolerance = {.relative = relative, .absolute = absolute}});
}

/// Time alone moves: what changes is what ModeFreezing does.
class StoppedClock final : public Integrator {
 public:
  std::string name() const override { return "stopped clock"; }
  const IntegratorStatistics& statistics() const override { return statistics_; }

 protected:
  void prepare(EquationsOfMotion& equations, State& state) override {
    state.v_dot.resize(state.v.size());
    state.lambda.setZero(equations.layout().row_count());
    Projector(equations).accelerations(state.time, state.q, state.v, state.v_dot, state.lambda);
  }
  StepResult advance(EquationsOfMotion& equations, State& state, double stop) override {
    state.time = std::min(stop, state.time + 1e-3);
    prepare(equations, state);
    ++statistics_.steps;
    return {};
  }
  IntegratorStatistics statistics_;
};

struct Momentum {
  Vector3 linear = Vector3::Zero(), angular = Vector3::Zero();
};
Momentum momentum(Scene& scene) {
  Momentum sum;
  scene.equations.evaluate(scene.state.time, scene.state.q, scene.state.v, Level::velocity);
  for (const auto& entry : scene.graph.bodies())
    if (const auto* body = dynamic_cast<const FlexibleBody*>(entry.body)) {
      sum.linear += body->linear_momentum(body_state(scene.equations, *body));
      sum.angular += body->angular_momentum(body_state(scene.equations, *body));
    }
  return sum;
}

class Freezing : public testing::TestWithParam<Deflection> {};

TEST_P(Freezing, keeps_the_momenta_and_joints_of_two_bars_and_counts_the_energy_it_takes) {
  std::vector<FlexibleBody*> bars;
  Scene scene(Vector3::Zero(), [&](SystemGraph& graph) {
    const auto& ends = basis(Deflection::linear, true)->node_sets;
    for (int i = 0; i < 2; ++i) {
      FlexibleBody::Parameters p = drawn(GetParam(), true);
      p.position.x() = 0.5 * i;
      p.velocity = {2, -1, 3};
      p.angular_velocity = {0, 2, 0};
      if (i > 0) p.velocity.z() -= 2 * 0.5;
      bars.push_back(&graph.add<FlexibleBody>("bar " + std::to_string(i), p));
    }
    graph.add<RevoluteJoint>(
        "hinge", {bars[0]->average(ends.at("x_max"), kAcross), bars[1]->average(ends.at("x_min"), kAcross)});
  });
  // Fast vibration, and a bent shape that it freezes in.
  const System& system = scene.system;
  for (FlexibleBody* bar : bars) {
    const auto& slice = system.layout().slice(*bar);
    scene.state.q.segment(slice.q + 7, kModes) = displaced(*bar, {2e-3, -1e-3, 3e-4, 1e-4});
    scene.state.v.segment(slice.v + 6, kModes) =
        displaced(*bar, {1e-3, 2e-3, -1e-3, 1e-3, 5e-4, 2e-4}).cwiseProduct(bar->candidate_stiffness().cwiseSqrt());
  }
  Projector projector(scene.equations);
  ASSERT_TRUE(projector.position(0, scene.state.q, 1e-14, 20).converged);
  projector.velocity(0, scene.state.q, scene.state.v);

  const Momentum before = momentum(scene);
  const double energy = scene.energy();
  const VectorX v = scene.state.v;
  ModeFreezing freezing(std::make_unique<StoppedClock>(), {.displacement = 1});
  scene.run(freezing, 0.2);
  EXPECT_EQ(freezing.frozen_count(), 2 * kModes);
  const Momentum after = momentum(scene);
  EXPECT_LT((after.linear - before.linear).norm(), 1e-12 * before.linear.norm());
  EXPECT_LT((after.angular - before.angular).norm(), 1e-12 * before.angular.norm());
  EXPECT_LT(scene.violation(Level::velocity), 1e-12);
  EXPECT_GT((scene.state.v.head<6>() - v.head<6>()).norm(), 1e-2);  // the frames took the momentum over
  for (FlexibleBody* bar : bars)
    EXPECT_TRUE(scene.state.v.segment(system.layout().slice(*bar).v + 6, kModes).isZero(0));
  EXPECT_GT(freezing.energy_taken(), 1e-3 * energy);
  EXPECT_NEAR(scene.energy() + freezing.energy_taken(), energy, 1e-12 * energy);
  // Impulses that do no work on what is left: what goes is the energy of the difference.
  const VectorX gone = v - scene.state.v, zero = VectorX::Zero(v.size());
  VectorX Mv(v.size()), f(v.size());
  const VectorX rows = VectorX::Zero(system.layout().row_count());
  scene.equations.parts().held->hold({});
  scene.equations.evaluate(0, scene.state.q, zero, Level::velocity);
  scene.equations.residual(gone, rows, Mv);
  scene.equations.residual(zero, rows, f);
  EXPECT_NEAR(freezing.energy_taken(), 0.5 * gone.dot(Mv - f), 1e-9 * energy);
}

TEST_P(Freezing, of_all_modes_leaves_the_rigid_body_with_every_kind_of_integrator) {
  const auto draw = [&](int modes) {
    return [=](SystemGraph& graph) {
      FlexibleBody::Parameters p = drawn(GetParam(), false);
      p.mode_count = modes;
      p.angular_velocity = {0, 2, 0};
      auto& bar = graph.add<FlexibleBody>("bar", p);
      graph.add<RevoluteJoint>(
          "pin", {graph.ground().marker({}, kAcross), bar.average(bar.basis().node_set("x_min"), kAcross)});
      graph.add<UserForce>("push", {bar.average(bar.basis().node_set("x_max"))}, {[](double t, const MarkerView&) {
                             return force({t, 1, 2});
                           }});
    };
  };
  const auto motion = [&](Integrator& integrator, int modes) {
    Scene scene(kGravity, draw(modes));
    std::vector<int> held;
    for (int k = 0; k < modes; ++k) held.push_back(6 + k);
    EXPECT_TRUE(scene.equations.parts().held->hold(held));
    if (modes > 0) scene.state.v.tail(modes).setZero();
    scene.state.q.tail(modes).setZero();
    scene.run(integrator, 0.2);
    EXPECT_LT(scene.violation(Level::position), 1e-9);
    EXPECT_TRUE(scene.state.q.tail(modes).isZero(0));
    return VectorX(scene.state.q.head<7>());
  };
  const auto compare = [&](auto&& make) {
    auto rigid = make(), frozen = make();
    EXPECT_LT((motion(*rigid, 0) - motion(*frozen, kModes)).norm(), 1e-10) << rigid->name();
    EXPECT_EQ(rigid->statistics().steps, frozen->statistics().steps);
  };
  compare([] { return std::make_unique<ExplicitRungeKutta>(ExplicitRungeKutta::Parameters{.step = 1e-3}); });
  compare([] { return std::make_unique<GeneralizedAlpha>(GeneralizedAlpha::Parameters{.step = 1e-3}); });
  compare([] { return std::make_unique<Radau>(Radau::Parameters{.step = 5e-3}); });
}

TEST_P(Freezing, keeps_energy_and_its_account_in_flight_with_a_shape_that_is_bent) {
  // The first modes swing on; the stiff ones freeze as they pass by, bent.
  Scene scene(Vector3::Zero(), [&](SystemGraph& graph) {
    FlexibleBody::Parameters p = drawn(GetParam(), false);
    p.velocity = {0.3, 0.2, 0};
    p.angular_velocity = {20, 5, -8};
    graph.add<FlexibleBody>("bar", p);
  });
  const auto& bar = static_cast<const FlexibleBody&>(*scene.graph.bodies().back().body);
  scene.state.q.tail(kModes) = displaced(bar, {3e-3, 3e-3, 2e-4, 2e-4, 2e-4, 2e-4});
  const double energy = scene.energy();
  const Momentum before = momentum(scene);
  ModeFreezing freezing(explicit_method(1e-10, 1e-12), {.displacement = 2e-3});
  scene.run(freezing, 0.05);
  EXPECT_GE(freezing.frozen_count(), 1);
  EXPECT_LT(freezing.frozen_count(), kModes);
  EXPECT_GT(freezing.energy_taken(), 1e-5 * energy);
  EXPECT_NEAR(scene.energy() + freezing.energy_taken(), energy, 1e-7 * energy);
  EXPECT_LT((momentum(scene).angular - before.angular).norm(), 1e-7 * before.angular.norm());
}

TEST_P(Freezing, keeps_energy_and_its_account_of_a_pendulum_through_freezes_and_thaws) {
  // It stands on its pin against a push at its tip, and falls over: slowly at first, so that the stiff modes, which
  // swing by a fifth of what still is quiet, freeze; then across the push, which bends the second mode of its plane
  // four times as far as frozen modes may lack. Neither hangs on round-off.
  const double push = 150, speed = 0.05, quiet = 0.04, across = 0.2;
  Scene scene({9.81, 0, 0}, [&](SystemGraph& graph) {
    FlexibleBody::Parameters p = drawn(GetParam(), true);
    p.angular_velocity = {0, speed, 0};
    p.velocity = p.angular_velocity.cross(p.position);
    auto& bar = graph.add<FlexibleBody>("bar", p);
    graph.add<RevoluteJoint>("pin", {graph.ground().marker({}, kAcross), bar.frame(kAcross)});
    graph.add<PointForce>("push", {bar.average(bar.basis().node_set("x_max"))}, {.force = {-push, 0, 0}});
  });
  const auto& bar = static_cast<const FlexibleBody&>(*scene.graph.bodies().back().body);
  scene.state.q.tail(kModes) = displaced(bar, {0, 0, 1e-5, 1e-5, 1e-5, 1e-5});
  const double energy = scene.energy(), work = push * 0.5;
  ModeFreezing freezing(explicit_method(1e-9, 1e-11), {.displacement = 2e-4});
  const auto thaws = [&] {
    int sum = 0;
    for (const auto& mode : freezing.history()) sum += mode.thaws;
    return sum;
  };
  for (int k = 1; k <= 10; ++k) {
    scene.run(freezing, across * k / 10);
    EXPECT_NEAR(scene.energy() + freezing.energy_taken(), energy, 1e-9 * work);
    if (scene.state.time > 0.99 * quiet && scene.state.time < 1.01 * quiet) {
      EXPECT_EQ(freezing.frozen_count(), 4);
      EXPECT_EQ(thaws(), 0);
    }
  }
  EXPECT_GT(thaws(), 0);
  EXPECT_GT(freezing.energy_taken(), 1e-6 * work);  // a thousand times what its account may be off
  EXPECT_LT(scene.violation(Level::velocity), 1e-12);
}

/// A damped pendulum, hit on its tip at 0.6 s; what its tip does.
struct Swing {
  std::vector<Vector3> tip;
  long steps = 0;
  double residual = 0;
};
Swing swing(Deflection deflection, bool pinned, const MakeIntegrator& make,
            std::unique_ptr<Integrator>* made = nullptr) {
  Marker tip;
  Scene scene(kGravity, [&](SystemGraph& graph) {
    auto& bar = graph.add<FlexibleBody>("bar", drawn(deflection, !pinned, 0.05));
    tip = bar.average(bar.basis().node_set("x_max"));
    const Marker root = bar.average(bar.basis().node_set("x_min"), kAcross);
    if (pinned)
      graph.add<RevoluteJoint>("pin", {graph.ground().marker({}, kAcross), root});
    else
      graph.add<FixedJoint>("clamp", {graph.ground().marker(), bar.frame()});
    graph.add<UserForce>("hit", {tip}, {[](double t, const MarkerView&) {
                           const double s = (t - 0.6) / 0.02;
                           return force({0, 0, s > 0 && s < 1 ? 20 * std::pow(std::sin(M_PI * s), 2) : 0.0});
                         }});
  });
  auto integrator = make();
  Swing out;
  for (int k = 1; k <= 60; ++k) {
    scene.run(*integrator, 0.02 * k);
    scene.equations.evaluate(scene.state.time, scene.state.q, scene.state.v, Level::velocity);
    out.tip.push_back(marker_kinematics(scene.equations, tip, Level::position).p);
    out.residual = std::max(out.residual, scene.violation(Level::position));
  }
  out.steps = integrator->statistics().steps;
  if (made) *made = std::move(integrator);
  return out;
}
double largest_difference(const Swing& a, const Swing& b) {
  double largest = 0;
  for (size_t k = 0; k < a.tip.size(); ++k) largest = std::max(largest, (a.tip[k] - b.tip[k]).norm());
  return largest;
}

TEST_P(Freezing, lets_go_when_the_bar_is_hit_and_stays_within_the_promise) {
  for (const bool pinned : {false, true}) {
    const double displacement = 2e-5;
    std::unique_ptr<Integrator> used;
    const Swing free = swing(GetParam(), pinned, [] { return explicit_method(); });
    const Swing frozen = swing(
        GetParam(), pinned,
        [&] { return std::make_unique<ModeFreezing>(explicit_method(), ModeFreezing::Parameters{displacement}); },
        &used);
    const auto& freezing = static_cast<const ModeFreezing&>(*used);
    int freezes = 0, thaws = 0;
    for (const auto& mode : freezing.history()) freezes += mode.freezes, thaws += mode.thaws;
    EXPECT_GT(freezes, 0);
    EXPECT_GT(thaws, 0);
    EXPECT_LT(largest_difference(free, frozen), 3 * displacement) << (pinned ? "pinned" : "clamped");
    EXPECT_LT(frozen.residual, 1e-11);
    EXPECT_LT(frozen.steps, pinned ? free.steps / 5 : free.steps);
  }
}

INSTANTIATE_TEST_SUITE_P(Deflections, Freezing,
                         testing::Values(Deflection::linear, Deflection::stiffened, Deflection::quadratic),
                         [](const auto& test) { return to_string(test.param); });

/// A clamped bar that a force at its tip shakes.
Scene shaken(double damping, const std::function<double(double time)>& push, Marker* tip = nullptr) {
  return Scene(Vector3::Zero(), [&](SystemGraph& graph) {
    auto& bar = graph.add<FlexibleBody>("bar", drawn(Deflection::linear, true, damping));
    const Marker end = bar.average(bar.basis().node_set("x_max"));
    if (tip) *tip = end;
    graph.add<FixedJoint>("clamp", {graph.ground().marker(), bar.frame()});
    graph.add<UserForce>("push", {end}, {[=](double t, const MarkerView&) { return force({0, 0, push(t)}); }});
  });
}

TEST(ModeFreezing, of_a_quiet_damped_bar_lengthens_explicit_steps_sixty_times) {
  const auto steps = [](bool freezes) {
    Scene scene(kGravity, [](SystemGraph& graph) {
      FlexibleBody::Parameters p = drawn(Deflection::linear, true, 0.1);
      auto& bar = graph.add<FlexibleBody>("bar", p);
      p.modal_coordinates = displaced(bar, {1e-4, 1e-4, 1e-5});
      graph.add<FixedJoint>("clamp", {graph.ground().marker(), bar.frame()});
    });
    auto method = explicit_method(1e-6, 1e-8);
    if (freezes) method = std::make_unique<ModeFreezing>(std::move(method), ModeFreezing::Parameters{1e-4, 0.1});
    scene.run(*method, 1);
    const long before = method->statistics().steps;
    if (freezes) {
      EXPECT_EQ(static_cast<ModeFreezing&>(*method).frozen_count(), kModes);
    }
    scene.run(*method, 2);
    return method->statistics().steps - before;
  };
  EXPECT_LE(steps(true), 20);  // two an interval
  EXPECT_GT(steps(false), 60 * steps(true));
}

TEST(ModeFreezing, feels_resonance_that_no_static_deflection_shows) {
  // From 0.3 s on at the first frequency; its static deflection is a fifth of the displacement, the swing ten times it.
  const double displacement = 1e-4, ratio = 0.01;
  const auto& modes = *basis(Deflection::linear, true);
  Scene probe = shaken(ratio, [](double) { return 0.0; });
  const auto& body = static_cast<const FlexibleBody&>(*probe.graph.bodies().back().body);
  const double stiffness = body.candidate_stiffness()[0], omega = std::sqrt(stiffness);
  double reach = 0;  // of the tip, along z
  for (int k = 0; k < 2; ++k) reach = std::max(reach, std::abs(modes.node_modes(modes.node_set("x_max")[0])(2, k)));
  const double push = 0.2 * displacement * stiffness / (reach * reach);
  const auto largest = [&](bool freezes, int& thaws) {
    Marker tip;
    Scene scene = shaken(
        ratio, [=](double t) { return t > 0.3 ? push * std::sin(omega * (t - 0.3)) : 0.0; }, &tip);
    auto method = explicit_method(1e-7, 1e-9);
    if (freezes)
      method = std::make_unique<ModeFreezing>(std::move(method), ModeFreezing::Parameters{displacement, 0.002});
    scene.run(*method, 0.3);
    if (freezes) {
      EXPECT_EQ(static_cast<ModeFreezing&>(*method).frozen_count(), kModes);
    }
    double height = 0;
    while (scene.state.time < 1.5) {
      scene.run(*method, scene.state.time + 0.001);
      height = std::max(height, std::abs(marker_kinematics(scene.equations, tip, Level::position).p.z()));
    }
    thaws = 0;
    if (freezes)
      for (const auto& mode : static_cast<ModeFreezing&>(*method).history()) thaws += mode.thaws;
    return height;
  };
  int thaws = 0;
  const double free = largest(false, thaws), frozen = largest(true, thaws);
  EXPECT_GE(thaws, 1);
  EXPECT_GT(free, 5 * displacement);
  EXPECT_NEAR(frozen, free, 3 * displacement);
}

TEST(ModeFreezing, that_finds_nothing_quiet_leaves_every_bit_as_it_is) {
  const auto motion = [](bool freezes) {
    Scene scene(kGravity, [](SystemGraph& graph) {
      FlexibleBody::Parameters p = drawn(Deflection::linear, true);
      auto& bar = graph.add<FlexibleBody>("bar", p);
      graph.add<RevoluteJoint>("pin", {graph.ground().marker({}, kAcross), bar.frame(kAcross)});
    });
    const auto& bar = static_cast<const FlexibleBody&>(*scene.graph.bodies().back().body);
    scene.state.q.tail(kModes) = displaced(bar, {1e-3, 1e-3, 1e-3, 1e-3, 1e-3, 1e-3});
    auto method = explicit_method();
    if (freezes) method = std::make_unique<ModeFreezing>(std::move(method), ModeFreezing::Parameters{1e-5});
    Simulation simulation(scene.system, *method);
    State state = scene.state;
    simulation.run(state, 0.05);
    return state;
  };
  const State plain = motion(false), watched = motion(true);
  EXPECT_EQ(plain.q, watched.q);
  EXPECT_EQ(plain.v, watched.v);
  EXPECT_EQ(plain.v_dot, watched.v_dot);
}

TEST(ModeFreezing, is_undone_where_the_simulation_takes_its_step_back) {
  Scene scene = shaken(0.02, [](double) { return 0.0; });
  const auto& bar = static_cast<const FlexibleBody&>(*scene.graph.bodies().back().body);
  scene.state.v.tail(kModes) =
      displaced(bar, {1e-5, 1e-5, 1e-5, 1e-5, 1e-5, 1e-5}).cwiseProduct(bar.candidate_stiffness().cwiseSqrt());
  ModeFreezing freezing(explicit_method(), {.displacement = 1e-3});
  freezing.start(scene.equations, scene.state);
  State before = scene.state;
  while (freezing.frozen_count() == 0) {
    before = scene.state;
    ASSERT_TRUE(freezing.step(scene.equations, scene.state, 1).ok());
  }
  EXPECT_GT(freezing.energy_taken(), 0);
  freezing.start(scene.equations, before);
  EXPECT_EQ(freezing.frozen_count(), 0);
  EXPECT_EQ(freezing.energy_taken(), 0);
  for (const auto& mode : freezing.history()) EXPECT_EQ(mode.freezes, 0);
}

TEST(ModeFreezing, leaves_the_modes_that_joints_need) {
  // A bar clamped at one end and pinned at the other: frozen altogether it could not meet the pin's rows.
  Scene scene(kGravity, [](SystemGraph& graph) {
    auto& bar = graph.add<FlexibleBody>("bar", drawn(Deflection::linear, true, 0.1));
    graph.add<FixedJoint>("clamp", {graph.ground().marker(), bar.frame()});
    graph.add<SphericalJoint>("pin", {graph.ground().marker({0.5, 0, 0}), bar.average(bar.basis().node_set("x_max"))});
  });
  ModeFreezing freezing(explicit_method(), {.displacement = 1e-3});
  scene.run(freezing, 0.3);
  EXPECT_GE(freezing.frozen_count(), 1);
  EXPECT_LE(freezing.frozen_count(), kModes - 2);  // one in each plane
  EXPECT_LT(scene.violation(Level::position), 1e-12);
  EXPECT_LT(scene.violation(Level::velocity), 1e-10);
  EXPECT_LT(scene.state.v.norm(), 1e-3);
}

TEST(ModeFreezing, of_a_bent_bar_leaves_its_weight_to_the_clamp) {
  // Frozen off its equilibrium: let go it would pull at the clamp by many times its weight.
  SystemGraph graph{{.gravity = kGravity}};
  auto& bar = graph.add<FlexibleBody>("bar", drawn(Deflection::linear, true, 0.1));
  auto& clamp = graph.add<FixedJoint>("clamp", {graph.ground().marker(), bar.frame()});
  const System system = assemble(graph);
  State state = system.initial_state();
  state.q.tail(kModes) = displaced(bar, {2e-3});
  ModeFreezing freezing(explicit_method(), {.displacement = 0.02});
  Simulation simulation(system, freezing);
  simulation.run(state, 0.2);
  ASSERT_EQ(freezing.frozen_count(), kModes);
  Snapshot now(system, state);
  std::vector<double> load(6);
  reaction(clamp, 1).evaluate(now, load);
  EXPECT_NEAR(load[2], bar.mass() * 9.81, 1e-9);
  State let_go = state;
  let_go.lambda.resize(0);
  now.evaluate(let_go);
  reaction(clamp, 1).evaluate(now, load);
  EXPECT_GT(std::abs(load[2] / (bar.mass() * 9.81) - 1), 0.01);
}

TEST(ModeFreezing, is_an_option_of_a_simulation) {
  SystemGraph graph{{.gravity = kGravity}};
  auto& bar = graph.add<FlexibleBody>("bar", drawn(Deflection::linear, true, 0.1));
  graph.add<FixedJoint>("clamp", {graph.ground().marker(), bar.frame()});
  const System system = assemble(graph);
  State by_hand = system.initial_state();
  by_hand.q.tail(kModes) = displaced(bar, {2e-3});
  State state = by_hand;
  ModeFreezing freezing(explicit_method(), {.displacement = 0.02});
  Simulation(system, freezing).run(by_hand, 0.2);
  Simulation simulation(graph, [] { return explicit_method(); },
                        {.sleep = false, .freeze = ModeFreezing::Parameters{.displacement = 0.02}});
  simulation.run(state, 0.2);
  ASSERT_EQ(freezing.frozen_count(), kModes);
  EXPECT_EQ(state.q, by_hand.q);
  EXPECT_EQ(state.v, by_hand.v);
  EXPECT_NE(simulation.report().find(freezing.report()), std::string::npos) << simulation.report();
}

}  // namespace
}  // namespace lithe::test::mode_freezing_test
