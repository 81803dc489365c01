// Motion with rigid contacts: rolling and spinning friction, collisions of free bodies, contact beside joints, states
// carried on, and what is refused.
#include <gtest/gtest.h>

#include "engine/run/simulation.h"
#include "engine/simplify/simplification.h"
#include "integrators/generalized_alpha.h"
#include "integrators/radau.h"
#include "joints/fixed_joint.h"
#include "joints/revolute_joint.h"
#include "tests/reference/contact_scene.h"

namespace lithe::test::contact_motion_test {
namespace {

constexpr double g = 9.81;

/// A ball of 0.1 m on a plane, with friction 0.5 and these moments of friction, m.
State move_ball(double rolling, double spinning, const Vector3& velocity, const Vector3& spin, double time) {
  ContactScene scene;
  auto& ball = scene.sphere("ball", 0.1, 1, {0, 0, 0.1}, velocity, spin);
  scene.graph.add<Contact>(
      "contact", {scene.plane(), {ball.marker(), shape::sphere(0.1)}},
      {.law = RigidSurfaces{}, .friction = {.coefficient = 0.5, .rolling = rolling, .spinning = spinning}});
  scene.start(Stepper::moreau_jean, 1e-3);
  scene.run(time);
  return scene.state();
}

TEST(ContactMotion, spinning_friction_stops_a_ball_after_its_time) {
  const double sigma = 1e-3, rate = sigma * g / (0.4 * 0.01);  // moment σ m g on 2/5 m r²
  const State half = move_ball(0, sigma, {0, 0, 0}, {0, 0, 4}, 1);
  EXPECT_NEAR(half.v[5], 4 - rate, 1e-9);
  EXPECT_LT(half.v.head<5>().norm(), 1e-9);
  EXPECT_LT(move_ball(0, sigma, {0, 0, 0}, {0, 0, 4}, 4 / rate + 0.002).v.norm(), 1e-9);
}

TEST(ContactMotion, rolling_friction_slows_a_ball_by_its_rate_and_stops_it) {
  const double rho = 2e-3, rate = rho * g / (1.4 * 0.1);  // m a = F, 2/5 m r² a / r = ρ m g - F r
  const State rolling = move_ball(rho, 0, {1, 0, 0}, {0, 10, 0}, 1);
  EXPECT_NEAR(rolling.v[0], 1 - rate, 1e-9);
  EXPECT_NEAR(rolling.q[0], 1 - rate / 2, 1e-6);
  EXPECT_LT(move_ball(rho, 0, {1, 0, 0}, {0, 10, 0}, 1 / rate + 0.002).v.norm(), 1e-9);
}

TEST(ContactMotion, colliding_bodies_keep_momentum_and_without_loss_their_energy) {
  for (const double friction : {0.0, 0.4}) {
    ContactScene scene{{0, 0, 0}};
    auto& a = scene.sphere("a", 0.1, 1, {0, 0, 0}, {2, 0, 0}, {3, -5, 8});
    auto& b = scene.sphere("b", 0.2, 3, {0.35, 0.12, 0.05}, {-1, 0, 0}, {0, 2, -4});
    scene.contact({{a.marker(), shape::sphere(0.1)}, {b.marker(), shape::sphere(0.2)}}, friction, 1, 0);
    scene.start(Stepper::moreau_jean, 1e-4);
    const auto linear = [&] { return Vector3(scene.state().v.head<3>() + 3 * scene.state().v.segment<3>(6)); };
    const auto angular = [&] {
      const State& s = scene.state();
      return Vector3(s.q.head<3>().cross(s.v.head<3>()) + 3 * s.q.segment<3>(7).cross(s.v.segment<3>(6)) +
                     0.004 * (scene.axes(0) * s.v.segment<3>(3)) + 0.048 * (scene.axes(1) * s.v.segment<3>(9)));
    };
    const Vector3 p = linear(), l = angular();
    const double energy = scene.read(kinetic_energy());
    const Vector3 before = scene.state().v.head<3>();
    scene.run(0.1);
    ASSERT_GT((scene.state().v.head<3>() - before).norm(), 0.5) << "met";
    EXPECT_LT((linear() - p).norm(), 1e-13);
    // The arms are those of the middle of the step in which they meet.
    EXPECT_LT((angular() - l).norm(), 2e-4);
    if (friction == 0)
      EXPECT_NEAR(scene.read(kinetic_energy()), energy, 1e-12 * energy);
    else
      EXPECT_LT(scene.read(kinetic_energy()), energy);
  }
}

TEST(ContactMotion, a_pendulum_bounces_off_a_wall_with_the_restitution_of_its_point) {
  ContactScene scene;
  // Hangs from a hinge about y at the origin; the bob's ball of 0.1 m meets a wall at x = 0.1 when it hangs straight.
  const Matrix3 about_y = Eigen::AngleAxisd(-M_PI / 2, Vector3::UnitX()).matrix();
  const double angle = 0.5;
  auto& bob = scene.sphere("bob", 0.1, 1, {-std::sin(angle), 0, -std::cos(angle)});
  scene.graph.add<RevoluteJoint>(
      "hinge", {scene.graph.ground().marker({}, about_y), bob.marker({std::sin(angle), 0, std::cos(angle)}, about_y)});
  Matrix3 wall;  // z towards -x
  wall << 0, 0, -1, 0, 1, 0, 1, 0, 0;
  scene.contact({scene.plane({0.1, 0, 0}, wall), {bob.marker(), shape::sphere(0.1)}}, 0, 0.6);
  scene.start(Stepper::moreau_jean, 1e-3);
  double fastest = 0, back = 0;
  while (scene.state().time < 1) {
    scene.step();
    fastest = std::max(fastest, scene.state().v[0]);
    back = std::min(back, scene.state().v[0]);
    EXPECT_GT(scene.state().q[0], -1) << "passes";
    EXPECT_LT(scene.state().q[0], 1e-6) << "goes through the wall";
  }
  const double speed = std::sqrt(2 * g * (1 - std::cos(angle)) / 1.004);  // inertia 1 + 2/5 r² about the hinge
  EXPECT_NEAR(fastest, speed, 5e-3 * speed);
  EXPECT_NEAR(-back, 0.6 * speed, 5e-3 * speed);
}

TEST(ContactMotion, a_lever_on_a_stop_loads_stop_and_hinge_by_statics) {
  ContactScene scene;
  const Matrix3 about_y = Eigen::AngleAxisd(-M_PI / 2, Vector3::UnitX()).matrix();
  auto& lever = scene.box("lever", {1, 0.1, 0.02}, 2, {0.5, 0, 0});
  auto& hinge = scene.graph.add<RevoluteJoint>(
      "hinge", {scene.graph.ground().marker({}, about_y), lever.marker({-0.5, 0, 0}, about_y)});
  // A ball at 0.8 m from the hinge on a plane below it.
  auto& contact = scene.contact({scene.plane({0, 0, -0.1}), {lever.marker({0.3, 0, 0}), shape::sphere(0.1)}},
                                0);  // friction would share with the hinge
  scene.start(Stepper::moreau_jean, 1e-3);
  scene.run(0.5);
  EXPECT_NEAR(scene.read(contact_force(contact, 1), 2), 2 * g * 0.5 / 0.8, 1e-8);
  EXPECT_NEAR(scene.read(reaction(hinge, 1), 2), 2 * g * (1 - 0.5 / 0.8), 1e-6);
  EXPECT_LT(scene.state().v.norm(), 1e-10);
}

/// Two balls that fall on each other and a plane.
ContactScene& draw_balls(ContactScene& scene) {
  auto& a = scene.sphere("a", 0.1, 1, {0, 0, 0.5}, {1, 0, 0});
  auto& b = scene.sphere("b", 0.1, 2, {0.05, 0.02, 0.8}, {0.9, 0, 0}, {0, 0, 5});
  scene.contact({scene.plane(), {a.marker(), shape::sphere(0.1)}, {b.marker(), shape::sphere(0.1)}}, 0.4, 0.5);
  return scene;
}

TEST(ContactMotion, a_run_in_two_parts_or_from_a_copied_state_is_the_same_run) {
  ContactScene one, two, third;
  for (ContactScene* scene : {&one, &two, &third}) draw_balls(*scene).start(Stepper::moreau_jean, 1e-3);
  one.run(1);
  two.run(0.4), two.run(1);
  EXPECT_TRUE(same(one.state(), two.state()));
  two.run(1.4);
  third.set(one.state());
  third.run(1.4);
  EXPECT_TRUE(same(two.state(), third.state()));
}

TEST(ContactMotion, a_simulation_by_islands_moves_bodies_in_touch_alike) {
  ContactScene plain, islands;
  draw_balls(plain).start(Stepper::moreau_jean, 1e-3);
  draw_balls(islands);
  plain.run(1);
  Simulation simulation(islands.graph,
                        [] { return std::make_unique<MoreauJean>(MoreauJean::Parameters{.step = 1e-3}); },
                        {.sleep = false});
  State state = simulation.system().initial_state();
  simulation.run(state, 1);
  EXPECT_LT((state.q - plain.state().q).lpNorm<Eigen::Infinity>(), 1e-9);
  EXPECT_LT((state.v - plain.state().v).lpNorm<Eigen::Infinity>(), 1e-8);
}

/// A ball that falls onto a lever with a plate fixed to it, on a hinge: in a plane, but for the ball.
TEST(ContactMotion, a_simplified_scene_meets_alike) {
  for (const bool rigid : {false, true}) {
    ContactScene scene;
    const Matrix3 about_y = Eigen::AngleAxisd(-M_PI / 2, Vector3::UnitX()).matrix();
    auto& lever = scene.box("lever", {1, 0.1, 0.02}, 2, {0.5, 0, 0});
    auto& plate = scene.box("plate", {0.2, 0.2, 0.02}, 0.5, {0.8, 0, 0.02});
    auto& ball = scene.sphere("ball", 0.1, 0.5, {0.75, 0.03, 0.16}, {0.1, 0, 0});
    scene.graph.add<RevoluteJoint>("hinge",
                                   {scene.graph.ground().marker({}, about_y), lever.marker({-0.5, 0, 0}, about_y)});
    scene.graph.add<FixedJoint>("bolts", {lever.marker({0.3, 0, 0.01}), plate.marker({0, 0, -0.01})});
    const std::vector<Collider> colliders{{plate.marker(), shape::box({0.2, 0.2, 0.02})},
                                          {ball.marker(), shape::sphere(0.1)}};
    if (rigid)
      scene.contact(colliders, 0.3, 0.5);
    else
      scene.graph.add<Contact>("contact", colliders,
                               {.law = Compliance{.stiffness = 1e6}, .friction = {.coefficient = 0.3}});
    const auto method = [&]() -> std::unique_ptr<Integrator> {
      if (rigid) return std::make_unique<MoreauJean>(MoreauJean::Parameters{.step = 1e-4});
      return std::make_unique<Automatic>(Automatic::Parameters{.tolerance = {1e-10, 1e-12}});
    };
    Simulation simple(scene.graph, method, {.simplify = true, .split = false, .sleep = false});
    EXPECT_TRUE(simple.simplification()->smaller());
    State small = simple.start(), full = simple.observed().initial_state(), expanded = full;
    const auto whole = method();
    simple.run(small, 0.3);
    Simulation(simple.observed(), *whole).run(full, 0.3);
    simple.simplification()->expand(small, expanded);
    EXPECT_GT(full.v.segment<3>(12).norm(), 0.2) << "the ball is thrown off";
    EXPECT_LT((expanded.q - full.q).lpNorm<Eigen::Infinity>(), 1e-6) << (rigid ? "rigid" : "compliant");
  }
}

TEST(ContactMotion, what_cannot_be_is_refused) {
  const auto refused = [](auto&& make, const std::string& word) {
    try {
      make();
      ADD_FAILURE() << "not refused: " << word;
    } catch (const SceneError& error) {
      EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
    }
  };
  ContactScene scene;
  auto& ball = scene.sphere("ball", 0.1, 1, {0, 0, 1});
  const Collider round{ball.marker(), shape::sphere(0.1)};
  refused([&] { scene.contact({round}, 0); }, "fewer than two");
  refused([&] { scene.contact({round, round}, 0); }, "no two");
  refused([&] { scene.contact({scene.plane(), {ball.marker(), shape::sphere(0.1), 32}}, 0); }, "group 32");
  refused([&] { scene.contact({scene.plane(), {ball.marker(), shape::sphere(0.1), 0, groups({3})}}, 0); }, "no two");
  refused([&] { scene.contact({scene.plane(), round}, std::nan("")); }, "coefficient");
  refused([&] { scene.contact({scene.plane(), round}, 0, 1.5); }, "restitution");
  refused([&] { scene.contact({scene.plane(), round}, 0, std::nan("")); }, "restitution");
  refused([] { shape::sphere(std::nan("")); }, "radius");
  scene.contact({scene.plane(), round}, 0.3);
  const System system = assemble(scene.graph);
  Automatic automatic;
  Radau radau{{.step = 1e-3}};
  GeneralizedAlpha alpha{{.step = 1e-3}};
  for (Integrator* integrator : std::initializer_list<Integrator*>{&automatic, &radau, &alpha}) {
    Simulation simulation(system, *integrator);
    State state = system.initial_state();
    refused([&] { simulation.run(state, 0.1); }, "MoreauJean");
  }
}

}  // namespace
}  // namespace lithe::test::contact_motion_test
