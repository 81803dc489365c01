// Events of several islands are told by time, as those of one are.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "bodies/rigid_body.h"
#include "engine/archive/archive.h"
#include "engine/observe/recorder.h"
#include "engine/run/simulation.h"
#include "integrators/moreau_jean.h"
#include "joints/contact/contact.h"

namespace lithe::test::simulation_islands_events_test {
namespace {

/// Elastic balls over a floor each, dropped from rest: the n-th impact is at (2 n - 1) sqrt(2 h / g).
struct BouncingBalls {
  static constexpr double g = 9.81;
  std::vector<double> heights;
  SystemGraph graph{{.gravity = {0, 0, -g}}};
  explicit BouncingBalls(std::vector<double> above) : heights(std::move(above)) {
    for (std::size_t i = 0; i < heights.size(); ++i) {
      const std::string number = std::to_string(i + 1);
      const double x = 10.0 * static_cast<double>(i);
      auto& ball = graph.add<RigidBody>(
          "ball " + number, {.mass = 1, .inertia = {4e-3, 4e-3, 4e-3}, .position = {x, 0, 0.1 + heights[i]}});
      graph.add<Contact>("floor " + number,
                         {{graph.ground().marker({x, 0, 0}), shape::half_space()}, {ball.marker(), shape::sphere(0.1)}},
                         {.law = RigidSurfaces{.restitution = 1}});
    }
  }
  std::vector<std::pair<double, std::string>> impacts(double from, double to) const {
    std::vector<std::pair<double, std::string>> all;
    for (std::size_t i = 0; i < heights.size(); ++i)
      for (int n = 1; n < 100; ++n)
        if (const double time = (2 * n - 1) * std::sqrt(2 * heights[i] / g); time > from && time <= to)
          all.emplace_back(time, "floor " + std::to_string(i + 1));
    std::sort(all.begin(), all.end());
    return all;
  }
  static MakeIntegrator steps() {
    return [] { return std::make_unique<MoreauJean>(MoreauJean::Parameters{.step = 1e-3}); };
  }
};

void expect_impacts(const std::vector<EventRecord>& found,
                    const std::vector<std::pair<double, std::string>>& expected) {
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_NEAR(found[i].time, expected[i].first, 1e-9);
    EXPECT_EQ(found[i].name, expected[i].second);
    EXPECT_EQ(found[i].contact.change, ContactChange::impact);
  }
}

TEST(simulation_islands, events_are_those_of_all_islands_by_time) {
  BouncingBalls scene({0.5, 0.2, 0.9});
  Simulation simulation{scene.graph, BouncingBalls::steps(), {.sleep = false}};
  ASSERT_EQ(simulation.islands().size(), 3u);
  State state = simulation.system().initial_state();
  Recorder recorder{{total_energy("energy")}};
  simulation.observe(recorder, every(0.1));
  simulation.run(state, 1.2);
  expect_impacts(simulation.events(), scene.impacts(0, 1.2));
  EXPECT_EQ(simulation.events().size(), 6u);

  // A run that goes on adds to them; so does one that is resumed from a checkpoint.
  Archive archive;
  simulation.save(state, archive);
  simulation.run(state, 2);
  expect_impacts(simulation.events(), scene.impacts(0, 2));
  Archive saved("balls", archive.content());
  Simulation resumed{scene.graph, BouncingBalls::steps(), {.sleep = false}};
  Recorder other{{total_energy("energy")}};
  resumed.observe(other, every(0.1));
  State later = resumed.resume(saved);
  expect_impacts(resumed.events(), scene.impacts(0, 1.2));
  resumed.run(later, 2);
  expect_impacts(resumed.events(), scene.impacts(0, 2));

  // A changed state begins anew, with what happens from there on: also in islands that it leaves alone. (The first
  // ball falls for 0.25 s.)
  state.q[2] = 0.1 + 0.3, state.v[2] = 0;
  simulation.run(state, 2.2);
  std::vector<std::pair<double, std::string>> expected;
  for (const auto& impact : scene.impacts(2, 2.2))
    if (impact.second != "floor 1") expected.push_back(impact);
  expect_impacts(simulation.events(), expected);
  EXPECT_FALSE(expected.empty());
}

}  // namespace
}  // namespace lithe::test::simulation_islands_events_test
