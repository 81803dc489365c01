#include <gtest/gtest.h>

#include <atomic>

#include "bodies/flexible/flexible_body.h"
#include "bodies/rigid_body.h"
#include "engine/assembly/evaluator.h"
#include "engine/base/error.h"
#include "engine/base/thread_team.h"
#include "engine/factor/branches.h"
#include "joints/forces/point_force.h"
#include "joints/forces/spring_damper.h"
#include "joints/revolute_joint.h"
#include "joints/spherical_joint.h"
#include "tests/integrators/restart_scenes.h"
#include "tests/support/linear_algebra.h"
#include "tests/support/message_of.h"
#include "tests/support/methods.h"
#include "tests/support/motion.h"

/// Threads within one scene: parts of it, and branches of its factor.
namespace lithe::test::threads_test {
namespace {

using Draw = std::function<void(SystemGraph&)>;

RigidBody& add_rod(SystemGraph& graph, const Vector3& middle) {
  return graph.add<RigidBody>("rod " + std::to_string(graph.bodies().size()),
                              {.mass = 1, .inertia = {1e-3, 1.0 / 12, 1.0 / 12}, .position = middle});
}

/// Rods in a row, each on the one before.
template <class Joint>
void draw_row(SystemGraph& graph, int count, const Vector3& from, const Marker& at) {
  Marker end = at;
  for (int i = 0; i < count; ++i) {
    auto& rod = add_rod(graph, from + Vector3(i + 0.5, 0, 0));
    graph.add<Joint>("joint " + std::to_string(graph.constraints().size()),
                     {end, rod.marker({-0.5, 0, 0}, restart::kAxisY)});
    end = rod.marker({0.5, 0, 0}, restart::kAxisY);
  }
}

void draw_chain(SystemGraph& graph) { draw_row<SphericalJoint>(graph, 1600, Vector3::Zero(), graph.ground().marker()); }
void draw_hinges(SystemGraph& graph) {
  draw_row<RevoluteJoint>(graph, 1600, Vector3::Zero(), graph.ground().marker({0, 0, 0}, restart::kAxisY));
}
/// A hub with many arms, far ends tied by springs across parts, a force on one.
void draw_star(SystemGraph& graph) {
  auto& hub = add_rod(graph, {0, 0, 0});
  graph.add<SphericalJoint>("pivot", {graph.ground().marker(), hub.marker()});
  std::vector<Marker> ends;
  for (int arm = 0; arm < 12; ++arm) {
    const Vector3 from(0.5, 0, arm);
    draw_row<SphericalJoint>(graph, 30, from, hub.marker(from));
    ends.push_back(graph.constraints().back().markers[1]);
  }
  for (std::size_t i = 1; i < ends.size(); ++i)
    graph.add<SpringDamper>("spring " + std::to_string(i), {ends[i - 1], ends[i]},
                            {.stiffness = 100, .damping = 1, .natural_length = 0.9});
  graph.add<PointForce>("wind", {ends[3]}, {.force = {0, 3, 1}});
}
/// Pendulums of three rods that do not know each other: there are branches and no trunk.
void draw_pendulums(SystemGraph& graph) {
  for (int i = 0; i < 100; ++i)
    draw_row<RevoluteJoint>(graph, 3, {0, 1.0 * i, 0}, graph.ground().marker({0, 1.0 * i, 0}, restart::kAxisY));
}
/// Two rows of rods with rungs: loops everywhere.
void draw_ladder(SystemGraph& graph) {
  Marker ends[2] = {graph.ground().marker({0, 0, 0}), graph.ground().marker({0, 1, 0})};
  for (int i = 0; i < 60; ++i) {
    for (int side : {0, 1}) {
      auto& rod = add_rod(graph, {i + 0.5, 1.0 * side, 0});
      graph.add<SphericalJoint>("joint " + std::to_string(graph.constraints().size()),
                                {ends[side], rod.marker({-0.5, 0, 0})});
      ends[side] = rod.marker({0.5, 0, 0});
    }
    auto& rung = add_rod(graph, {i + 1.0, 0.5, 0});
    for (int side : {0, 1})
      graph.add<SphericalJoint>("joint " + std::to_string(graph.constraints().size()),
                                {ends[side], rung.marker({0, side - 0.5, 0})});
  }
}
/// Soft rods in a row, each at the far corner of the one before.
void draw_flexible(SystemGraph& graph) {
  const auto modes = restart::rod_modes();
  Marker end = graph.ground().marker();
  for (int i = 0; i < 220; ++i) {
    auto& rod =
        graph.add<FlexibleBody>("rod " + std::to_string(i), {.basis = modes, .position = i * Vector3(0.4, 0.02, 0.02)});
    graph.add<SphericalJoint>("joint " + std::to_string(i), {end, rod.node(1)});
    end = rod.node(20);
  }
}

struct Scene {
  SystemGraph graph{{.gravity = {0, 0.3, -9.81}}};
  System system;
  Scene(const Draw& draw, int threads) : system(drawn(draw, threads)) {}

