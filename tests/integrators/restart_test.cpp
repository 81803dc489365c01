// A run that goes on from a checkpoint is the run that was never interrupted, bit for bit: every integrator in every
// kind of scene.
#include <gtest/gtest.h>

#include <cstring>

#include "bodies/rigid_body.h"
#include "engine/analysis/kinematics.h"
#include "engine/run/mode_freezing.h"
#include "engine/run/simulation.h"
#include "integrators/moreau_jean.h"
#include "integrators/nonsmooth_generalized_alpha.h"
#include "joints/forces/spring_damper.h"
#include "joints/spherical_joint.h"
#include "tests/integrators/restart_scenes.h"

namespace lithe::test::restart_test {
namespace {

using namespace restart;

/// Names of what differs.
std::string difference(const std::vector<unsigned char>& a, const std::vector<unsigned char>& b) {
  const auto one = Archive::of_bytes("a", a.data(), a.size()).content();
  const auto two = Archive::of_bytes("b", b.data(), b.size()).content();
  if (one.names != two.names || one.shapes != two.shapes) return "other names or sizes";
  std::string text;
  std::size_t number = 0, integer = 0;
  for (std::size_t i = 0; i < one.names.size(); ++i) {
    const int kind = one.shapes[3 * i];
    const auto count =
        static_cast<std::size_t>(one.shapes[3 * i + 1]) * static_cast<std::size_t>(one.shapes[3 * i + 2]);
    const bool same =
        kind == 0   ? count == 0 || std::memcmp(&one.numbers[number], &two.numbers[number], 8 * count) == 0
        : kind == 1 ? count == 0 || std::memcmp(&one.integers[2 * integer], &two.integers[2 * integer], 8 * count) == 0
                    : true;
    if (!same) text += one.names[i] + " ";
    if (kind == 0) number += count;
    if (kind == 1) integer += count;
  }
  return text;
}

constexpr int kInstants = 10;

void check(const char* scene, const std::function<void(SystemGraph&)>& draw, const Case& method, double end,
           int threads = 1, int other_threads = 1) {
  const std::vector<double> times = random_times(end, kInstants, 17);
  Machine whole(draw, method.make, threads);
  std::vector<Archive> saved;
  std::vector<unsigned char> expected;
  ASSERT_NO_THROW(expected = whole.go_on(times, 0, &saved)) << scene << ", " << method.name;
  for (std::size_t i = 0; i < saved.size(); ++i) {
    Machine resumed(draw, method.make, other_threads);
    saved[i].rewind();
    resumed.state = resumed.simulation.resume(saved[i]);
    ASSERT_EQ(resumed.state.time, times[i]);
    const auto found = resumed.go_on(times, i + 1, nullptr);
    ASSERT_TRUE(found == expected) << scene << ", " << method.name << ", from " << times[i]
                                   << " s: " << difference(found, expected);
    ASSERT_TRUE(same(resumed.state, whole.state) && resumed.state.quarter_turns == whole.state.quarter_turns);
    ASSERT_EQ(resumed.recorder.table().values, whole.recorder.table().values);
    ASSERT_EQ(resumed.simulation.events().size(), whole.simulation.events().size());
    ASSERT_EQ(resumed.simulation.statistics().evaluations, whole.simulation.statistics().evaluations);
  }
}

class Restart : public testing::TestWithParam<int> {
 protected:
  const Case& method() const { return smooth_methods()[static_cast<std::size_t>(GetParam())]; }
};

TEST_P(Restart, of_a_rigid_loop_has_the_bits_of_the_run_that_went_on) {
  check(
      "loop", [](SystemGraph& graph) { draw_loop(graph, {}); }, method(), 0.3);
}
TEST_P(Restart, of_a_rubbing_loop_has_the_bits_of_the_run_that_went_on) {
  check("rubbing", draw_rubbing, method(), 0.1);
}
TEST_P(Restart, of_a_flexible_body_has_the_bits_of_the_run_that_went_on) {
  check("flexible", draw_flexible, method(), 0.05);
}
TEST_P(Restart, of_compliant_contact_has_the_bits_of_the_run_that_went_on) {
  check("contact", draw_compliant, method(), 0.05);
}
TEST_P(Restart, of_several_frames_has_the_bits_of_the_run_that_went_on) {
  check("several frames", draw_several_frames, method(), 0.05);
  check("frames and modes", draw_frames_and_modes, method(), 0.01);
}
TEST_P(Restart, of_plug_ins_has_the_bits_of_the_run_that_went_on) { check("plug-ins", draw_plug_ins, method(), 0.05); }

INSTANTIATE_TEST_SUITE_P(Methods, Restart, testing::Range(0, static_cast<int>(smooth_methods().size())),
                         [](const auto& test) { return smooth_methods()[static_cast<std::size_t>(test.param)].name; });

TEST(RestartOfRigidContact, has_the_bits_of_the_run_that_went_on) {
  for (const Case& method : {Case{"moreau_jean", of<MoreauJean>({.step = 1e-3})},
                             Case{"nonsmooth_alpha", of<NonsmoothGeneralizedAlpha>({.step = 1e-3})}})
    check("rigid contact", draw_rigid_contact, method, 0.2);
}

TEST(RestartOfRigidContact, tells_its_memory_from_that_of_a_compliant_law) {
  const auto draw = [](SystemGraph& graph) {
    draw_rigid_contact(graph);
    auto& puck = graph.add<RigidBody>(
        "puck", {.mass = 1, .inertia = {4e-3, 4e-3, 4e-3}, .position = {3, 0, 0.0995}, .velocity = {0.3, 0, 0}});
    graph.add<Contact>("soft", {{graph.ground().marker(), shape::half_space()}, {puck.marker(), shape::sphere(0.1)}},
                       {.law = Compliance{.stiffness = 2e4, .exponent = 1},
                        .friction = {.coefficient = 0.4, .bristle_stiffness = 3e3}});
  };
  const std::vector<double> times = {0.02, 0.03};
  Machine whole(draw, of<MoreauJean>({.step = 1e-3})), resumed(draw, of<MoreauJean>({.step = 1e-3}));
  std::vector<Archive> saved;
  whole.simulation.run(whole.state, times[0]);
  const ContactMemory before = whole.state.contacts;
  whole.simulation.save(whole.state, saved.emplace_back());
  saved[0].rewind();
  resumed.state = resumed.simulation.resume(saved[0]);
  const ContactMemory& after = resumed.state.contacts;
  int rigid = 0, compliant = 0;
  ASSERT_EQ(after.size(), before.size());
  for (std::size_t i = 0; i < after.size(); ++i) {
    ASSERT_EQ(after[i].memory.index(), before[i].memory.index());
    if (const auto* now = std::get_if<CompliantMemory>(&after[i].memory)) {
      const auto& then = std::get<CompliantMemory>(before[i].memory);
      EXPECT_EQ(after[i].element, 1);
      EXPECT_GT(now->bristle.norm(), 0);
      EXPECT_EQ(now->bristle, then.bristle);
      EXPECT_EQ(now->on_A, then.on_A);
      EXPECT_EQ(now->on_B, then.on_B);
      EXPECT_EQ(now->impact_speed, then.impact_speed);
      ++compliant;
    } else {
      const auto &kept = std::get<RigidMemory>(after[i].memory), &then = std::get<RigidMemory>(before[i].memory);
      EXPECT_EQ(after[i].element, 0);
      EXPECT_GT(kept.velocity.norm(), 0);
      EXPECT_EQ(kept.velocity, then.velocity);
      EXPECT_EQ(std::memcmp(&kept.slip_at_start, &then.slip_at_start, sizeof(double)), 0);  // may be NaN
      EXPECT_EQ(std::memcmp(&kept.slip_at_end, &then.slip_at_end, sizeof(double)), 0);
      ++rigid;
    }
  }
  EXPECT_GT(rigid, 0);
  EXPECT_GT(compliant, 0);
  EXPECT_EQ(resumed.go_on(times, 1, nullptr), whole.go_on(times, 1, nullptr));
}

TEST(RestartOfOthers, has_the_bits_of_the_run_that_went_on) {
  check("driven loop", draw_driven, {"kinematics", of<Kinematics>({.step = 2e-3})}, 0.2);
  for (const bool keeps : {true, false})
    check("freezing", draw_flexible,
          {"freezing",
           [=](const System&) {
             return std::make_unique<ModeFreezing>(keeps ? runge_kutta(1e-6) : adams(1e-6),
                                                   ModeFreezing::Parameters{.displacement = 2e-3, .interval = 2e-3});
           }},
          0.6);
}

/// A tree of spherical joints: explicit methods solve it for its free motions, on as many threads as they are given.
void draw_tree(SystemGraph& graph) {
  for (int branch = 0; branch < 3; ++branch) {
    Marker last = graph.ground().marker({0, 0.1 * branch, 0});
    for (int i = 0; i < 4; ++i) {
      const std::string name = std::to_string(branch) + "." + std::to_string(i);
      auto& link = graph.add<RigidBody>(
          "link " + name, {.mass = 0.1, .inertia = {1e-4, 2e-4, 2e-4}, .position = {0.05 + 0.1 * i, 0.1 * branch, 0}});
      graph.add<SphericalJoint>("joint " + name, {last, link.marker({-0.05, 0, 0})});
      last = link.marker({0.05, 0, 0});
    }
  }
}

TEST(RestartOfOthers, goes_from_one_thread_to_three_and_back) {
  for (const int method : {1, 3}) {
    check("tree", draw_tree, smooth_methods()[static_cast<std::size_t>(method)], 0.2, 1, 3);
    check("tree", draw_tree, smooth_methods()[static_cast<std::size_t>(method)], 0.2, 3, 1);
  }
}

// ---- islands ----

struct IslandsRun {
  SystemGraph graph{{.gravity = {0, 0, -9.81}}};
  Recorder recorder{{Machine::coordinate_of_first()}};
  std::unique_ptr<Simulation> simulation;
  State state;

