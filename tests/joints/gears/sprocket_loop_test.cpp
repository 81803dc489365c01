#include "joints/gears/sprocket_loop.h"

#include <gtest/gtest.h>

#include "engine/assembly/evaluator.h"
#include "joints/gears/sprocket_pair.h"
#include "tests/joints/mechanisms.h"
#include "tests/support/joint_checks.h"
#include "tests/support/message_of.h"
#include "tests/support/pairs.h"

/// Chains and belts around several sprockets.
namespace lithe::test::sprocket_loop_test {
namespace {

TEST(SprocketRun, PullsByWhatItsPotentialLosesOnAllBodies) {
  for (const int sense_B : {1, -1})
    for (const bool polygon : {true, false})
      for (const Pair& pair : pairs()) {
        SCOPED_TRACE(pair.name + (polygon ? " chain" : " belt") + (sense_B > 0 ? "" : " crossed"));
        SystemGraph graph{{.gravity = Vector3::Zero()}};
        const std::vector<Marker> markers = pair.draw(graph, {12, 9, 0});
        check_force(graph,
                    graph.add<SprocketRun>("run", markers,
                                           SprocketRun::Parameters{.teeth_A = 9,
                                                                   .teeth_B = 15,
                                                                   .sense_B = sense_B,
                                                                   .chain = {.pitch = 2,
                                                                             .axial_stiffness = 100,
                                                                             .damping = 0.5,
                                                                             .pretension = 40,
                                                                             .polygon = polygon}}),
                    {.tolerance = 1e-6, .difference = 2e-5});
      }
}

/// Wheels of a loop in the plane, as drawn and as moved.
struct Wheel {
  Vector3 center;
  int teeth, sense = 1;
  double turned = 0;  // rad
};
constexpr double kPitch = 10e-3, kStiffness = 1e6, kTension = 2e4;

struct Loop {
  Loop(const std::vector<Wheel>& wheels, bool polygon) {
    std::vector<SprocketWheel> loop;
    for (std::size_t i = 0; i < wheels.size(); ++i) {
      auto& body = graph.add<RigidBody>("wheel " + std::to_string(i), {.position = wheels[i].center});
      loop.push_back({body.marker(), wheels[i].teeth, wheels[i].sense});
    }
    add_sprocket_loop(graph, "chain", loop,
                      {.pitch = kPitch, .axial_stiffness = kStiffness, .pretension = kTension, .polygon = polygon});
  }
  /// Of all runs, with the wheels where they are now.
  static VectorX tensions(const System& system, const std::vector<Wheel>& drawn, const std::vector<Wheel>& now) {
    State state = system.initial_state();
    VectorX move = VectorX::Zero(system.layout().v_count());
    for (std::size_t i = 0; i < now.size(); ++i) {
      move.segment<3>(6 * static_cast<Eigen::Index>(i)) = now[i].center - drawn[i].center;
      move[6 * static_cast<Eigen::Index>(i) + 5] = now[i].turned;
    }
    system.layout().retract(system.initial_state().q, move, state.q);
    Evaluator evaluator(system);
    evaluator.evaluate(0, state.q, 0 * move, Level::velocity);
    return evaluator.workspace().tension;
  }
  SystemGraph graph{{.gravity = {0, 0, 0}}};
};

/// Of a taut belt around wheels of signed radii ρ: with its direction at the angle θ, that of the line of centres at δ,
/// sin(θ - δ) = (ρ_A - ρ_B) / d on each straight part; arcs r Δθ between.
struct Taut {
  std::vector<double> straights;
  double length = 0;
  explicit Taut(const std::vector<Wheel>& wheels) {
    std::vector<double> way;
    const std::size_t n = wheels.size();
    const auto radius = [](const Wheel& w) { return kPitch * w.teeth / (2 * kPi); };
    for (std::size_t i = 0; i < n; ++i) {
      const Wheel &A = wheels[i], &B = wheels[(i + 1) % n];
      const Vector3 d = B.center - A.center;
      const double by = A.sense * radius(A) - B.sense * radius(B);
      straights.push_back(std::sqrt(d.squaredNorm() - by * by));
      way.push_back(std::atan2(d.y(), d.x()) + std::asin(by / d.norm()));
      length += straights.back();
    }
    for (std::size_t i = 0; i < n; ++i) {
      const Wheel& B = wheels[(i + 1) % n];
      const double turn = B.sense * (way[(i + 1) % n] - way[i]);
      length += radius(B) * (turn - 2 * kPi * std::floor(turn / (2 * kPi)));
    }
  }
};

const std::vector<Wheel> kDrawn = {
    {{0, 0, 0}, 20}, {{0.3, 0.02, 0}, 30}, {{0.2, 0.14, 0}, 12, -1}, {{0.05, 0.25, 0}, 16}};

/// Four wheels, one of them on the belt's back, moved and turned: the stretch of all runs is that of the loop, which
/// turns of the wheels pass on only.
TEST(SprocketLoop, ABeltStretchesAsTheTautLoop) {
  Loop loop(kDrawn, false);
  const System system = assemble(loop.graph);
  const Taut before(kDrawn);
  std::vector<Wheel> now = kDrawn;
  for (int k = 0; k < 4; ++k) {
    now[2].center += Vector3(-3e-4, 1e-4, 0);
    now[1].center += Vector3(2e-4, 0, 0);
    now[static_cast<std::size_t>(k)].turned += 0.003;
    const Taut after(now);
    const VectorX T = Loop::tensions(system, kDrawn, now);
    double stretch = 0;
    for (int i = 0; i < 4; ++i)
      stretch += (T[i] - kTension) / (kStiffness + kTension) * before.straights[static_cast<std::size_t>(i)];
    EXPECT_NEAR(stretch, after.length - before.length, 1e-10);
    EXPECT_GT(std::abs(after.length - before.length), 1e-5);
  }
}

/// A wheel that turns alone, counter-clockwise, pulls in the run before it and gives out the one behind; on the chain's
/// back the other way round.
TEST(SprocketLoop, AWheelPassesTheBeltOn) {
  Loop loop(kDrawn, false);
  const System system = assemble(loop.graph);
  const Taut drawn(kDrawn);
  for (std::size_t wheel = 0; wheel < 4; ++wheel) {
    std::vector<Wheel> now = kDrawn;
    now[wheel].turned = 0.01;
    const VectorX T = Loop::tensions(system, kDrawn, now);
    const double passed = now[wheel].sense * 0.01 * kPitch * now[wheel].teeth / (2 * kPi);
    for (std::size_t run = 0; run < 4; ++run) {
      const double by = run == wheel ? -passed : (run + 1) % 4 == wheel ? passed : 0;
      EXPECT_NEAR(T[static_cast<Eigen::Index>(run)] - kTension, (kStiffness + kTension) / drawn.straights[run] * by,
                  1e-5 * kTension)
          << wheel;
    }
  }
}

/// A tooth on all wheels, against the chain's way on its back, changes nothing; half of it does.
TEST(SprocketLoop, AChainComesBackAfterATooth) {
  Loop loop(kDrawn, true);
  const System system = assemble(loop.graph);
  const auto tensions = [&](double teeth) {
    std::vector<Wheel> now = kDrawn;
    for (Wheel& w : now) w.turned = w.sense * teeth * 2 * kPi / w.teeth;
    return Loop::tensions(system, kDrawn, now);
  };
  const VectorX drawn = tensions(0);
  EXPECT_LT((drawn.array() - kTension).abs().maxCoeff(), 1e-9 * kTension);
  EXPECT_LT((tensions(1) - drawn).norm(), 1e-9 * kTension);
  EXPECT_LT((tensions(2) - drawn).norm(), 1e-9 * kTension);
  EXPECT_GT((tensions(0.5) - drawn).norm(), 1e-2 * kTension);
}

/// Around two sprockets it is the pair.
TEST(SprocketLoop, AroundTwoIsSprocketPair) {
  const std::vector<Wheel> two = {{{0, 0, 0}, 9}, {{0.2, 0, 0}, 14}};
  for (const bool polygon : {true, false}) {
    Loop loop(two, polygon);
    SystemGraph graph{{.gravity = {0, 0, 0}}};
    auto& A = graph.add<RigidBody>("A", {});
    auto& B = graph.add<RigidBody>("B", {.position = two[1].center});
    graph.add<SprocketPair>("chain", {A.marker(), B.marker()},
                            {.teeth_A = 9,
                             .teeth_B = 14,
                             .pitch = kPitch,
                             .axial_stiffness = kStiffness,
                             .pretension = kTension,
                             .polygon = polygon});
    std::vector<Wheel> now = two;
    now[0].turned = 0.3, now[1].turned = 0.2, now[1].center += Vector3(1e-3, 2e-3, 0);
    const VectorX of_loop = Loop::tensions(assemble(loop.graph), two, now),
                  of_pair = Loop::tensions(assemble(graph), two, now);
    EXPECT_NEAR(of_loop[0], of_pair[1], 1e-9 * kTension);  // the pair's first is on its left
    EXPECT_NEAR(of_loop[1], of_pair[0], 1e-9 * kTension);
  }
}

TEST(SprocketLoop, BadInputNamesWhatIsWrong) {
  const auto says = [](const std::vector<Wheel>& wheels, const std::vector<std::string>& words) {
    const auto drawn = [&] {
      Loop loop(wheels, true);
      assemble(loop.graph);
    };
    expect_says(message_of<SceneError>(drawn), words);
  };
  says({{{0, 0, 0}, 9}}, {"chain", "1 sprockets", "two or more"});
  says({{{0, 0, 0}, 9}, {{0.2, 0, 0}, 4}}, {"chain 1", "4 teeth"});
  says({{{0, 0, 0}, 9}, {{0.2, 0, 0}, 9, 2}}, {"chain 1", "sense 2"});
  says({{{0, 0, 0}, 9}, {{0.02, 0, 0}, 9}}, {"chain 1", "overlap"});
}

}  // namespace
}  // namespace lithe::test::sprocket_loop_test
