// Tables of plug-ins that say what cannot be (tools/fuzz/plugin_targets.cpp does so by chance): each has its error.
#include <gtest/gtest.h>

#include <cstddef>
#include <optional>

#include "engine/archive/archive.h"
#include "engine/plugin/registry.h"
#include "engine/run/simulation.h"
#include "tests/plugins/kinds/frame_chain.cpp"
#include "tests/plugins/kinds/heun.cpp"
#include "tests/plugins/kinds/rattle_box.cpp"
#include "tests/support/message_of.h"

namespace lithe::test::hostile_table_test {
namespace {

/// Tables of two sound types, for each test to change.
lithe_body_type body;
lithe_integrator_type integrator;

int32_t entry(const lithe_host* host) {
  host->add_body(host->context, &body);
  host->add_integrator(host->context, &integrator);
  return 0;
}

struct HostileTable : testing::Test {
  HostileTable() {
    body = plugin::body_type<RattleBox>("body");
    integrator = plugin::integrator_type<Heun>("integrator");
  }

  /// What comes of it: loading, drawing, a run, a checkpoint.
  std::string message() {
    return message_of<Error>([] {
      Registry registry;
      registry.add_plugin("hostile", entry);
      SystemGraph graph;
      auto& box = graph.add(registry.body("body"), "box");
      box.marker({0, 0, 0});
      const System system = assemble(graph);
      State state = system.initial_state();
      const auto method = registry.integrator("integrator");
      Simulation simulation(system, *method);
      simulation.run(state, 0.01);
      Archive archive;
      simulation.save(state, archive);
    });
  }
  void expect_said(const std::string& part) {
    const std::string said = message();
    EXPECT_NE(said.find(part), std::string::npos) << said;
    EXPECT_NE(said.find("fix:"), std::string::npos) << said;
  }
};

TEST_F(HostileTable, that_is_sound_is_taken) { EXPECT_EQ(message(), ""); }

TEST_F(HostileTable, that_ends_within_a_pointer_is_refused) {
  body.struct_size = offsetof(lithe_body_type, frame_pairs) + 4;
  expect_said("ends within a member");
}

TEST_F(HostileTable, of_a_body_with_less_than_no_markers_is_refused) {
  body.marker_count = [](const void*) -> int32_t { return -3; };
  expect_said("has -3 markers");
}

TEST_F(HostileTable, of_a_body_whose_marker_is_not_among_them_is_refused) {
  body.place_marker = [](void*, const double*, const double*, char*, size_t) -> int32_t { return 77; };
  expect_said("made marker 77");
}

TEST_F(HostileTable, of_a_body_that_lists_no_pairs_of_frames_is_refused) {
  body = plugin::body_type<FrameChain>("body");
  body.frame_pairs = [](const void*, const int32_t**, const int32_t**) -> int32_t { return 1; };
  expect_said("couples 1 pairs");
  body.frame_pairs = [](const void*, const int32_t** first, const int32_t** second) -> int32_t {
    static const int32_t none[] = {0};
    *first = *second = none;
    return 1'000'000;
  };
  expect_said("couples 1000000 pairs");
}

TEST_F(HostileTable, of_an_integrator_that_moves_time_at_its_start_is_refused) {
  integrator.start = [](void*, const lithe_equations*, lithe_state* state, char*, size_t) -> int32_t {
    state->time = std::nan("");
    return 0;
  };
  expect_said("moves time at its start");
}

TEST_F(HostileTable, of_an_integrator_with_an_endless_past_is_refused) {
  integrator.load = [](void*, const lithe_state*, const unsigned char*, int64_t, char*, size_t) -> int32_t {
    return 0;
  };
  integrator.save = [](void*, unsigned char*, int64_t) -> int64_t { return int64_t{1} << 40; };
  expect_said("a past of 1099511627776 bytes");
}

/// Functions of the equations, called as they are not to be.
TEST_F(HostileTable, of_an_integrator_that_asks_for_what_there_is_not_is_refused) {
  static const lithe_equations* equations = nullptr;
  integrator.start = [](void*, const lithe_equations* given, lithe_state*, char*, size_t) -> int32_t {
    equations = given;
    return 0;
  };
  integrator.step = [](void*, lithe_state* s, double, char*, size_t) -> int32_t {
    return equations->evaluate(equations->host, s->time, s->q, s->v, 77);
  };
  expect_said("asks for level 77");
  integrator.step = [](void*, lithe_state* s, double, char*, size_t) -> int32_t {
    return equations->recall(equations->host, s->quarter_turns, -1);
  };
  expect_said("gives -1 quarter turns");
}

}  // namespace
}  // namespace lithe::test::hostile_table_test
