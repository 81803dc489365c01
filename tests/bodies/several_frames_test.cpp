// A body with several frames against the same blocks, springs and beads as bodies, forces and constraints of their own.
#include <gtest/gtest.h>

#include "bodies/point_mass.h"
#include "bodies/rigid_body.h"
#include "engine/analysis/describe.h"
#include "engine/analysis/equilibrium.h"
#include "engine/analysis/linearization.h"
#include "engine/assembly/batch_of.h"
#include "engine/model/rigid_frame_body.h"
#include "engine/observe/sensors.h"
#include "engine/run/simulation.h"
#include "joints/distance_joint.h"
#include "joints/parallel_axes_joint.h"
#include "joints/revolute_joint.h"
#include "joints/spherical_joint.h"
#include "tests/joints/mechanisms.h"
#include "tests/plugins/kinds/frame_chain.cpp"
#include "tests/support/body_checks.h"
#include "tests/support/joint_checks.h"
#include "tests/support/methods.h"
#include "tests/support/scenes.h"

namespace lithe::test::several_frames_test {
namespace {

/// The spring of FrameChain between two markers, as a force element.
class Spring final : public Force<2, 0> {
 public:
  struct Parameters {
    const FrameChain* of;
  };
  explicit Spring(Parameters parameters) : of_(parameters.of) {}
  bool depends_on_time() const override { return false; }
  void evaluate(double, std::span<const MarkerView> m, ForceRows& rows) const override {
    const FrameChain::Pose a{m[0].p, quaternion_of(m[0].R)}, b{m[1].p, quaternion_of(m[1].R)};
    const auto r = of_->spring(a, b);
    rows.add_load(m[0], {-r.segment<3>(0), -(m[0].R * r.segment<3>(3))});
    rows.add_load(m[1], {-r.segment<3>(6), -(m[1].R * r.segment<3>(9))});
  }

