#include "engine/analysis/equilibrium.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "bodies/flexible/flexible_body.h"
#include "bodies/rigid_body.h"
#include "engine/analysis/linearization.h"
#include "engine/observe/sensors.h"
#include "engine/run/simulation.h"
#include "integrators/generalized_alpha.h"
#include "joints/coordinate_drive.h"
#include "joints/fixed_joint.h"
#include "joints/forces/spring_damper.h"
#include "joints/revolute_joint.h"
#include "joints/spherical_joint.h"
#include "tests/bodies/flexible_models.h"
#include "tests/engine/output/output_scratch_folder.h"
#include "tests/support/linear_algebra.h"

namespace lithe::test::equilibrium_test {

using lithe::test::message_of;
using testing::HasSubstr;

namespace {

constexpr double kGravity = 9.81;
const Matrix3 kAxisY = rotation_about({1, 0, 0}, -M_PI / 2);  // marker z along world y

/// A rod of 1 m and 2 kg, pinned at the origin about y, at an angle from the upright.
struct Pendulum {
  explicit Pendulum(double angle) {
    const Matrix3 A = rotation_about({0, 1, 0}, angle);
    rod = &graph.add<RigidBody>(
        "rod",
        {.mass = 2, .inertia = {2.0 / 12, 2.0 / 12, 1e-3}, .position = A * Vector3(0, 0, 0.5), .orientation = A});
    pin =
        &graph.add<RevoluteJoint>("pin", {graph.ground().marker({0, 0, 0}, kAxisY), rod->marker({0, 0, -0.5}, kAxisY)});
  }
  SystemGraph graph;
  RigidBody* rod;
  RevoluteJoint* pin;
};

/// Largest velocity after a time, started from the state.
double speed_after(const System& system, State state, double time) {
  GeneralizedAlpha integrator({.step = 1e-3});
  Simulation simulation(system, integrator);
  simulation.run(state, state.time + time);
  return state.v.lpNorm<Eigen::Infinity>();
}

}  // namespace

TEST(equilibrium, a_pendulum_sinks_to_its_lowest_position_from_anywhere) {
  for (double angle : {0.01, 0.7, 2.0, 3.1}) {
    Pendulum scene(angle);
    const System system = assemble(scene.graph);
    const Equilibrium found = find_equilibrium(system, system.initial_state());
    EXPECT_NEAR(found.state.q[2], -0.5, 1e-12) << "from " << angle;
    EXPECT_LT(found.out_of_balance, 1e-12);
    EXPECT_LT(found.load_steps, 40);
    EXPECT_LT(speed_after(system, found.state, 0.5), 1e-11);
    EXPECT_GT(linearize(system, found.state).lowest_stiffness(), 0);
  }
}

TEST(equilibrium, an_upright_rod_is_in_balance_and_told_to_be_unstable) {
  Pendulum scene(0);
  const System system = assemble(scene.graph);
  const Equilibrium found = find_equilibrium(system, system.initial_state());
  EXPECT_NEAR(found.state.q[2], 0.5, 1e-14);
  EXPECT_EQ(found.load_steps, 0);
  const double omega2 = 2 * kGravity * 0.5 / (2.0 / 12 + 2 * 0.25);
  EXPECT_NEAR(linearize(system, found.state).lowest_stiffness(), -omega2, 1e-8);
}

/// Two bars on ball joints, each upright or hanging: four rests, three of them saddles. Started there, a step is
/// round-off, and what it says of the stiffness is nothing. About the rest, with signs s of up and down,
///   M = [J + 5 m l²/4, s_1 s_2 m l²/2; ., J + m l²/4],   K = -m g l/2 diag(3 s_1, s_2)
TEST(equilibrium, a_start_on_a_saddle_is_found_and_its_motion_told) {
  const double m = 1, l = 1, J = 0.1;
  for (const double first : {1.0, -1.0})
    for (const double second : {1.0, -1.0})
      for (const double off : {0.0, 1e-12, 1e-9}) {
        SCOPED_TRACE(testing::Message() << first << ' ' << second << ' ' << off);
        SystemGraph graph;
        const auto turned = [](double up, double by) { return rotation_about({0, 1, 0}, -up * M_PI / 2 + by); };
        const Matrix3 A = turned(first, off), B = turned(second, -0.7 * off);
        const RigidBody::Parameters bar{.mass = m, .inertia = {1e-3, J, J}};
        RigidBody::Parameters lower = bar, upper = bar;
        lower.orientation = A, lower.position = A * Vector3(l / 2, 0, 0);
        upper.orientation = B, upper.position = A * Vector3(l, 0, 0) + B * Vector3(l / 2, 0, 0);
        auto& one = graph.add<RigidBody>("one", lower);
        auto& two = graph.add<RigidBody>("two", upper);
        graph.add<SphericalJoint>("foot", {graph.ground().marker(), one.marker({-l / 2, 0, 0})});
        graph.add<SphericalJoint>("knee", {one.marker({l / 2, 0, 0}), two.marker({-l / 2, 0, 0})});
        const System system = assemble(graph);

        const Equilibrium found = find_equilibrium(system, system.initial_state());
        EXPECT_NEAR(found.state.q[2], first * l / 2, 1e-9);
        EXPECT_NEAR(found.state.q[9], first * l + second * l / 2, 1e-9);
        EXPECT_LT(found.out_of_balance, 1e-9);
        const double a = J + 1.25 * m * l * l, b = first * second * m * l * l / 2, c = J + 0.25 * m * l * l;
        const double k = -1.5 * m * kGravity * l * first, n = -0.5 * m * kGravity * l * second;
        const double half = (a * n + c * k) / 2,
                     lowest = (half - std::sqrt(half * half - (a * c - b * b) * k * n)) / (a * c - b * b);
        const double told = linearize(system, found.state).lowest_stiffness();
        if (lowest < 0)
          EXPECT_NEAR(told / lowest, 1, 1e-8);
        else
          EXPECT_NEAR(told, 0, 1e-9);  // turns about the vertical are free
      }
}

TEST(equilibrium, a_spring_holds_a_column_upright_up_to_its_buckling_load) {
  // A rod of length L on a pin, its weight at the middle, held at the top by a horizontal spring: stable while
  // k L > m g / 2.
  const double critical = 2 * kGravity / 2;
  for (double k : {0.9 * critical, 1.1 * critical}) {
    Pendulum scene(1e-3);
    scene.graph.add<SpringDamper>("spring", {scene.graph.ground().marker({-100, 0, 1}), scene.rod->marker({0, 0, 0.5})},
                                  {.stiffness = k, .natural_length = 100});
    const System system = assemble(scene.graph);
    const Equilibrium found = find_equilibrium(system, system.initial_state());
    EXPECT_LT(found.out_of_balance, 1e-11);
    EXPECT_GT(linearize(system, found.state).lowest_stiffness(), 0);
    const double angle = std::atan2(found.state.q[0], found.state.q[2]);
    if (k > critical) {
      EXPECT_NEAR(angle, 0, 1e-9);
    } else {  // leaning needs cos a = m g / 2 k > 1: it falls over
      EXPECT_GT(std::abs(angle), 3);
    }
  }
}

TEST(equilibrium, a_motion_that_nothing_holds_keeps_its_place) {
  SystemGraph graph;
  const Vector3 direction = Vector3(0.6, 0.8, 0.3).normalized();
  auto& ball = graph.add<RigidBody>("ball", {.mass = 3, .inertia = {0.1, 0.1, 0.1}, .position = direction});
  graph.add<SphericalJoint>("pivot", {graph.ground().marker(), ball.marker(-direction)});
  const System system = assemble(graph);
  const Equilibrium found = find_equilibrium(system, system.initial_state());
  EXPECT_NEAR(found.state.q[2], -1, 1e-12);
  EXPECT_NEAR(found.state.q.head<2>().norm(), 0, 1e-7);
  EXPECT_LT(found.out_of_balance, 1e-11);
  // Swing it out sideways against a spring: then the azimuth of the spring's anchor is all that is left.
  EXPECT_LT(speed_after(system, found.state, 0.2), 1e-9);
}

TEST(equilibrium, a_hanging_chain_is_the_funicular_polygon_and_nears_the_catenary) {
  constexpr int links = 40;
  constexpr double length = 2.0 / links, span = 1.2, mass = 0.1;
  SystemGraph graph;
  // Drawn as a V that closes: half the links down, half up.
  const double down = std::acos(span / 2);  // slope of each half, 1 m long
  Marker last = graph.ground().marker({0, 0, 0}, kAxisY);
  Vector3 end = Vector3::Zero();
  std::vector<const Body*> rods;
  for (int i = 0; i < links; ++i) {
    const double slope = i < links / 2 ? down : -down;  // turn about y takes x downwards
    const Matrix3 A = rotation_about({0, 1, 0}, slope);
    auto& rod = graph.add<RigidBody>("rod " + std::to_string(i), {.mass = mass,
                                                                  .inertia = {1e-4, 1e-4, 1e-4},
                                                                  .position = end + A * Vector3(length / 2, 0, 0),
                                                                  .orientation = A});
    graph.add<RevoluteJoint>("pin " + std::to_string(i), {last, rod.marker({-length / 2, 0, 0}, kAxisY)});
    last = rod.marker({length / 2, 0, 0}, kAxisY);
    end += A * Vector3(length, 0, 0);
    rods.push_back(&rod);
  }
  graph.add<RevoluteJoint>("pin", {last, graph.ground().marker({span, 0, 0}, kAxisY)});
  const System system = assemble(graph);
  EXPECT_EQ(system.redundant_rows().size(), 3u);
  const Equilibrium found = find_equilibrium(system, system.initial_state());
  EXPECT_LT(found.out_of_balance, 1e-9);

  // Rod i stands at the slope tan a_i = (weight between it and the lowest point)/H; H closes the span.
  const auto width = [&](double H) {
    double sum = 0;
    for (int i = 0; i < links; ++i) sum += length * std::cos(std::atan(mass * kGravity * (i - (links - 1) / 2.0) / H));
    return sum;
  };
  double low = 1e-3, high = 1e3;
  while (high - low > 1e-15 * high) (width(0.5 * (low + high)) < span ? low : high) = 0.5 * (low + high);
  Vector3 at = Vector3::Zero();
  for (int i = 0; i < links; ++i) {
    const double slope = std::atan(mass * kGravity * (i - (links - 1) / 2.0) / low);
    const Vector3 half = 0.5 * length * Vector3(std::cos(slope), 0, std::sin(slope));
    EXPECT_LT((found.state.q.segment<3>(7 * i) - (at + half)).norm(), 1e-10) << "rod " << i;
    at += 2 * half;
  }
  // The catenary of 2 m over the same span: sag c (cosh(D/2c) - 1) with 2 c sinh(D/2c) = 2.
  double c_low = 0.05, c_high = 10;
  while (c_high - c_low > 1e-14)
    (2 * 0.5 * (c_low + c_high) * std::sinh(span / (c_low + c_high)) > 2 ? c_low : c_high) = 0.5 * (c_low + c_high);
  const double sag = c_low * (std::cosh(span / (2 * c_low)) - 1);
  EXPECT_NEAR(-found.state.q[7 * (links / 2) + 2], sag, 3e-3 * sag);
  std::printf("chain: %d load steps, %d iterations, out of balance %.1e N\n", found.load_steps, found.iterations,
              found.out_of_balance);
}

TEST(equilibrium, a_chain_let_go_level_hangs_straight_down) {
  constexpr int links = 30;
  SystemGraph graph;
  Marker last = graph.ground().marker();
  for (int i = 0; i < links; ++i) {
    auto& rod =
        graph.add<RigidBody>("rod " + std::to_string(i),
                             {.mass = 0.1, .inertia = {1e-4, 1e-4, 1e-4}, .position = Vector3(0.1 * i + 0.05, 0, 0)});
    graph.add<SphericalJoint>("ball " + std::to_string(i), {last, rod.marker({-0.05, 0, 0})});
    last = rod.marker({0.05, 0, 0});
  }
  const System system = assemble(graph);
  const Equilibrium found = find_equilibrium(system, system.initial_state());
  for (int i = 0; i < links; ++i)
    EXPECT_LT((found.state.q.segment<3>(7 * i) - Vector3(0, 0, -0.1 * i - 0.05)).norm(), 1e-9) << "rod " << i;
  std::printf("level chain: %d load steps, %d iterations, out of balance %.1e N\n", found.load_steps, found.iterations,
              found.out_of_balance);
}

TEST(equilibrium, a_weight_on_three_springs_settles_where_they_carry_it) {
  // Long springs of natural length 1 from the corners of a triangle to one point: far from straight, all large motion.
  SystemGraph graph;
  const double k = 80, m = 4;
  auto& weight =
      graph.add<RigidBody>("weight", {.mass = m, .inertia = {0.01, 0.01, 0.01}, .position = Vector3(0.2, -0.1, 0.1)});
  for (int i = 0; i < 3; ++i) {
    const double angle = 2 * M_PI / 3 * i;
    graph.add<SpringDamper>("spring " + std::to_string(i),
                            {graph.ground().marker({std::cos(angle), std::sin(angle), 0}), weight.marker()},
                            {.stiffness = k, .damping = 3, .natural_length = 1});
  }
  const System system = assemble(graph);
  const Equilibrium found = find_equilibrium(system, system.initial_state());
  double low = 0, high = 10;  // 3 k (l - 1) z/l = m g, l = sqrt(1 + z²)
  while (high - low > 1e-15) {
    const double z = 0.5 * (low + high), l = std::hypot(1, z);
    (3 * k * (l - 1) * z / l < m * kGravity ? low : high) = z;
  }
  EXPECT_LT((found.state.q.head<3>() - Vector3(0, 0, -low)).norm(), 1e-10);
  EXPECT_LT(found.out_of_balance, 1e-11);
  // Its three turns are held by nothing; they stay as drawn.
  EXPECT_LT((found.state.q.segment<4>(3) - system.initial_state().q.segment<4>(3)).norm(), 1e-12);
}

TEST(equilibrium, a_cantilever_sags_as_stiffness_and_weight_say_with_modes_and_with_all_nodes) {
  const FiniteElementModel model = test::pendulum_model("hex8i");
  // Independent: K u = M g with the root face held.
  const int n = static_cast<int>(model.nodes.cols());
  std::vector<char> held(3 * n, 0);
  for (int id : model.node_set("root_face"))
    for (int axis = 0; axis < 3; ++axis) held[3 * model.node_index(id) + axis] = 1;
  std::vector<int> kept;
  for (int i = 0; i < 3 * n; ++i)
    if (!held[i]) kept.push_back(i);
  const MatrixX K_all = MatrixX(model.stiffness);
  VectorX fall = VectorX::Zero(3 * n);
  for (int i = 0; i < n; ++i) fall[3 * i + 2] = -kGravity;
  const VectorX weight = model.mass * fall;
  const int free = static_cast<int>(kept.size());
  MatrixX K(free, free);
  VectorX f(free);
  for (int i = 0; i < free; ++i) {
    f[i] = weight[kept[i]];
    for (int j = 0; j < free; ++j) K(i, j) = K_all(kept[i], kept[j]);
  }
  const VectorX u = test::solve_positive(K, f);
  const int tip = model.node_set("tip").front();
  double expected = 0;
  for (int i = 0; i < free; ++i)
    if (kept[i] == 3 * model.node_index(tip) + 2) expected = u[i];

  for (int modes : {kAllNodal, 40, 4}) {
    SystemGraph graph;
    auto& beam = graph.add<FlexibleBody>("beam", {.basis = make_basis(model, test::frame_of(model, "clamp"), modes)});
    graph.add<FixedJoint>("clamp", {graph.ground().marker(beam.basis().origin), beam.frame()});
    const Marker end = beam.node(tip);
    const System system = assemble(graph);
    const Equilibrium found = find_equilibrium(system, system.initial_state());
    Snapshot now(system, found.state), before(system, system.initial_state());
    const double sag = now.marker(end).p.z() - before.marker(end).p.z();
    const double allowed = modes == kAllNodal ? 1e-9 : modes == 40 ? 1e-6 : 2e-2;
    EXPECT_NEAR(sag, expected, allowed * std::abs(expected)) << modes << " modes";
    EXPECT_LT(found.out_of_balance, 1e-9);
    std::printf("cantilever, %d modes: %.9g m (%.9g), %d load steps, %d iterations, out of balance %.1e N\n", modes,
                sag, expected, found.load_steps, found.iterations, found.out_of_balance);
    EXPECT_LT(speed_after(system, found.state, 0.02), modes == kAllNodal ? 1e-6 : 1e-8);
  }
}

TEST(equilibrium, a_flexible_pendulum_hangs_still) {
  const FiniteElementModel model = test::pendulum_model("hex8i");
  SystemGraph graph;
  auto& rod = graph.add<FlexibleBody>(
      "rod", {.basis = make_basis(model, test::frame_of(model, "clamp"), 8), .damping = {.modal_ratios = {0.02}}});
  const std::vector<int>& edge = model.node_set("hinge");
  Vector3 middle = Vector3::Zero();
  for (int id : edge) middle += model.nodes.col(model.node_index(id)) / static_cast<double>(edge.size());
  graph.add<RevoluteJoint>("hinge", {graph.ground().marker(middle, kAxisY), rod.average(edge, kAxisY)});
  const System system = assemble(graph);
  const Equilibrium found = find_equilibrium(system, system.initial_state());
  EXPECT_LT(found.out_of_balance, 1e-10);
  EXPECT_LT(speed_after(system, found.state, 0.5), 1e-8);
  Snapshot now(system, found.state);
  // The hinge bears the weight.
  EXPECT_NEAR(reaction(*graph.constraints()[0].constraint, 1).value(now, 2), rod.mass() * kGravity, 1e-9);
  std::printf("flexible pendulum: %d load steps, %d iterations\n", found.load_steps, found.iterations);
}

TEST(equilibrium, a_nodal_flexible_pendulum_pinned_at_three_nodes_hangs_still) {
  const FiniteElementModel model = test::pendulum_model("hex8i");
  SystemGraph graph;
  auto& rod = graph.add<FlexibleBody>("rod", {.basis = make_basis(model, test::frame_of(model, "frameB"), kAllNodal)});
  for (int id : model.node_set("hinge"))
    graph.add<SphericalJoint>("hinge " + std::to_string(id),
                              {graph.ground().marker(model.nodes.col(model.node_index(id))), rod.node(id)});
  const System system = assemble(graph);
  const Equilibrium found = find_equilibrium(system, system.initial_state());
  EXPECT_LT(found.out_of_balance, 1e-9);
  EXPECT_LT(speed_after(system, found.state, 0.05), 1e-6);
  Snapshot now(system, found.state);
  EXPECT_LT(now.marker(rod.node(model.node_set("tip").front())).p.z(), -0.09);
  std::printf("nodal pendulum: %d load steps, %d iterations, out of balance %.1e N\n", found.load_steps,
              found.iterations, found.out_of_balance);
}

TEST(equilibrium, a_drive_is_held_where_it_is_at_the_start_and_bears_the_weight) {
  Pendulum scene(0.5 * M_PI);
  auto& drive = scene.graph.add<CoordinateDrive>("motor", {scene.pin->angle()}, {.motion = [](double t) {
                                                   return Motion{0.5 * M_PI + 0.3 * t, 0.3, 0};
                                                 }});
  const System system = assemble(scene.graph);
  const Equilibrium found = find_equilibrium(system, system.initial_state());
  EXPECT_NEAR(found.state.q[2], 0, 1e-12);
  EXPECT_NEAR(std::abs(found.state.lambda[system.rows(drive).first]), 2 * kGravity * 0.5, 1e-9);
}

/// Three arms on a hub that a drive holds: nothing can move, and reactions alone are to be found.
TEST(equilibrium, what_joints_hold_altogether_is_at_rest_where_it_is) {
  SystemGraph graph;
  auto& hub = graph.add<RigidBody>("hub", {.mass = 56780, .inertia = {115926, 80000, 80000}});
  const Matrix3 shaft = rotation_about({0, 1, 0}, M_PI / 2);
  auto& pin = graph.add<RevoluteJoint>("pin", {graph.ground().marker({}, shaft), hub.marker({}, shaft)});
  auto& drive = graph.add<CoordinateDrive>("drive", {pin.angle()}, {.motion = constant(0)});
  const double mass[] = {16000, 17000, 19000};
  double moment = 0;  // about x
  for (int k = 0; k < 3; ++k) {
    const Matrix3 axes = rotation_about({1, 0, 0}, 2 * M_PI * k / 3);
    const Vector3 root = axes * Vector3(0, 0, 1.5), center = axes * Vector3(0, 0, 22);
    auto& arm =
        graph.add<RigidBody>("arm " + std::to_string(k),
                             {.mass = mass[k], .inertia = {1e7, 1e7, 2e4}, .position = center, .orientation = axes});
    graph.add<FixedJoint>("root " + std::to_string(k), {hub.marker(root, axes), arm.marker({0, 0, -20.5})});
    moment -= mass[k] * kGravity * center.y();
  }
  const System system = assemble(graph);
  const Equilibrium found = find_equilibrium(system, system.initial_state());
  EXPECT_LE(found.iterations, 3);
  EXPECT_LT((found.state.q - system.initial_state().q).lpNorm<Eigen::Infinity>(), 1e-12);
  EXPECT_NEAR(std::abs(found.state.lambda[system.rows(drive).first]), std::abs(moment), 1e-9 * std::abs(moment));
}

TEST(equilibrium, a_body_that_nothing_holds_is_named) {
  SystemGraph graph;
  graph.add<RigidBody>("stone", {.mass = 1, .inertia = {1, 1, 1}});
  const System system = assemble(graph);
  EXPECT_THAT(message_of<SimulationError>([&] { find_equilibrium(system, system.initial_state()); }),
              HasSubstr("stone: p_z"));
}

}  // namespace lithe::test::equilibrium_test
