// Every mistake has its message, and the host goes on.
#include <gtest/gtest.h>

#include <fstream>

#include "bodies/rigid_body.h"
#include "engine/run/simulation.h"
#include "integrators/generalized_alpha.h"
#include "plugins/massless_rod/massless_rod.cpp"
#include "tests/plugins/plugins.h"
#include "tests/support/message_of.h"
#include "tests/support/methods.h"

namespace lithe::test::errors_test {
namespace {

testing::AssertionResult holds(const std::string& text, const std::string& part) {
  if (text.find(part) != std::string::npos) return testing::AssertionSuccess();
  return testing::AssertionFailure() << "'" << part << "' is not in:\n" << text;
}

/// A pendulum by the shipped rod: the host still works.
void expect_working(Registry& registry) {
  try {
    registry.joint("massless_rod");
  } catch (const SceneError&) {
    registry.load_plugin(shipped("massless_rod"));
  }
  SystemGraph graph;
  auto& bob = graph.add<RigidBody>("bob", {.position = {1, 0, 0}});
  graph.add(registry.joint("massless_rod"), "string", {graph.ground().marker(), bob.marker()});
  const System system = assemble(graph);
  State state = system.initial_state();
  GeneralizedAlpha integrator{{.step = 1e-3}};
  Simulation(system, integrator).run(state, 0.1);
  EXPECT_LT(state.q[2], -0.04);
  EXPECT_NEAR(state.q.head<3>().norm(), 1, 1e-9);
}

struct Refused {
  std::string library;
  std::vector<std::string> said;
};

class LoadingErrors : public testing::TestWithParam<Refused> {};

TEST_P(LoadingErrors, name_the_file_and_the_fix_and_leave_the_host_well) {
  Registry registry;
  const std::string text = message_of<FileError>([&] { registry.load_plugin(library(GetParam().library)); });
  EXPECT_TRUE(holds(text, "/" + GetParam().library + ".so\n  fix:  "));
  for (const std::string& part : GetParam().said) EXPECT_TRUE(holds(text, part));
  expect_working(registry);
}

INSTANTIATE_TEST_SUITE_P(
    Plugins, LoadingErrors,
    testing::Values(Refused{"missing", {"there is no such plug-in", "lithe_add_plugin()"}},
                    Refused{"no_entry", {"not a Lithe plug-in", "no symbol lithe_plugin_v1", "LITHE_EXPORT_JOINT"}},
                    Refused{"version_0", {"version 0 of the plug-in interface; this Lithe has version 1", "build"}},
                    Refused{"version_99", {"version 99 of the plug-in interface; this Lithe has version 1", "build"}},
                    Refused{"unresolved", {"cannot be loaded", "undefined symbol: nobody_has_this"}},
                    Refused{"unwilling", {"its entry returned -3"}}, Refused{"empty", {"exports no type"}},
                    Refused{"small_table", {"a table of 40 bytes", "struct_size"}},
                    Refused{"not_whole", {"'idle_ball' lacks a function"}},
                    Refused{"twice", {"'ball' is exported twice"}}),
    [](const auto& test) { return test.param.library; });

TEST(LoadingErrors, a_text_file_is_no_library_and_a_folder_is_no_file) {
  Registry registry;
  const auto path = std::filesystem::path(LITHE_BINARY_DIR) / "tests" / "no_library.so";
  std::ofstream(path) << "This is a text.\n";
  EXPECT_TRUE(holds(message_of<FileError>([&] { registry.load_plugin(path); }), "cannot be loaded"));
  EXPECT_TRUE(
      holds(message_of<FileError>([&] { registry.load_plugin(path.parent_path()); }), "the plug-in is not a file"));
  std::filesystem::remove(path);
  expect_working(registry);
}

TEST(LoadingErrors, a_library_is_registered_whole_or_not_at_all) {
  Registry registry;
  EXPECT_THROW(registry.load_plugin(library("small_table")), FileError);  // has a good_ball too
  EXPECT_TRUE(holds(message_of<SceneError>([&] { registry.joint("good_ball"); }), "load its plug-in first"));
}

TEST(LoadingErrors, a_name_in_use_tells_by_whom) {
  Registry registry;
  registry.load_plugin(shipped("massless_rod"));
  EXPECT_TRUE(holds(message_of<FileError>([&] { registry.load_plugin(shipped("massless_rod")); }),
                    "a joint type 'massless_rod' is registered already, from " + shipped("massless_rod").string()));
  EXPECT_TRUE(holds(message_of<SceneError>([&] { registry.add<MasslessRod>("massless_rod"); }), "errors_test.cpp:"));
  Registry compiled;
  compiled.add<MasslessRod>("massless_rod");
  EXPECT_TRUE(holds(message_of<FileError>([&] { compiled.load_plugin(shipped("massless_rod")); }), "compiled in"));
  expect_working(registry);
}

TEST(NameErrors, of_types_name_the_line_and_the_known_ones) {
  Registry registry;
  registry.load_plugin(shipped("massless_rod"));
  registry.load_plugin(shipped("cam_follower"));
  const std::string text = message_of<SceneError>([&] { registry.joint("massles_rod"); });
  EXPECT_TRUE(holds(text, "error: no joint type 'massles_rod' is registered"));
  EXPECT_TRUE(holds(text, "at:   errors_test.cpp:"));
  EXPECT_TRUE(holds(text, "fix:  did you mean 'massless_rod'? known are cam_follower, massless_rod"));
  EXPECT_TRUE(holds(message_of<SceneError>([&] { registry.force("massless_rod"); }), "no force type 'massless_rod'"));
  EXPECT_TRUE(holds(message_of<SceneError>([&] { registry.integrator("rk4"); }), "no integrator type 'rk4'"));
  expect_working(registry);
}

TEST(ParameterErrors, name_the_element_the_line_and_what_there_is) {
  Registry registry;
  registry.load_plugin(shipped("massless_rod"));
  registry.load_plugin(shipped("cam_follower"));
  registry.load_plugin(library("rattle_box"));
  registry.load_plugin(library("heun"));
  SystemGraph graph;
  auto& bob = graph.add<RigidBody>("bob", {.position = {1, 0, 0}});
  const std::vector<Marker> ends{graph.ground().marker(), bob.marker()};
  const auto add = [&](const ParameterList& parameters, const std::vector<Marker>& markers) {
    return message_of<SceneError>([&] { graph.add(registry.joint("massless_rod"), "string", markers, parameters); });
  };
  const std::string text = add({{"lenght", 0.5}}, ends);
  EXPECT_TRUE(holds(text, "error: 'string': joint type 'massless_rod' of massless_rod.so has no parameter 'lenght'"));
  EXPECT_TRUE(holds(text, "at:   errors_test.cpp:"));
  EXPECT_TRUE(holds(text, "did you mean 'length'? known are length"));
  EXPECT_TRUE(holds(add({{"length", "long"}}, ends), "is given as a text\n"));
  EXPECT_TRUE(holds(add({{"length", {1, 2}}}, ends), "is given as a vector\n"));
  EXPECT_TRUE(holds(add({{"length", 1}, {"length", 2}}, ends), "is given twice"));
  EXPECT_TRUE(holds(add({{"length", -1}}, ends), "refuses: length is -1"));
  EXPECT_TRUE(holds(add({}, {ends[0]}), "needs 2 markers and got 1"));
  EXPECT_TRUE(holds(add({}, {ends[0], ends[1], ends[1]}), "needs 2 markers and got 3"));
  EXPECT_TRUE(holds(message_of<SceneError>([&] {
                      graph.add(registry.body("rattle_box"), "box", {{"inertia", {1, 2}}});
                    }),
                    "is given 2 numbers\n  at:   errors_test.cpp"));
  EXPECT_TRUE(holds(message_of<SceneError>([&] {
                      registry.integrator("heun", {{"substeps", 1.5}});
                    }),
                    "substeps is 1.5"));
  EXPECT_TRUE(holds(message_of<SceneError>([&] { registry.integrator("heun", {{"step", 0}}); }), "errors_test.cpp:"));
  graph.add(registry.joint("massless_rod"), "string", ends);  // the name is still free
  expect_working(registry);
}

// ---- plug-ins that throw ----

struct Throwing : testing::Test {
  Registry registry;
  SystemGraph graph;
  RigidBody& bob = graph.add<RigidBody>("bob", {.position = {1, 0, 0}});
  Throwing() { registry.load_plugin(library("throwing")); }
  ~Throwing() override { expect_working(registry); }