 private:
  const FrameChain* of_;
};

/// The third marker is in the middle between the first two.
class Middle final : public Joint<3, 3> {
 public:
  struct Parameters {};
  explicit Middle(Parameters) {}
  bool depends_on_time() const override { return false; }
  void evaluate(double, std::span<const MarkerView> m, ConstraintRows& rows) const override {
    const Vector3 g = m[2].p - 0.5 * (m[0].p + m[1].p);
    for (int i = 0; i < 3; ++i) {
      const Vector3 e = Vector3::Unit(i);
      rows.add(g[i], {force(-0.5 * e), force(-0.5 * e), force(e)}, 0);
    }
  }
};

const Matrix3 kHinge = rotation_about({1, 0, 0}, -kPi / 2);
constexpr double kGravity = 9.81;

/// What both drawings share: a pin to ground, a rod hinged to the last frame, a string between the first and the last.
void draw_rest(SystemGraph& graph, const std::array<Marker, 4>& at, bool string) {
  graph.add<SphericalJoint>("pin", {graph.ground().marker(), at[0]});
  auto& rod = graph.add<RigidBody>("rod", {.mass = 0.6, .inertia = {0.01, 0.03, 0.03}, .position = {1.5, 0.1, 0}});
  graph.add<RevoluteJoint>("hinge", {at[1], rod.marker({-0.2, 0, 0}, kHinge)});
  if (string) graph.add<DistanceJoint>("string", {at[2], at[3]});
}

FrameChain& draw_chain(SystemGraph& graph, bool string = false, double length = 0.5) {
  auto& chain = graph.add<FrameChain>("chain", {.length = length, .position = {0.2, 0.1, 0}, .velocity = {0, 0, 0.3}});
  draw_rest(graph,
            {chain.marker_in(0, {-0.2, -0.1, 0}), chain.marker_in(2, {0.1, 0, 0}, kHinge),
             chain.marker_in(0, {0, 0, 0.2}), chain.marker_in(2, {0, 0.1, 0.2})},
            string);
  return chain;
}

/// Blocks, springs and beads of the chain. The law of the springs outlives the graph.
std::array<RigidBody*, 3> draw_blocks(SystemGraph& graph, std::vector<Marker>* beads = nullptr) {
  static const FrameChain law{{}};
  std::array<RigidBody*, 3> block;
  for (int i = 0; i < 3; ++i)
    block[i] = &graph.add<RigidBody>(
        "block" + std::to_string(i),
        {.mass = 1, .inertia = {0.1, 0.2, 0.15}, .position = {0.2 + 0.5 * i, 0.1, 0}, .velocity = {0, 0, 0.3}});
  for (int i = 0; i < 2; ++i) {
    auto& bead = graph.add<PointMass>("bead" + std::to_string(i),
                                      {.mass = 0.4, .position = {0.45 + 0.5 * i, 0.1, 0}, .velocity = {0, 0, 0.3}});
    const Marker a = block[i]->marker(), b = block[i + 1]->marker();
    graph.add<Spring>("spring" + std::to_string(i), {a, b}, {&law});
    const Marker at = bead.marker();
    graph.add<Middle>("middle" + std::to_string(i), {a, b, at}, {});
    if (beads) beads->push_back(at);
  }
  return block;
}

void draw_parts(SystemGraph& graph, bool string = false) {
  const auto block = draw_blocks(graph);
  draw_rest(graph,
            {block[0]->marker({-0.2, -0.1, 0}), block[2]->marker({0.1, 0, 0}, kHinge), block[0]->marker({0, 0, 0.2}),
             block[2]->marker({0, 0.1, 0.2})},
            string);
}

TEST(SeveralFrames, OweWhatEveryBodyOwes) {
  SystemGraph graph{{.gravity = {1, 2, -kGravity}}};
  auto& chain = graph.add<FrameChain>("chain", {});
  const std::vector<Marker> markers = {chain.node(0), chain.marker_in(1, {0.1, 0.2, 0.3}, kHinge),
                                       chain.marker_in(2, {0, 0, 1}), chain.bead(0), chain.bead(1)};
  check_body(graph, chain, markers, {.mass = 3.8});
}

/// The positions of the blocks after 0.3 s, with and without a joint between two frames of one body.
TEST(SeveralFrames, MoveAsBodiesOfTheirOwnByEveryMethod) {
  for (const bool string : {false, true}) {
    std::vector<NamedMethod> all = every_method(1e-4);
    all.push_back({"Runge-Kutta 8", runge_kutta8(1e-10)});
    all.push_back({"Adams", adams(1e-10)});
    all.push_back({"automatic", automatic(1e-10)});
    all.push_back({"Radau", radau(1e-10)});
    all.push_back({"BDF", bdf(1e-10)});
    all.push_back({"RATTLE", rattle(1e-4)});
    all.push_back({"HHT", hht(1e-4)});
    all.push_back({"energy-momentum", energy_momentum(1e-4)});
    Scene parts({0, 0, -kGravity}, [&](SystemGraph& graph) { draw_parts(graph, string); });
    const double energy = parts.energy();
    parts.run(*radau(1e-12), 0.3);
    for (auto& [name, method] : all) {
      SCOPED_TRACE(name + (string ? ", with a string" : ""));
      Scene scene({0, 0, -kGravity}, [&](SystemGraph& graph) { draw_chain(graph, string); });
      EXPECT_EQ(scene.system.degrees_of_freedom(), parts.system.degrees_of_freedom());
      EXPECT_NEAR(scene.energy(), energy, 1e-12);
      scene.run(*method, 0.3);
      double apart = 0;
      for (int i = 0; i < 3; ++i)
        apart = std::max(apart, (scene.state.q.segment<3>(7 * i) - parts.state.q.segment<3>(7 * i)).norm());
      expect_below(name, apart, 2e-6);
      EXPECT_GT((scene.state.q.segment<3>(14) - scene.system.initial_state().q.segment<3>(14)).norm(), 0.1);
    }
  }
}

/// A rod hinged to a bead, and a spring from a bead to ground: markers that two frames move.
TEST(SeveralFrames, AreHeldAndLoadedBetweenTheFrames) {
  const auto hang = [](SystemGraph& graph, const Marker& first, const Marker& second, const Marker& axes) {
    auto& rod =
        graph.add<RigidBody>("rod", {.mass = 0.6, .inertia = {0.01, 0.03, 0.03}, .position = {0.45, 0.1, -0.2}});
    graph.add<SphericalJoint>("ball", {first, rod.marker({0, 0, 0.2})});
    graph.add<DistanceJoint>("string", {graph.ground().marker({0.9, 0, 0.8}), second});
    graph.add<ParallelAxesJoint>("upright", {axes, graph.ground().marker()});
  };
  Scene parts({0, 0, -kGravity}, [&](SystemGraph& graph) {
    std::vector<Marker> beads;
    const auto block = draw_blocks(graph, &beads);
    hang(graph, beads[0], beads[1], block[1]->marker());
  });
  parts.run(*radau(1e-12), 0.3);
  const Equilibrium many = find_equilibrium(parts.system, parts.system.initial_state());
  for (auto& [name, method] : every_method(1e-4)) {
    SCOPED_TRACE(name);
    Scene scene({0, 0, -kGravity}, [&](SystemGraph& graph) {
      auto& chain = graph.add<FrameChain>("chain", {.position = {0.2, 0.1, 0}, .velocity = {0, 0, 0.3}});
      hang(graph, chain.bead(0), chain.bead(1), chain.bead(1));
    });
    EXPECT_EQ(scene.system.degrees_of_freedom(), parts.system.degrees_of_freedom());
    const Equilibrium one = find_equilibrium(scene.system, scene.system.initial_state());
    scene.run(*method, 0.3);
    double apart = 0;
    for (int i = 0; i < 3; ++i) {
      apart = std::max(apart, (scene.state.q.segment<3>(7 * i) - parts.state.q.segment<3>(7 * i)).norm());
      EXPECT_NEAR(one.state.q[7 * i + 2], many.state.q[7 * i + 2], 1e-7) << i;
    }
    expect_below(name, apart, 2e-6);
  }
}

/// Its rest and its frequencies there are those of the parts.
TEST(SeveralFrames, RestAndSwingAsBodiesOfTheirOwn) {
  Scene scene({0, 0, -kGravity}, [](SystemGraph& graph) { draw_chain(graph); });
  Scene parts({0, 0, -kGravity}, [](SystemGraph& graph) { draw_parts(graph); });
  const Equilibrium one = find_equilibrium(scene.system, scene.system.initial_state());
  const Equilibrium many = find_equilibrium(parts.system, parts.system.initial_state());
  // What is free to turn about the vertical may rest anywhere: heights and frequencies do not know.
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(one.state.q[7 * i + 2], many.state.q[7 * i + 2], 1e-8) << i;
  // The free turn has a zero of two, which round-off makes one oscillation or two modes that do not oscillate.
  const auto frequencies = [](const Scene& of, const State& state) {
    std::vector<double> found;
    for (const Mode& mode : linearize(of.system, state).modes)
      if (mode.frequency() > 0.01) found.push_back(mode.frequency());
    return found;
  };
  const std::vector<double> a = frequencies(scene, one.state), b = frequencies(parts, many.state);
  ASSERT_EQ(a.size(), 15u);
  ASSERT_EQ(b.size(), 15u);
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], 1e-5 * (1 + b[i])) << i;
}

