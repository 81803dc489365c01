// Cams against circles; bodies and integrators behind C tables against the same compiled in.
#include <gtest/gtest.h>

#include "bodies/rigid_body.h"
#include "engine/assembly/batch_of.h"
#include "engine/assembly/evaluator.h"
#include "engine/observe/recorder.h"
#include "engine/observe/snapshot.h"
#include "engine/run/simulation.h"
#include "integrators/generalized_alpha.h"
#include "joints/cylindrical_joint.h"
#include "joints/distance_joint.h"
#include "joints/prismatic_joint.h"
#include "joints/revolute_joint.h"
#include "joints/spherical_joint.h"
#include "plugins/cam_follower/cam_follower.cpp"
#include "plugins/massless_rod/massless_rod.cpp"
#include "tests/plugins/kinds/frame_chain.cpp"
#include "tests/plugins/kinds/heun.cpp"
#include "tests/plugins/kinds/nut_and_skate.cpp"
#include "tests/plugins/kinds/rattle_box.cpp"
#include "tests/plugins/plugins.h"
#include "tests/support/body_checks.h"
#include "tests/support/methods.h"

namespace lithe::test::kinds_test {
namespace {

VectorX run(SystemGraph& graph, Integrator& integrator, double end) {
  const System system = assemble(graph);
  State state = system.initial_state();
  Simulation simulation(system, integrator);
  simulation.run(state, end);
  VectorX all(state.q.size() + state.v.size() + state.lambda.size());
  all << state.q, state.v, state.lambda;
  return all;
}

// ---- the cam ----

/// A cam on a hinge at the origin that carries a weight; the roller on a bar that is guided along y, above it.
struct CamScene {
  SystemGraph graph{{.gravity = {0, -9.81, 0}}};
  RigidBody& cam = graph.add<RigidBody>("cam", {.mass = 3, .inertia = {1, 1, 2}, .angular_velocity = {0, 0, 2}});
  RigidBody& bar = graph.add<RigidBody>("bar", {.mass = 0.5, .inertia = {0.1, 0.1, 0.1}, .position = {0, 1.2, 0}});
  CamScene() {
    graph.add<RevoluteJoint>("shaft", {graph.ground().marker(), cam.marker()});
    const Matrix3 up = rotation_about({1, 0, 0}, -M_PI / 2);  // z along the world's y
    graph.add<PrismaticJoint>("guide", {graph.ground().marker({0, 0, 0}, up), bar.marker({0, 0, 0}, up)});
  }
};

TEST(CamFollower, on_an_eccentric_circle_moves_as_a_rod_to_its_centre_does) {
  // The roller's centre stays at R + ρ from the circle's centre, e off the shaft: as a rod would hold it.
  const double R = 1, e = 0.3, rho = 0.2;
  const auto circle = [&](int n) {
    std::vector<double> xy;
    for (int i = 0; i < n; ++i) {
      xy.push_back(e + R * std::cos(2 * M_PI * i / n));
      xy.push_back(R * std::sin(2 * M_PI * i / n));
    }
    return xy;
  };
  CamScene rod;
  rod.graph.add<DistanceJoint>("rod", {rod.cam.marker({e, 0, 0}), rod.bar.marker()}, {.length = R + rho});
  const Method exact_method = runge_kutta(1e-10);
  const VectorX exact = run(rod.graph, *exact_method, 3);
  double errors[2];
  for (const int k : {0, 1}) {
    CamScene scene;
    scene.graph.add<CamFollower>("cam and roller", {scene.cam.marker(), scene.bar.marker()},
                                 {.profile = circle(k == 0 ? 24 : 48), .roller_radius = rho});
    const Method method = runge_kutta(1e-10);
    const VectorX end = run(scene.graph, *method, 3);
    errors[k] = (end - exact).head(14).cwiseAbs().maxCoeff();  // coordinates
  }
  expect_below("spline of 24 points on a circle: error of the motion after 3 s", errors[0], 2e-3);
  // The spline's points are exact to h⁴, the normal along which it pushes to h³: 1/8.
  expect_below("spline of 48 points: error over that of 24 (third order: 1/8)", errors[1] / errors[0], 1.0 / 7);
}

TEST(CamFollower, lift_of_a_knife_edge_is_the_profile) {
  // The edge on the y axis stands at r(φ) where the profile's point of that angle has come: θ + φ = 90 degrees.
  const auto r = [](double phi) { return 1 + 0.2 * std::sin(phi) + 0.05 * std::cos(3 * phi); };
  CamScene scene;
  scene.graph.add<CamFollower>("edge", {scene.cam.marker(), scene.bar.marker()}, {.profile = profile_of(120, r)});
  const System system = assemble(scene.graph);
  State state = system.initial_state();
  GeneralizedAlpha integrator{{.step = 2e-3, .spectral_radius = 0.9}};
  Simulation simulation(system, integrator);
  double turned = 0;
  for (int i = 1; i <= 10; ++i) {
    simulation.run(state, 0.1 * i);
    const double theta = 2 * std::atan2(state.q[6], state.q[3]);
    turned = std::max(turned, std::abs(theta));
    EXPECT_NEAR(state.q[7 + 1], r(M_PI / 2 - theta), 1e-6);
  }
  EXPECT_GT(turned, 1);
}

TEST(CamFollower, refuses_what_is_no_cam_and_says_how_to_fix_it) {
  const auto problem = [](const CamFollower::Parameters& p) -> std::string {
    try {
      const CamFollower cam(p);
    } catch (const SceneError& error) {
      return error.problem();
    }
    return "";
  };
  std::vector<double> clockwise;
  for (int i = 11; i >= 0; --i) clockwise.insert(clockwise.end(), {egg(12)[2 * i], egg(12)[2 * i + 1]});
  std::vector<double> closed = egg(12);
  closed.insert(closed.end(), {closed[0], closed[1]});
  EXPECT_EQ(problem({{0, 0, 1}}), "the profile has 3 numbers");
  EXPECT_EQ(problem({clockwise}), "the profile runs clockwise");
  EXPECT_EQ(problem({closed}), "point 13 of the profile is given twice");
  const auto waist = [](double phi) { return 1 + 0.4 * std::cos(2 * phi); };
  EXPECT_NE(problem({profile_of(60, waist), 2.0}).find("does not fit into the hollow"), std::string::npos);
  EXPECT_EQ(problem({profile_of(60, waist), 0.05}), "");
}

// ---- what joints remember, and rows on velocities ----

TEST(JointFromC, counts_the_turns_of_its_angle) {
  Registry registry;
  registry.load_plugin(library("nut_and_skate"));
  VectorX ends[2];
  for (const int k : {0, 1}) {
    SystemGraph graph{{.gravity = {0, 0, 0}}};
    auto& nut = graph.add<RigidBody>("nut", {.velocity = {0, 0, 0.4}, .angular_velocity = {0, 0, 20}});
    const std::vector<Marker> markers{graph.ground().marker(), nut.marker()};
    graph.add<CylindricalJoint>("bolt", markers);
    if (k == 0)
      graph.add<Nut>("thread", markers, {.pitch = 0.02});
    else
      graph.add(registry.joint("nut"), "thread", markers, {{"pitch", 0.02}});
    GeneralizedAlpha integrator{{.step = 1e-2}};
    ends[k] = run(graph, integrator, 2);
    EXPECT_NEAR(ends[k][2], 0.02 * 40, 1e-9);  // six turns and a bit
  }
  EXPECT_EQ(0, std::memcmp(ends[0].data(), ends[1].data(), 8 * ends[0].size()));
}

TEST(JointFromC, may_have_rows_on_velocities_alone) {
  // A skate that turns evenly and goes at speed v ahead runs on a circle of radius v/ω.
  Registry registry;
  registry.load_plugin(library("nut_and_skate"));
  SystemGraph graph{{.gravity = {0, 0, 0}}};
  auto& skate = graph.add<RigidBody>("skate", {.velocity = {3, 0, 0}, .angular_velocity = {0, 0, 2}});
  graph.add(registry.joint("skate"), "blade", {skate.marker()});
  const Method method = runge_kutta(1e-9);
  const VectorX end = run(graph, *method, 2);
  EXPECT_NEAR(end[0], 1.5 * std::sin(4), 1e-7);
  EXPECT_NEAR(end[1], 1.5 * (1 - std::cos(4)), 1e-7);
}

// ---- a body ----

template <class AddBody>
auto draw_box(SystemGraph& graph, AddBody&& add) -> decltype(add(graph)) {
  auto& box = add(graph);
  graph.add<RevoluteJoint>("pin", {graph.ground().marker({0, 0, 0}, rotation_about({1, 0, 0}, 1)),
                                   box.marker({-0.5, 0, 0}, rotation_about({1, 0, 0}, 1))});
  auto& ball = graph.add<RigidBody>("ball", {.mass = 0.2, .inertia = {0.01, 0.01, 0.01}, .position = {0.8, 0, 0.4}});
  graph.add<MasslessRod>("string", {box.node(1), ball.marker()}, {.length = 0.4});
  return box;
}
RattleBox& add_compiled(SystemGraph& graph) {
  return graph.add<RattleBox>("box", {.stiffness = 80, .position = {0.5, 0, 0}});
}

TEST(BodyFromC, takes_a_marker_where_it_is_put_in_the_world) {
  Registry registry;
  registry.load_plugin(library("rattle_box"));
  SystemGraph graph;
  auto& box = graph.add(registry.body("rattle_box"), "box", {{"position", {0.5, -1, 2}}});
  const Matrix3 axes = rotation_about({1, 2, 3}, 0.4);
  const Marker marker = box.marker_at_world({1, 1, 1}, axes);
  const System system = assemble(graph);
  Snapshot now{system, system.initial_state()};
  EXPECT_LT((now.marker(marker).p - Vector3(1, 1, 1)).norm(), 1e-15);
  EXPECT_LT((now.marker(marker).R - axes).norm(), 1e-15);
}

TEST(BodyFromC, passes_the_checks_of_a_body) {
  Registry registry;
  registry.load_plugin(library("rattle_box"));
  SystemGraph graph;
  auto& box = graph.add(registry.body("rattle_box"), "box", {{"mass", 1.2}, {"inertia", {0.3, 0.4, 0.2}}});
  check_body(graph, box, {box.marker({0.1, 0.2, 0.3}, rotation_about({1, 1, 0}, 0.5)), box.node(1)}, {.mass = 1.7});
}

TEST(BodyFromC, moves_as_the_same_class_compiled_in_bit_by_bit) {
  Registry registry;
  registry.load_plugin(library("rattle_box"));
  SystemGraph compiled, loaded;
  draw_box(compiled, add_compiled);
  draw_box(loaded, [&](SystemGraph& graph) -> BodyFromC& {
    return graph.add(registry.body("rattle_box"), "box", {{"stiffness", 80}, {"position", {0.5, 0, 0}}});
  });
  GeneralizedAlpha a{{.step = 1e-3}}, b{{.step = 1e-3}};
  const VectorX here = run(compiled, a, 1), there = run(loaded, b, 1);
  EXPECT_EQ(0, std::memcmp(here.data(), there.data(), 8 * here.size())) << (here - there).cwiseAbs().maxCoeff();
  EXPECT_GT((here - there.reverse()).norm(), 1);  // something moved
}

/// Three frames, blocks of their pairs and markers in each of them cross the border too.
TEST(BodyFromC, with_several_frames_moves_as_the_same_class_compiled_in_bit_by_bit) {
  Registry registry;
  registry.load_plugin(library("frame_chain"));
  const auto draw = [](SystemGraph& graph, auto& chain) {
    graph.add<SphericalJoint>("pin", {graph.ground().marker({-0.1, 0, 0}), chain.marker({-0.1, 0, 0})});
    auto& ball = graph.add<RigidBody>("ball", {.mass = 0.2, .inertia = {0.01, 0.01, 0.01}, .position = {1, 0, 0.4}});
    graph.add<MasslessRod>("string", {chain.node(2), ball.marker()}, {.length = 0.4});
  };
  SystemGraph compiled, loaded;
  draw(compiled, compiled.add<FrameChain>("chain", {.stiffness = 90}));
  draw(loaded, loaded.add(registry.body("frame_chain"), "chain", {{"stiffness", 90}}));
  GeneralizedAlpha a{{.step = 1e-3}}, b{{.step = 1e-3}};
  const VectorX here = run(compiled, a, 0.5), there = run(loaded, b, 0.5);
  ASSERT_GE(here.size(), 28);  // coordinates first
  EXPECT_EQ(0, std::memcmp(here.data(), there.data(), 8 * here.size())) << (here - there).cwiseAbs().maxCoeff();
  EXPECT_GT((here.segment<3>(14) - Vector3(1, 0, 0)).norm(), 0.1);  // something moved
}

/// The same box from its energies: mass matrix, velocity terms, tangents and markers are derived.
TEST(BodyFromC, by_its_energies_moves_as_the_one_written_by_hand) {
  Registry registry;
  registry.load_plugin(library("derived_box"));
  SystemGraph written, derived, alone;
  draw_box(written, add_compiled);
  draw_box(derived, [&](SystemGraph& graph) -> BodyFromC& {
    return graph.add(registry.body("derived_box"), "box", {{"stiffness", 80}, {"position", {0.5, 0, 0}}});
  });
  const Method a = runge_kutta8_fixed(1e-3), b = runge_kutta8_fixed(1e-3);
  const VectorX here = run(written, *a, 0.5), there = run(derived, *b, 0.5);
  EXPECT_LT((here - there).cwiseAbs().maxCoeff(), 1e-11);
  auto& box = alone.add(registry.body("derived_box"), "box", {{"mass", 1.2}, {"inertia", {0.3, 0.4, 0.2}}});
  check_body(alone, box, {box.marker({0.1, 0.2, 0.3}, rotation_about({1, 1, 0}, 0.5)), box.node(1)}, {.mass = 1.7});
}

TEST(BodyFromC, tells_which_markers_it_has) {
  Registry registry;
  registry.load_plugin(library("rattle_box"));
  SystemGraph graph;
  auto& box = graph.add(registry.body("rattle_box"), "box");
  try {
    box.node(7);
    FAIL();
  } catch (const SceneError& error) {
    EXPECT_EQ(error.problem(), "'box': body type 'rattle_box' of rattle_box.so refuses a marker: there is no node 7");
    EXPECT_EQ(error.fix(), "the bead is node 1");
  }
  try {
    box.average({1, 2});
    FAIL();
  } catch (const SceneError& error) {
    EXPECT_EQ(error.fix(), "it has marker(position) node(number)");
  }
}

// ---- integrators ----

SystemGraph& pendulum(SystemGraph& graph) {
  auto& box = draw_box(graph, add_compiled);
  (void)box;
  return graph;
}

TEST(IntegratorFromC, explicit_takes_the_same_steps_as_compiled_in) {
  Registry registry;
  registry.load_plugin(library("heun"));
  SystemGraph graph;
  pendulum(graph);
  Heun compiled({.step = 1e-3});
  const auto loaded = registry.integrator("heun", {{"step", 1e-3}});
  const VectorX here = run(graph, compiled, 1), there = run(graph, *loaded, 1);
  EXPECT_EQ(0, std::memcmp(here.data(), there.data(), 8 * here.size())) << (here - there).cwiseAbs().maxCoeff();
  EXPECT_EQ(loaded->statistics().steps, 1000);
  EXPECT_EQ(loaded->name(), "integrator type 'heun' of heun.so");
}

TEST(IntegratorFromC, implicit_with_automatic_steps_takes_the_same_as_compiled_in) {
  Registry registry;
  registry.load_plugin(library("alpha"));
  SystemGraph graph;
  pendulum(graph);
  GeneralizedAlpha compiled{{}};
  const auto loaded = registry.integrator("alpha");
  const VectorX here = run(graph, compiled, 1), there = run(graph, *loaded, 1);
  EXPECT_EQ(0, std::memcmp(here.data(), there.data(), 8 * here.size())) << (here - there).cwiseAbs().maxCoeff();
  EXPECT_EQ(loaded->statistics().steps, compiled.statistics().steps);
  EXPECT_EQ(loaded->statistics().newton_iterations, compiled.statistics().newton_iterations);
}

TEST(IntegratorFromC, serves_one_system_after_another) {
  Registry registry;
  registry.load_plugin(library("heun"));
  const auto method = registry.integrator("heun", {{"step", 1e-3}});
  SystemGraph first, second;
  pendulum(first);
  second.add<RigidBody>("stone", {.velocity = {1, 0, 0}});
  run(first, *method, 0.01);
  const VectorX fallen = run(second, *method, 1);
  EXPECT_NEAR(fallen[0], 1, 1e-12);
  EXPECT_NEAR(fallen[2], -9.81 / 2, 1e-12);
}

TEST(PlainC, joint_and_integrator_need_no_cpp) {
  Registry registry;
  registry.load_plugin(library("plain_c"));
  double periods[2];
  for (const int k : {0, 1}) {
    SystemGraph graph;
    auto& bob = graph.add<RigidBody>("bob", {.mass = 2, .inertia = {0.1, 0.1, 0.1}, .position = {0.5, 0, 0}});
    graph.add(registry.joint("c_rod"), "string", {graph.ground().marker(), bob.marker()}, {{"length", 0.5}});
    const System system = assemble(graph);
    State state = system.initial_state();
    const auto method = registry.integrator("c_euler", {{"step", k == 0 ? 2e-4 : 1e-4}});
    Simulation simulation(system, *method);
    simulation.run(state, 0.1);
    // Back at rest after one period: 4 K(sin 45°) sqrt(L/g).
    double last = state.q[0], speed = state.v[0];
    while (!(speed > 0 && state.v[0] <= 0)) {
      speed = state.v[0], last = state.time;
      simulation.run(state, state.time + 1e-3);
    }
    periods[k] = last + (state.time - last) * speed / (speed - state.v[0]);
    EXPECT_NEAR(state.q.head<3>().norm(), 0.5, k == 0 ? 2e-3 : 1e-3);  // nobody projects
  }
  const double exact = 4 * std::comp_ellint_1(std::sin(M_PI / 4)) * std::sqrt(0.5 / 9.81);
  EXPECT_NEAR(periods[1], exact, 2e-3);
  EXPECT_LT(std::abs(periods[1] - exact), std::abs(periods[0] - exact));
  EXPECT_THROW(
      {
        SystemGraph graph;
        graph.add(registry.joint("c_rod"), "string", {graph.ground().marker(), graph.ground().marker()},
                  {{"length", -1}});
      },
      SceneError);
}

}  // namespace
}  // namespace lithe::test::kinds_test