  explicit IslandsRun(const std::function<Method()>& make) {
    draw_loop(graph, {});
    auto& ball = graph.add<RigidBody>("ball", {.mass = 1, .inertia = {1, 1, 1}, .position = {2, 0, 0.3}});
    graph.add<Contact>("floor", {{graph.ground().marker(), shape::half_space()}, {ball.marker(), shape::sphere(0.1)}},
                       {.law = Compliance{.stiffness = 2e4, .exponent = 1, .restitution = 0.3}});
    auto& rest = graph.add<RigidBody>("rest", {.mass = 1, .inertia = {1, 1, 1}, .position = {5, 0, 0}});
    graph.add<SpringDamper>("hanger", {graph.ground().marker({5, 0, 1}), rest.marker()},
                            {.stiffness = 981, .natural_length = 1 - 9.81 / 981});
    simulation = std::make_unique<Simulation>(graph, make);
    simulation->observe(recorder, every(0.013));
    state = simulation->system().initial_state();
  }
};

TEST(RestartOfIslands, has_the_bits_of_the_run_that_went_on) {
  for (const bool keeps : {true, false}) {
    const auto make = [=] { return keeps ? automatic(1e-6) : adams(1e-6); };
    const std::vector<double> times = random_times(0.5, 5, 3);
    IslandsRun whole(make);
    std::vector<Archive> saved;
    for (double time : times) {
      whole.simulation->run(whole.state, time);
      whole.simulation->save(whole.state, saved.emplace_back());
    }
    const auto expected = saved.back().bytes();
    for (std::size_t i = 0; i + 1 < saved.size(); ++i) {
      IslandsRun resumed(make);
      saved[i].rewind();
      resumed.state = resumed.simulation->resume(saved[i]);
      Archive last;
      for (std::size_t k = i + 1; k < times.size(); ++k) {
        resumed.simulation->run(resumed.state, times[k]);
        resumed.simulation->save(resumed.state, last = Archive());
      }
      EXPECT_TRUE(last.bytes() == expected) << difference(last.bytes(), expected);
      EXPECT_EQ(resumed.recorder.table().values, whole.recorder.table().values);
    }
  }
}

}  // namespace
}  // namespace lithe::test::restart_test
