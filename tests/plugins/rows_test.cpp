// What is loaded is what would have been compiled in, bit by bit.
#include <gtest/gtest.h>

#include <cstring>

#include "bodies/rigid_body.h"
#include "engine/assembly/batch_of.h"
#include "engine/assembly/evaluator.h"
#include "plugins/cam_follower/cam_follower.cpp"
#include "plugins/massless_rod/massless_rod.cpp"
#include "tests/plugins/kinds/bungee.cpp"
#include "tests/plugins/kinds/hinge.cpp"
#include "tests/plugins/plugins.h"
#include "tests/support/joint_checks.h"
#include "tests/support/motion.h"

namespace lithe::test::rows_test {
namespace {

bool same_bits(double a, double b) { return std::memcmp(&a, &b, sizeof a) == 0; }
bool same_bits(const Wrench& a, const Wrench& b) {
  for (int i = 0; i < 3; ++i)
    if (!same_bits(a.force[i], b.force[i]) || !same_bits(a.torque[i], b.torque[i])) return false;
  return true;
}

/// Two markers anywhere, moving anyhow; the second at some 2 m from the first.
struct RandomMarkers {
  MarkerKinematics kinematics[2];
  explicit RandomMarkers(RandomNumbers& random) {
    for (MarkerKinematics& k : kinematics) {
      k.p = random.vector3(3);
      k.R = random.rotation();
      k.v = random.vector3(2);
      k.w = random.vector3(4);
    }
    const Vector3 offset(2 + random.number(0.4), random.number(1), random.number(1));
    kinematics[1].p = kinematics[0].p + kinematics[0].R * offset;
  }
};

/// Rows and stiffness under load, of 1000 random states.
void expect_same_rows(const Constraint& compiled, const Constraint& loaded) {
  RandomNumbers random(3);
  for (int i = 0; i < 1000; ++i) {
    const RandomMarkers m(random);
    const double time = random.number(), multipliers[5] = {1.5, random.number(9), -3, random.number(9), 7};
    ConstraintRows rows[2] = {ConstraintRows(2), ConstraintRows(2)};
    ConstraintRows::Stiffness K[2];
    for (const bool loaded_too : {false, true}) {
      K[loaded_too].setZero(12, 12);
      if (i % 2) rows[loaded_too].collect_stiffness(multipliers, &K[loaded_too]);
      (loaded_too ? loaded : compiled).evaluate(time, connector::Views(m.kinematics, 2), rows[loaded_too]);
    }
    ASSERT_EQ(rows[0].count(), rows[1].count());
    ASSERT_EQ(rows[0].written(), rows[1].written());
    for (int r = 0; r < rows[0].count(); ++r) {
      ASSERT_TRUE(same_bits(rows[0].residual(r), rows[1].residual(r))) << "residual";
      ASSERT_TRUE(same_bits(rows[0].bias(r), rows[1].bias(r))) << "bias";
      ASSERT_TRUE(same_bits(rows[0].rate(r), rows[1].rate(r))) << "rate";
      for (int k = 0; k < 2; ++k) ASSERT_TRUE(same_bits(rows[0].wrench(r, k), rows[1].wrench(r, k))) << "wrench";
    }
    ASSERT_EQ(0, std::memcmp(K[0].data(), K[1].data(), sizeof(double) * K[0].size())) << "stiffness";
  }
}

/// Two rigid bodies, and what ties them, drawn by `tie(graph, A, B)`.
struct TwoBodies {
  SystemGraph graph;
  RigidBody& a = graph.add<RigidBody>("a", {.mass = 2, .inertia = {1, 2, 2.5}, .position = {0.1, 0.2, -0.3}});
  RigidBody& b = graph.add<RigidBody>("b", {.mass = 1, .inertia = {0.3, 0.4, 0.5}, .position = {2.3, 0.4, 0.2}});
  std::vector<Marker> ends{a.marker({0.1, 0, 0.2}, rotation_about({1, 2, 0}, 0.3)),
                           b.marker({0, 0.2, 0}, rotation_about({0, 1, 1}, 0.4))};
};

/// Everything that an integrator sees of two scenes, at random states.
void expect_same_equations(SystemGraph& compiled, SystemGraph& loaded) {
  const System systems[2] = {assemble(compiled, {.start = AssembleOptions::Start::as_drawn}),
                             assemble(loaded, {.start = AssembleOptions::Start::as_drawn})};
  Evaluator evaluators[2] = {Evaluator(systems[0]), Evaluator(systems[1])};
  const Layout& layout = systems[0].layout();
  RandomNumbers random(5);
  for (int i = 0; i < 50; ++i) {
    VectorX q = systems[0].initial_state().q, v = random.vector(layout.v_count(), 2);
    layout.retract(q, random.vector(layout.v_count(), 0.4), q);
    const VectorX v_dot = random.vector(layout.v_count(), 3), lambda = random.vector(layout.row_count(), 5);
    VectorX results[2];
    for (int k : {0, 1}) {
      std::vector<double> all;
      const auto keep = [&](const auto& x) { all.insert(all.end(), x.data(), x.data() + x.size()); };
      evaluators[k].evaluate(0.7, q, v, Level::acceleration);
      VectorX r = VectorX::Zero(layout.v_count()), rows(layout.row_count());
      evaluators[k].residual(v_dot, lambda, r);
      keep(r);
      for (Level level : {Level::position, Level::velocity, Level::acceleration}) {
        evaluators[k].constraint(level, rows);
        keep(rows);
      }
      evaluators[k].factorize({1, 10, 100}, v_dot, lambda, nullptr);
      evaluators[k].visit_blocks([&](int, int, ConstMatrixRef block) { keep(MatrixX(block)); });
      keep(evaluators[k].workspace().tension);
      keep(evaluators[k].workspace().force_energy);
      results[k] = Eigen::Map<VectorX>(all.data(), static_cast<Eigen::Index>(all.size()));
    }
    // By value: zeros of rows that hold a point have signs of their own (engine/assembly/connector_blocks.h).
    ASSERT_EQ(results[0], results[1]) << "largest difference " << (results[0] - results[1]).cwiseAbs().maxCoeff();
  }
}

TEST(RowsFromC, of_a_written_joint_are_those_compiled_in_bit_by_bit) {
  Registry registry;
  registry.load_plugin(shipped("massless_rod"));
  expect_same_rows(MasslessRod({.length = 1.9}), JointFromC({&registry.joint("massless_rod"), {{"length", 1.9}}}));
  TwoBodies compiled, loaded;
  compiled.graph.add<MasslessRod>("rod", compiled.ends, {.length = 1.9});
  loaded.graph.add(registry.joint("massless_rod"), "rod", loaded.ends, {{"length", 1.9}});
  expect_same_equations(compiled.graph, loaded.graph);
}

TEST(RowsFromC, of_a_cam_are_those_compiled_in_bit_by_bit) {
  Registry registry;
  registry.load_plugin(shipped("cam_follower"));
  expect_same_rows(CamFollower({.profile = egg(), .roller_radius = 0.1}),
                   JointFromC({&registry.joint("cam_follower"), {{"profile", egg()}, {"roller_radius", 0.1}}}));
  TwoBodies compiled, loaded;
  compiled.graph.add<CamFollower>("cam", compiled.ends, {.profile = egg()});
  loaded.graph.add(registry.joint("cam_follower"), "cam", loaded.ends, {{"profile", egg()}});
  expect_same_equations(compiled.graph, loaded.graph);
}

TEST(RowsFromC, of_a_composed_joint_are_those_compiled_in_with_their_stiffness) {
  Registry registry;
  registry.load_plugin(library("hinge"));
  expect_same_rows(Hinge(), JointFromC({&registry.joint("hinge")}));
  TwoBodies compiled, loaded;
  compiled.graph.add<Hinge>("pin", compiled.ends);
  loaded.graph.add(registry.joint("hinge"), "pin", loaded.ends);
  expect_same_equations(compiled.graph, loaded.graph);
}

/// Its templates are contracted to fused products by what stands around them: to round-off.
TEST(RowsFromC, of_a_joint_by_its_residual_are_those_composed_with_their_stiffness) {
  Registry registry;
  registry.load_plugin(library("derived_hinge"));
  const JointFromC loaded({&registry.joint("derived_hinge")});
  const Hinge composed;
  RandomNumbers random(6);
  for (int i = 0; i < 200; ++i) {
    const RandomMarkers m(random);
    const double multipliers[5] = {1.5, random.number(9), -3, random.number(9), 7};
    ConstraintRows rows[2] = {ConstraintRows(2), ConstraintRows(2)};
    ConstraintRows::Stiffness K[2];
    for (int k : {0, 1}) {
      K[k].setZero(12, 12);
      rows[k].collect_stiffness(multipliers, &K[k]);
    }
    loaded.evaluate(0, connector::Views(m.kinematics, 2), rows[0]);
    composed.evaluate(0, connector::Views(m.kinematics, 2), rows[1]);
    for (int r = 0; r < 5; ++r) {
      EXPECT_NEAR(rows[0].residual(r), rows[1].residual(r), 1e-13);
      EXPECT_NEAR(rows[0].bias(r), rows[1].bias(r), 1e-11);
      for (int k : {0, 1}) {
        EXPECT_LT((rows[0].wrench(r, k).force - rows[1].wrench(r, k).force).norm(), 1e-13);
        EXPECT_LT((rows[0].wrench(r, k).torque - rows[1].wrench(r, k).torque).norm(), 1e-13);
      }
    }
    EXPECT_LT((K[0] - K[1]).norm(), 1e-12);
  }
}

TEST(RowsFromC, of_a_force_are_those_compiled_in_bit_by_bit) {
  Registry registry;
  registry.load_plugin(library("bungee"));
  const ForceFromC loaded_force(
      {&registry.force("bungee"), {{"stiffness", 30}, {"damping", 2.5}, {"natural_length", 2.1}, {"drag", 0.7}}});
  const Bungee compiled_force({.stiffness = 30, .damping = 2.5, .natural_length = 2.1, .drag = 0.7});
  RandomNumbers random(4);
  for (int i = 0; i < 1000; ++i) {
    const RandomMarkers m(random);
    ForceRows a(2), b(2);
    compiled_force.evaluate(0.1, connector::Views(m.kinematics, 2), a);
    loaded_force.evaluate(0.1, connector::Views(m.kinematics, 2), b);
    ASSERT_EQ(a.count(), b.count());
    ASSERT_TRUE(same_bits(a.tension(0), b.tension(0)) && same_bits(a.stiffness(0), b.stiffness(0)) &&
                same_bits(a.damping(0), b.damping(0)) && same_bits(a.energy(), b.energy()));
    for (int k = 0; k < 2; ++k)
      ASSERT_TRUE(same_bits(a.wrench(0, k), b.wrench(0, k)) && same_bits(a.load(k), b.load(k)));
  }
  TwoBodies compiled, loaded;
  compiled.graph.add<Bungee>("rope", compiled.ends, {.stiffness = 30, .damping = 2.5, .drag = 0.7});
  loaded.graph.add(registry.force("bungee"), "rope", loaded.ends, {{"stiffness", 30}, {"damping", 2.5}, {"drag", 0.7}});
  expect_same_equations(compiled.graph, loaded.graph);
}

TEST(RowsFromC, of_a_class_registered_by_name_are_those_of_the_class) {
  Registry registry;
  registry.add<MasslessRod>("rod");
  expect_same_rows(MasslessRod({.length = 1.9}), JointFromC({&registry.joint("rod"), {{"length", 1.9}}}));
}

TEST(PluginChecks, massless_rod_passes_those_of_a_joint_compiled_in_and_loaded) {
  Registry registry;
  registry.load_plugin(shipped("massless_rod"));
  TwoBodies compiled, loaded;
  check_joint(compiled.graph, compiled.graph.add<MasslessRod>("rod", compiled.ends, {.length = 2.2}), {.rank = 1});
  check_joint(loaded.graph, loaded.graph.add(registry.joint("massless_rod"), "rod", loaded.ends, {{"length", 2.2}}),
              {.rank = 1});
}

TEST(PluginChecks, cam_follower_passes_those_of_a_joint_compiled_in_and_loaded) {
  Registry registry;
  registry.load_plugin(shipped("cam_follower"));
  TwoBodies compiled, loaded;
  check_joint(compiled.graph, compiled.graph.add<CamFollower>("cam", compiled.ends, {egg(), 0.15}), {.rank = 1});
  check_joint(loaded.graph,
              loaded.graph.add(registry.joint("cam_follower"), "cam", loaded.ends,
                               {{"profile", egg()}, {"roller_radius", 0.15}}),
              {.rank = 1});
}

TEST(PluginChecks, composed_hinge_passes_those_of_a_joint_loaded) {
  Registry registry;
  registry.load_plugin(library("hinge"));
  TwoBodies scene;
  check_joint(scene.graph, scene.graph.add(registry.joint("hinge"), "pin", scene.ends), {.rank = 5});
}

TEST(PluginChecks, rope_passes_those_of_a_force_loaded) {
  Registry registry;
  registry.load_plugin(library("bungee"));
  SystemGraph graph;  // balls: bodies without gyroscopic terms, which are none of the force's
  auto& a = graph.add<RigidBody>("a", {.inertia = {1, 1, 1}, .position = {0.1, 0.2, -0.3}});
  auto& b = graph.add<RigidBody>("b", {.inertia = {0.4, 0.4, 0.4}, .position = {2.3, 0.4, 0.2}});
  check_force(graph, graph.add(registry.force("bungee"), "rope", {a.marker({0.1, 0, 0.2}), b.marker({0, 0.2, 0})},
                               {{"damping", 1.5}, {"natural_length", 0.5}, {"slack", false}}));
}

}  // namespace
}  // namespace lithe::test::rows_test