  /// Falls until something throws; the state is the last good one.
  std::string run(Integrator& integrator, double& reached) {
    const System system = assemble(graph);
    State state = system.initial_state();
    Simulation simulation(system, integrator);
    const std::string text = message_of<SimulationError>([&] { simulation.run(state, 1); });
    reached = state.time;
    EXPECT_TRUE(state.q.allFinite());
    return text;
  }
};

TEST_F(Throwing, in_create_is_an_error_of_the_scene) {
  EXPECT_TRUE(holds(
      message_of<SceneError>([&] {
        graph.add(registry.joint("throwing_joint"), "bad", {graph.ground().marker(), bob.marker()}, {{"create", true}});
      }),
      "'bad': joint type 'throwing_joint' of throwing.so refuses: it does not want to be made"));
  EXPECT_TRUE(holds(message_of<SceneError>([&] {
                      graph.add(registry.body("throwing_body"), "bad", {{"create", true}});
                    }),
                    "it does not want to be made"));
  EXPECT_TRUE(holds(message_of<SceneError>([&] {
                      registry.integrator("throwing_integrator", {{"create", true}});
                    }),
                    "it does not want to be made"));
}

TEST_F(Throwing, in_a_joint_ends_the_run_at_the_last_good_state) {
  graph.add(registry.joint("throwing_joint"), "ball", {graph.ground().marker({1, 0, 0}), bob.marker()},
            {{"evaluate", 0.5}});
  double reached = 0;
  GeneralizedAlpha integrator{{.step = 1e-2}};
  const std::string text = run(integrator, reached);
  EXPECT_TRUE(holds(text, "error: 'ball': joint type 'throwing_joint' of throwing.so failed: it has had enough"));
  EXPECT_TRUE(holds(text, "at:   errors_test.cpp:"));
  EXPECT_TRUE(holds(text, ", t = 0.5"));
  EXPECT_TRUE(holds(text, "fix:  stop earlier"));
  EXPECT_NEAR(reached, 0.49, 1e-9);
}

TEST_F(Throwing, what_is_no_exception_is_caught_too) {
  graph.add(registry.force("throwing_force"), "push", {bob.marker()}, {{"evaluate", 0.3}, {"strange", true}});
  double reached = 0;
  const Method method = runge_kutta_fixed(1e-2);
  EXPECT_TRUE(holds(run(*method, reached), "'push': force type 'throwing_force' of throwing.so failed: it threw"));
  EXPECT_NEAR(reached, 0.3, 0.011);
}

TEST_F(Throwing, in_a_body_ends_the_run) {
  graph.add(registry.body("throwing_body"), "stone", {{"evaluate", 0.5}});
  double reached = 0;
  GeneralizedAlpha integrator{{.step = 1e-3}};
  EXPECT_TRUE(holds(run(integrator, reached), "'stone': body type 'throwing_body' of throwing.so failed"));
  EXPECT_NEAR(reached, std::sqrt(2 * 0.5 / 9.81), 3e-3);  // the stone has fallen half a metre
}

TEST_F(Throwing, beneath_a_loaded_integrator_is_told_as_it_was) {
  registry.load_plugin(library("heun"));
  graph.add(registry.force("throwing_force"), "push", {bob.marker()}, {{"evaluate", 0.3}});
  double reached = 0;
  const auto method = registry.integrator("heun", {{"step", 1e-2}});
  EXPECT_TRUE(holds(run(*method, reached), "'push': force type 'throwing_force' of throwing.so failed: it has had"));
  EXPECT_NEAR(reached, 0.3, 0.011);
}

TEST_F(Throwing, in_an_integrator_or_failing_there_ends_the_run) {
  double reached = 1;
  const auto throwing = registry.integrator("throwing_integrator", {{"evaluate", 0}});
  EXPECT_TRUE(
      holds(run(*throwing, reached), "integrator type 'throwing_integrator' of throwing.so failed: it has had"));
  const auto failing = registry.integrator("throwing_integrator");
  EXPECT_TRUE(holds(run(*failing, reached), "it would rather not"));
  EXPECT_EQ(reached, 0);
}

TEST_F(Throwing, at_assembly_is_an_error_that_names_the_element) {
  graph.add(registry.joint("throwing_joint"), "ball", {graph.ground().marker({1, 0, 0}), bob.marker()},
            {{"evaluate", 0}});
  EXPECT_TRUE(holds(message_of<SimulationError>([&] { assemble(graph); }), "'ball': joint type 'throwing_joint'"));
}

TEST_F(Throwing, a_force_without_value_makes_integrators_take_smaller_steps) {
  // The bob reaches 0.5 m/s and may not be evaluated beyond: steps become small, and then the run fails there.
  graph.add(registry.force("shy_force"), "air", {bob.marker()}, {{"speed", 0.5}});
  double reached = 0;
  GeneralizedAlpha integrator{{.step = 1e-2}};
  EXPECT_TRUE(holds(run(integrator, reached), "'air' (errors_test.cpp:"));
  EXPECT_GT(integrator.statistics().rejected, 3);
  const double v = 0.5, g = 9.81;  // v̇ = g - 10 v
  EXPECT_NEAR(reached, -std::log(1 - 10 * v / g) / 10, 2e-3);
}

// ---- lifetime ----

TEST(Lifetime, a_graph_outlives_its_registry) {
  SystemGraph graph;
  auto& bob = graph.add<RigidBody>("bob", {.position = {0.5, 0, 0}});
  {
    Registry registry;
    registry.load_plugin(shipped("massless_rod"));
    graph.add(registry.joint("massless_rod"), "string", {graph.ground().marker(), bob.marker()}, {{"length", 0.5}});
  }
  const System system = assemble(graph);
  State state = system.initial_state();
  GeneralizedAlpha integrator{{.step = 1e-3}};
  Simulation(system, integrator).run(state, 0.1);
  EXPECT_NEAR(state.q.head<3>().norm(), 0.5, 1e-9);
}

TEST(Symbols, a_plugin_needs_none_of_the_engine_and_exports_one) {
  const auto listed = [](const std::string& options, const std::filesystem::path& file) {
    std::vector<std::string> lines;
    FILE* pipe = popen((LITHE_NM " -D -C " + options + " " + file.string()).c_str(), "r");
    char line[4096];
    while (pipe && std::fgets(line, sizeof line, pipe)) lines.emplace_back(line);
    EXPECT_EQ(pclose(pipe), 0);
    return lines;
  };
  for (const auto& file : {shipped("massless_rod"), shipped("cam_follower"), library("hinge"), library("bungee"),
                           library("rattle_box"), library("heun"), library("alpha"), library("nut_and_skate")}) {
    const auto needed = listed("--undefined-only", file), exported = listed("--defined-only", file);
    EXPECT_GT(needed.size(), 5u);
    for (const std::string& line : needed) EXPECT_EQ(line.find("lithe"), std::string::npos) << file << ": " << line;
    ASSERT_EQ(exported.size(), 1u) << file;
    EXPECT_TRUE(holds(exported[0], " lithe_plugin_v1\n"));
  }
}

}  // namespace
}  // namespace lithe::test::errors_test