 private:
  System drawn(const Draw& draw, int threads) {
    draw(graph);
    return assemble(graph, {.forward_dynamics = false, .threads = threads});
  }
};

State end_state(const Draw& draw, const std::function<Method()>& make, int threads) {
  const Scene scene(draw, threads);
  EXPECT_GT(scene.system.parts().size(), 1u);
  State state = scene.system.initial_state();
  const Method method = make();
  Evaluator evaluator(scene.system);
  method->start(evaluator, state);
  for (int i = 0; i < 8; ++i) {
    const StepResult result = method->step(evaluator, state, 1);
    EXPECT_TRUE(result.ok()) << result.why;
  }
  return state;
}

void expect_same_bits(const Draw& draw, const std::function<Method()>& make) {
  const State alone = end_state(draw, make, 1);
  ASSERT_GT((alone.v).norm(), 1e-3);  // it moves
  for (int threads : {2, 3}) {
    const State shared = end_state(draw, make, threads);
    EXPECT_EQ(shared.time, alone.time) << threads;
    EXPECT_TRUE(shared.q == alone.q && shared.v == alone.v) << threads;
    EXPECT_TRUE(shared.v_dot == alone.v_dot && shared.lambda == alone.lambda) << threads;
  }
}

struct Drawn {
  const char* name;
  Draw draw;
};
void PrintTo(const Drawn& drawn, std::ostream* out) { *out << drawn.name; }

class Threads : public testing::TestWithParam<Drawn> {};

TEST_P(Threads, share_a_scene_and_leave_its_bits_by_generalized_alpha) {
  expect_same_bits(GetParam().draw, [] { return index3(1e-3); });
}
TEST_P(Threads, share_a_scene_and_leave_its_bits_by_radau) {
  expect_same_bits(GetParam().draw, [] { return radau_fixed(1e-3); });
}
TEST_P(Threads, share_a_scene_and_leave_its_bits_by_bdf) {
  expect_same_bits(GetParam().draw, [] { return bdf(1e-6); });
}

/// [S Gᵀ; G -C] x = r by the blocks themselves.
TEST_P(Threads, solve_what_the_blocks_say) {
  const Scene scene(GetParam().draw, 2);
  const Layout& layout = scene.system.layout();
  RandomNumbers random(4);
  Evaluator evaluator(scene.system);
  const int n = layout.v_count(), rows = layout.row_count();
  VectorX q(layout.q_count());
  layout.retract(scene.system.initial_state().q, random.vector(n, 0.02), q);
  for (const TangentWeights weights : {TangentWeights{0, 0, 1}, TangentWeights{1, 20, 400}}) {
    evaluator.evaluate(0, q, random.vector(n), Level::velocity);
    evaluator.factorize(weights, random.vector(n), random.vector(rows), nullptr);
    const VectorX rv = random.vector(n), rl = random.vector(rows);
    VectorX x = rv, y = rl;
    evaluator.solve(x, y);
    // What compliant rows take is eliminated: tensions follow from their own rows.
    const int compliant = scene.system.blocks().row_count - rows;
    VectorX z = VectorX::Zero(compliant), C = VectorX::Zero(compliant), left = VectorX::Zero(n + rows + compliant);
    evaluator.visit_blocks([&](int row, int column, ConstMatrixRef block) {
      if (row >= n + rows && column < n)
        z.segment(row - n - rows, block.rows()) += block * x.segment(column, block.cols());
      if (row >= n + rows && row == column) C[row - n - rows] = block(0, 0);
    });
    z = -z.cwiseQuotient(C);
    VectorX all(n + rows + compliant);
    all << x, y, z;
    evaluator.visit_blocks([&](int row, int column, ConstMatrixRef block) {
      left.segment(row, block.rows()) += block * all.segment(column, block.cols());
    });
    EXPECT_LT((left.head(n) - rv).norm(), 1e-9 * rv.norm());
    EXPECT_LT((left.segment(n, rows) - rl).norm(), 1e-9 * rl.norm());
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, Threads,
                         testing::Values(Drawn{"chain", draw_chain}, Drawn{"hinges", draw_hinges},
                                         Drawn{"star", draw_star}, Drawn{"ladder", draw_ladder},
                                         Drawn{"flexible", draw_flexible}, Drawn{"pendulums", draw_pendulums}),
                         [](const auto& info) { return std::string(info.param.name); });

/// Three laws fail; what is told is the first in the scene, whoever comes to it first.
TEST(Threads, tell_the_first_failure_of_a_scene) {
  static std::atomic<bool> fails{false};
  const auto message = [](int threads) {
    const Scene scene(
        [](SystemGraph& graph) {
          draw_chain(graph);
          for (int i : {200, 900, 1500})
            graph.add<SpringDamper>("spring " + std::to_string(i),
                                    {graph.constraints()[i - 1].markers[1], graph.constraints()[i].markers[1]},
                                    {.law = TensionLaw([i](double, double) -> Tension {
                                       if (fails) throw std::runtime_error("spring " + std::to_string(i) + " broke");
                                       return {.force = 1};
                                     })});
        },
        threads);
    Evaluator evaluator(scene.system);
    const State& start = scene.system.initial_state();
    fails = true;
    const std::string text = message_of<Error>([&] { evaluator.evaluate(0, start.q, start.v, Level::velocity); });
    fails = false;
    return text;
  };
  const std::string alone = message(1);
  EXPECT_NE(alone.find("spring 200 broke"), std::string::npos) << alone;
  for (int i = 0; i < 10; ++i) EXPECT_EQ(message(3), alone);
}

/// The elimination of a row of balls: it may begin at both ends, and then the middle goes last.
TEST(Branches, of_a_long_chain_are_its_halves) {
  constexpr int kCount = 1000;
  Topology chain{kCount, {}};
  for (int i = 0; i < kCount; ++i) chain.ties.push_back({i - 1, i});
  std::vector<int> dimensions(kCount, 6);
  dimensions.resize(2 * kCount, 3);
  const std::vector<int> last = centres(chain, dimensions);
  ASSERT_EQ(last.size(), 1u);
  EXPECT_NEAR(last[0], kCount / 2, 1);
  Elimination elimination = plan_elimination(chain, dimensions, {}, {}, last);
  const std::vector<int> ends = gather_branches(elimination, std::vector<double>(2 * kCount, 500));
  ASSERT_EQ(ends.size(), 2u);
  EXPECT_NEAR(ends[0], kCount, 5);
  EXPECT_NEAR(ends[1], 2 * kCount, 10);
  // No vertex of a branch knows one of the other.
  std::vector<int> branch(2 * kCount, 2);
  for (int i = 0; i < ends[1]; ++i) branch[elimination.order[i]] = i < ends[0] ? 0 : 1;
  for (int v = 0; v < 2 * kCount; ++v)
    for (int w : elimination.neighbours[v])
      if (branch[v] < 2) EXPECT_TRUE(branch[w] == branch[v] || branch[w] == 2);
}

TEST(Branches, are_not_made_where_there_is_little_to_do) {
  Topology chain{8, {}};
  for (int i = 0; i < 8; ++i) chain.ties.push_back({i - 1, i});
  EXPECT_TRUE(centres(chain, std::vector<int>(16, 6)).empty());
  Elimination elimination = plan_elimination(chain, std::vector<int>(16, 6), {});
  const auto order = elimination.order;
  EXPECT_TRUE(gather_branches(elimination, std::vector<double>(16, 500)).empty());
  EXPECT_EQ(elimination.order, order);
}

TEST(ThreadTeam, does_each_job_once_where_threads_come_late) {
  ThreadTeam team(9);  // more than there are processors, as a rule: some come when a call is over
  std::vector<int> done(5, 0);
  for (int round = 1; round <= 20000; ++round) {
    team.run(5, [&](int i) { done[i] = done[i] == round - 1 ? round : -1; });
    if (done != std::vector<int>(5, round)) FAIL() << "round " << round;
  }
}

TEST(ThreadTeam, tells_the_first_of_what_its_jobs_throw) {
  ThreadTeam team(3);
  for (int round = 0; round < 200; ++round) {
    std::vector<int> done(40, 0);
    try {
      team.run(40, [&](int i) {
        done[i] = 1;
        if (i % 10 == 7) throw std::runtime_error(std::to_string(i));
      });
      ADD_FAILURE();
    } catch (const std::runtime_error& error) {
      EXPECT_STREQ(error.what(), "7");
    }
    team.run(40, [&](int i) { done[i] = 2; });
    EXPECT_EQ(done, std::vector<int>(40, 2));
  }
}

}  // namespace
}  // namespace lithe::test::threads_test