/// Names, sensors and reactions.
TEST(SeveralFrames, AreNamedAndMeasuredFrameByFrame) {
  Scene scene({0, 0, -kGravity}, [](SystemGraph& graph) { draw_chain(graph, true); });
  const Body& chain = *scene.graph.bodies()[1].body;
  EXPECT_EQ(scene.system.layout().velocity_name(15), "chain frame 2: omega_x");
  EXPECT_EQ(scene.system.layout().body_names(), (std::vector<std::string>{"chain", "rod"}));
  const Sensor q = coordinates(chain), v = generalized_velocities(chain);
  ASSERT_EQ(q.columns().size(), 21u);
  ASSERT_EQ(v.columns().size(), 18u);
  EXPECT_EQ(q.columns()[7], "chain_1_p_x");
  EXPECT_EQ(v.columns()[17], "chain_2_omega_z");
  EXPECT_NE(describe(scene.system).find("'chain': 3 frames"), std::string::npos);
  // The acceleration that a sensor tells is the rate of the velocity that it tells.
  const Marker tip{&chain, 3};
  const auto after = [&](double time) {
    Scene run({0, 0, -kGravity}, [](SystemGraph& graph) { draw_chain(graph, true); });
    if (time > 0) run.run(*runge_kutta8(1e-12), time);
    return read_vector(run, velocity({run.graph.bodies()[1].body, tip.index}));
  };
  Scene run({0, 0, -kGravity}, [](SystemGraph& graph) { draw_chain(graph, true); });
  run.run(*runge_kutta8(1e-12), 0.1);
  const Vector3 a = read_vector(run, acceleration({run.graph.bodies()[1].body, tip.index}));
  const double h = 1e-4;
  EXPECT_LT((a - (after(0.1 + h) - after(0.1 - h)) / (2 * h)).norm(), 1e-4 * a.norm());
}

/// A body that says what cannot be is refused, with what its author is to fix.
TEST(SeveralFrames, WithImpossiblePairsAreRefused) {
  class Wrong final : public RigidFrameBody {
   public:
    struct Parameters {
      int frames, linear;
      FramePair pair;
    };
    explicit Wrong(Parameters p) : RigidFrameBody({.mass = 1, .inertia = Matrix3::Identity()}, {}), p_(p) {}
    Coordinates coordinates() const override {
      return {.frames = p_.frames, .linear = p_.linear, .pairs = {&p_.pair, 1}};
    }

   private:
    Parameters p_;
  };
  for (const Wrong::Parameters p : {Wrong::Parameters{2, 0, {1, 1}}, {2, 0, {0, 2}}, {2, 0, {-1, 0}}}) {
    SystemGraph graph;
    graph.add<Wrong>("wrong", p);
    try {
      assemble(graph);
      FAIL() << p.frames << ' ' << p.pair.first << ' ' << p.pair.second;
    } catch (const SceneError& error) {
      EXPECT_NE(error.problem().find("body 'wrong'"), std::string::npos);
      EXPECT_NE(error.fix().find("coordinates()"), std::string::npos);
    }
  }
}

}  // namespace
}  // namespace lithe::test::several_frames_test
