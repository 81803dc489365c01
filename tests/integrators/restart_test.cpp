// A run that goes on from a checkpoint is the run that was never interrupted, bit for bit: every integrator in every
// kind of scene; and what is refused.
#include <gtest/gtest.h>

#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <functional>
#include <map>
#include <random>

#include "bodies/flexible/elements/meshes.h"
#include "bodies/flexible/flexible_body.h"
#include "bodies/rigid_body.h"
#include "engine/analysis/kinematics.h"
#include "engine/assembly/batch_of.h"
#include "engine/observe/recorder.h"
#include "engine/output/csv.h"
#include "engine/output/hdf5_file.h"
#include "engine/output/hdf5_table.h"
#include "engine/plugin.h"
#include "engine/plugin/registry.h"
#include "engine/run/lean_simulation.h"
#include "engine/run/mode_freezing.h"
#include "engine/run/sleeping_integrator.h"
#include "integrators/explicit_runge_kutta.h"
#include "integrators/generalized_alpha.h"
#include "integrators/lie_bdf.h"
#include "integrators/moreau_jean.h"
#include "integrators/nonsmooth_generalized_alpha.h"
#include "joints/contact/contact.h"
#include "joints/coordinate_drive.h"
#include "joints/forces/joint_friction.h"
#include "joints/forces/spring_damper.h"
#include "joints/revolute_joint.h"
#include "joints/spherical_joint.h"
#include "tests/engine/output/output_scratch_folder.h"
#include "tests/plugins/kinds/rattle_box.cpp"
#include "tests/support/methods.h"

namespace lithe::test::restart_test {
namespace {

// ---- scenes ----

const Matrix3 kAxisY = rotation_about({1, 0, 0}, -M_PI / 2);  // marker z along world y

/// How a scene is drawn: the ways in which another one may differ from it.
struct Drawing {
  double mass = 1, stiffness = 40;
  bool spare = false;
  const char* name = "rocker";
};

/// Crank, coupler and rocker, closed to a loop by hinges about y; a spring between coupler and ground.
void draw_loop(SystemGraph& graph, const Drawing& d) {
  auto& crank = graph.add<RigidBody>("crank", {.mass = 0.5, .inertia = {1e-3, 5e-3, 5e-3}, .position = {0, 0, 0.1}});
  auto& coupler =
      graph.add<RigidBody>("coupler", {.mass = d.mass, .inertia = {2e-3, 2e-2, 2e-2}, .position = {0.2, 0, 0.25}});
  auto& rocker = graph.add<RigidBody>(d.name, {.mass = 0.8, .inertia = {1e-3, 9e-3, 9e-3}, .position = {0.4, 0, 0.15}});
  graph.add<RevoluteJoint>("a", {graph.ground().marker({0, 0, 0}, kAxisY), crank.marker({0, 0, -0.1}, kAxisY)});
  graph.add<RevoluteJoint>("b", {crank.marker({0, 0, 0.1}, kAxisY), coupler.marker({-0.2, 0, -0.05}, kAxisY)});
  graph.add<RevoluteJoint>("c", {coupler.marker({0.2, 0, 0.05}, kAxisY), rocker.marker({0, 0, 0.15}, kAxisY)});
  graph.add<RevoluteJoint>("d", {graph.ground().marker({0.4, 0, 0}, kAxisY), rocker.marker({0, 0, -0.15}, kAxisY)});
  graph.add<SpringDamper>("spring", {graph.ground().marker({0.5, 0, 0.6}), coupler.marker({0.1, 0, 0})},
                          {.stiffness = d.stiffness, .damping = 0.1, .natural_length = 0.2});
  if (d.spare) graph.add<RigidBody>("spare", {.mass = 1, .inertia = {1, 1, 1}});
}

/// The same, rubbing in a hinge by the reaction there.
void draw_rubbing(SystemGraph& graph) {
  draw_loop(graph, {});
  auto& pin = *dynamic_cast<const RevoluteJoint*>(graph.find("a"));
  graph.add<JointFriction>("rub", {pin.angle()},
                           {.joint = &pin, .dynamic = 0.2, .transition_speed = 1e-2, .radius = 0.02});
}

std::shared_ptr<const ModalBasis> rod_modes() {
  static const auto modes = make_basis(brick_mesh({.size = {0.4, 0.02, 0.02},
                                                   .divisions = {4, 1, 1},
                                                   .type = "C3D8I",
                                                   .material = {2e8, 0.3, 1200},
                                                   .name = "rod"}),
                                       MeanAxisFrame{}, 3);
  return modes;
}

/// A soft rod on a hinge, swinging.
void draw_flexible(SystemGraph& graph) {
  auto& rod = graph.add<FlexibleBody>("rod", {.basis = rod_modes()});
  graph.add<RevoluteJoint>("pin", {graph.ground().marker({0, 0, 0}, kAxisY), rod.average({1, 2}, kAxisY)});
}

/// A block thrown onto the floor, where bristles hold it, and a ball onto the block.
void draw_contact(SystemGraph& graph, Contact::Parameters parameters) {
  auto& block = graph.add<RigidBody>("block", {.mass = 1,
                                               .inertia = {0.02, 0.03, 0.04},
                                               .position = {0, 0, 0.0505},
                                               .orientation = rotation_about({0, 1, 0}, 1e-3),
                                               .velocity = {0.4, 0.1, -0.1},
                                               .angular_velocity = {0, 0, 0.5}});
  auto& ball = graph.add<RigidBody>(
      "ball", {.mass = 0.3, .inertia = {4e-4, 4e-4, 4e-4}, .position = {0.05, 0, 0.16}, .velocity = {0, 0, -0.5}});
  graph.add<Contact>("touch",
                     {{graph.ground().marker(), shape::half_space()},
                      {block.marker(), shape::box({0.4, 0.3, 0.1})},
                      {ball.marker(), shape::sphere(0.05)}},
                     std::move(parameters));
}
void draw_compliant(SystemGraph& graph) {
  draw_contact(graph, {.law = Compliance{.stiffness = 2e4, .exponent = 1, .restitution = 0.5},
                       .friction = {.coefficient = 0.4, .bristle_stiffness = 3e3}});
}
void draw_rigid_contact(SystemGraph& graph) {
  draw_contact(graph, {.law = RigidSurfaces{.restitution = 0.5}, .friction = {.coefficient = 0.4}});
}

/// Types known by name: a loaded joint, and a body behind its C table.
void draw_plug_ins(SystemGraph& graph) {
  Registry registry;
  registry.load_plugin(std::filesystem::path(LITHE_BINARY_DIR) / "plugins" / "massless_rod.so");
  registry.add<RattleBox>("rattle_box");
  auto& box =
      graph.add(registry.body("rattle_box"), "box", {{"position", {0.3, 0, 0}}, {"angular_velocity", {1, 2, 3}}});
  auto& bob = graph.add<RigidBody>("bob", {.mass = 1, .inertia = {0.01, 0.02, 0.03}, .position = {0.6, 0.1, 0}});
  const Marker at = box.marker({0, 0, 0});
  graph.add(registry.joint("massless_rod"), "string", {graph.ground().marker(), at}, {{"length", 0.3}});
  graph.add(registry.joint("massless_rod"), "rope", {at, bob.marker()}, {{"length", std::hypot(0.3, 0.1)}});
}

void draw_driven(SystemGraph& graph) {
  draw_loop(graph, {});
  auto& pin = *dynamic_cast<const RevoluteJoint*>(graph.find("a"));
  graph.add<CoordinateDrive>("motor", {pin.angle()}, {.motion = ramp(0, 3)});
}

// ---- methods ----

/// Lithe's own method behind a C table, as a plug-in has it.
class Guest final : public Integrator {
 public:
  struct Parameters {
    double step = 0;
  };
  static constexpr Field<Parameters> kParameters[] = {{"step", &Parameters::step}};
  explicit Guest(Parameters parameters) : method_({.step = parameters.step}) {}
  std::string name() const override { return method_.name(); }
  const IntegratorStatistics& statistics() const override { return method_.statistics(); }
  void prepare(EquationsOfMotion& equations, State& state) override { method_.start(equations, state); }
  StepResult advance(EquationsOfMotion& equations, State& state, double t_stop) override {
    return method_.step(equations, state, t_stop);
  }
  bool keep(Archive& archive, EquationsOfMotion& equations, const State& state) override {
    bool kept = false;
    archive.group("method", [&] { kept = method_.history(archive, equations, state); });
    return kept;
  }

 private:
  GeneralizedAlpha method_;
};
/// One that tells nothing of its past.
class Forgetful final : public Integrator {
 public:
  struct Parameters {
    double step = 0;
  };
  static constexpr Field<Parameters> kParameters[] = {{"step", &Parameters::step}};
  explicit Forgetful(Parameters parameters) : method_({.step = parameters.step}) {}
  std::string name() const override { return "forgetful"; }
  const IntegratorStatistics& statistics() const override { return method_.statistics(); }
  void prepare(EquationsOfMotion& equations, State& state) override { method_.start(equations, state); }
  StepResult advance(EquationsOfMotion& equations, State& state, double t_stop) override {
    return method_.step(equations, state, t_stop);
  }

 private:
  GeneralizedAlpha method_;
};

using MakeMethod = std::function<Method(const System&)>;
template <class T>
MakeMethod of(typename T::Parameters parameters) {
  return [=](const System&) { return std::make_unique<T>(parameters); };
}
MakeMethod behind_a_table(const std::string& name) {
  return [=](const System&) {
    Registry registry;
    registry.add<Guest>("guest");
    registry.add<Forgetful>("forgetful");
    return registry.integrator(name, {{"step", 2e-3}});
  };
}

struct Case {
  const char* name;
  MakeMethod make;
};
constexpr Tolerance kTolerance{1e-6, 1e-8};
const std::vector<Case>& smooth_methods() {
  static const std::vector<Case> all = {
      {"runge_kutta5", of<ExplicitRungeKutta>({.tolerance = kTolerance})},
      {"runge_kutta8",
       of<ExplicitRungeKutta>({.method = ExplicitRungeKutta::Method::dormand_prince8, .tolerance = kTolerance})},
      {"runge_kutta_fixed", of<ExplicitRungeKutta>({.step = 1e-3})},
      {"automatic", [](const System&) { return automatic(1e-6); }},
      {"adams", [](const System&) { return adams(1e-6); }},
      {"ida", [](const System&) { return ida(1e-6); }},
      {"radau", [](const System&) { return radau(1e-6); }},
      {"radau_fixed", [](const System&) { return radau_fixed(4e-3); }},
      {"bdf", [](const System&) { return bdf(1e-6); }},
      {"bdf_fixed", of<LieBdf>({.step = 2e-3, .tolerance = {1e-4, 1e-5}, .max_order = 3})},
      {"index3", [](const System&) { return index3(2e-3); }},
      {"index2", [](const System&) { return index2(2e-3); }},
      {"alpha_automatic", of<GeneralizedAlpha>({.tolerance = {1e-4, 1e-6}})},
      {"hht", [](const System&) { return hht(2e-3); }},
      {"rattle", [](const System&) { return rattle(1e-3); }},
      {"energy_momentum", [](const System&) { return energy_momentum(1e-3); }},
      {"linearly_implicit", [](const System&) { return linearly_implicit(1e-3); }},
      {"extrapolated", [](const System&) { return linearly_implicit(2e-3, 2); }},
      {"moreau_jean", of<MoreauJean>({.step = 1e-3})},
      {"nonsmooth_alpha", of<NonsmoothGeneralizedAlpha>({.step = 1e-3})},
      {"sleeping", [](const System&) { return std::make_unique<SleepingIntegrator>(automatic(1e-6)); }},
      {"sleeping_adams", [](const System&) { return std::make_unique<SleepingIntegrator>(adams(1e-6)); }},
      {"guest", behind_a_table("guest")},
      {"forgetful", behind_a_table("forgetful")},
  };
  return all;
}

// ---- what is compared ----

/// A scene that runs, made anew for each resumption.
struct Machine {
  SystemGraph graph{{.gravity = {0, 0, -9.81}}};
  System system;
  Method method;
  Recorder recorder;
  Simulation simulation;
  State state;

  Machine(const std::function<void(SystemGraph&)>& draw, const MakeMethod& make, int threads = 1)
      : system((draw(graph), assemble(graph, {.threads = threads}))),
        method(make(system)),
        recorder({coordinate_of_first()}),
        simulation(system, *method),
        state(system.initial_state()) {
    simulation.observe(recorder, every(7e-3));
    simulation.on({.name = "turns", .function = [](Snapshot& now) { return now.state().v[0] - 0.05; }});
  }
  /// A column of no meaning that all of the motion goes into.
  static Sensor coordinate_of_first() {
    return {"norm", {"norm"}, [](Snapshot& now, std::span<double> values) {
              values[0] = now.state().q.norm() + now.accelerations().norm() + now.multipliers().norm();
            }};
  }
  /// On through the times from `next` on, saving at each; returns all that there is to know at the last.
  std::vector<unsigned char> go_on(const std::vector<double>& times, std::size_t next, std::vector<Archive>* saved) {
    for (std::size_t i = next;; ++i) {
      simulation.run(state, times[i]);
      Archive archive;
      simulation.save(state, archive);
      if (i + 1 == times.size()) return archive.bytes();
      if (saved) saved->push_back(std::move(archive));
    }
  }
};

std::vector<double> random_times(double end, int count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> within(0.02 * end, 0.98 * end);
  std::vector<double> times;
  for (int i = 0; i < count; ++i) times.push_back(within(random));
  std::sort(times.begin(), times.end());
  times.push_back(end);
  return times;
}

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

constexpr int kInstants = 20;

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
TEST_P(Restart, of_plug_ins_has_the_bits_of_the_run_that_went_on) { check("plug-ins", draw_plug_ins, method(), 0.05); }

INSTANTIATE_TEST_SUITE_P(Methods, Restart, testing::Range(0, static_cast<int>(smooth_methods().size())),
                         [](const auto& test) { return smooth_methods()[static_cast<std::size_t>(test.param)].name; });

TEST(RestartOfRigidContact, has_the_bits_of_the_run_that_went_on) {
  for (const Case& method : {Case{"moreau_jean", of<MoreauJean>({.step = 1e-3})},
                             Case{"nonsmooth_alpha", of<NonsmoothGeneralizedAlpha>({.step = 1e-3})}})
    check("rigid contact", draw_rigid_contact, method, 0.2);
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

struct LeanRun {
  SystemGraph graph{{.gravity = {0, 0, -9.81}}};
  Recorder recorder{{Machine::coordinate_of_first()}};
  std::unique_ptr<LeanSimulation> simulation;
  State state;

  explicit LeanRun(const std::function<Method()>& make) {
    draw_loop(graph, {});
    auto& ball = graph.add<RigidBody>("ball", {.mass = 1, .inertia = {1, 1, 1}, .position = {2, 0, 0.3}});
    graph.add<Contact>("floor", {{graph.ground().marker(), shape::half_space()}, {ball.marker(), shape::sphere(0.1)}},
                       {.law = Compliance{.stiffness = 2e4, .exponent = 1, .restitution = 0.3}});
    auto& rest = graph.add<RigidBody>("rest", {.mass = 1, .inertia = {1, 1, 1}, .position = {5, 0, 0}});
    graph.add<SpringDamper>("hanger", {graph.ground().marker({5, 0, 1}), rest.marker()},
                            {.stiffness = 981, .natural_length = 1 - 9.81 / 981});
    simulation = std::make_unique<LeanSimulation>(graph, make);
    simulation->observe(recorder, every(0.013));
    state = simulation->system().initial_state();
  }
};

TEST(RestartOfIslands, has_the_bits_of_the_run_that_went_on) {
  for (const bool keeps : {true, false}) {
    const auto make = [=] { return keeps ? automatic(1e-6) : adams(1e-6); };
    const std::vector<double> times = random_times(0.5, 5, 3);
    LeanRun whole(make);
    std::vector<Archive> saved;
    for (double time : times) {
      whole.simulation->run(whole.state, time);
      whole.simulation->save(whole.state, saved.emplace_back());
    }
    const auto expected = saved.back().bytes();
    for (std::size_t i = 0; i + 1 < saved.size(); ++i) {
      LeanRun resumed(make);
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

// ---- files ----

TEST(CheckpointFile, is_written_within_a_run_and_leaves_it_as_it_is) {
  const ScratchFolder folder;
  const auto draw = [](SystemGraph& graph) { draw_loop(graph, {}); };
  for (const char* stream : {"", "rows.csv", "rows.h5"}) {
    Machine plain(draw, smooth_methods()[8].make), writing(draw, smooth_methods()[8].make);
    if (*stream) writing.recorder.stream(folder.path(stream));
    writing.simulation.checkpoint(folder.path("run.h5"), every(0.05));
    plain.simulation.run(plain.state, 0.33);
    writing.simulation.run(writing.state, 0.17);
    const std::string half = folder.path("half.h5");
    std::filesystem::copy_file(folder.path("run.h5"), half, std::filesystem::copy_options::overwrite_existing);
    plain.simulation.run(plain.state, 0.4);
    // Not cut at 0.17, which no checkpoint has seen: the last was written soon after 0.15.
    Machine resumed(draw, smooth_methods()[8].make);
    if (*stream) resumed.recorder.stream(folder.path(stream));
    resumed.simulation.checkpoint(folder.path("run.h5"), every(0.05));
    resumed.state = resumed.simulation.resume(half);
    EXPECT_GE(resumed.state.time, 0.15);
    EXPECT_LT(resumed.state.time, 0.17);
    resumed.simulation.run(resumed.state, 0.33);
    resumed.simulation.run(resumed.state, 0.4);
    Archive a, b;
    plain.simulation.save(plain.state, a);
    resumed.simulation.save(resumed.state, b);
    EXPECT_TRUE(same(plain.state, resumed.state));
    EXPECT_EQ(plain.recorder.table().values, resumed.recorder.table().values);
    if (!*stream) continue;
    const Table rows =
        std::string(stream).ends_with("csv") ? read_csv(folder.path(stream)) : read_hdf5_table(folder.path(stream));
    EXPECT_EQ(rows.columns, plain.recorder.table().columns);
    EXPECT_EQ(rows.values, plain.recorder.table().values);
  }
}

TEST(CheckpointFile, starts_methods_anew_that_tell_no_past_in_both_runs) {
  const ScratchFolder folder;
  const std::string path = folder.path("run.h5"), half = folder.path("half.h5");
  const auto draw = [](SystemGraph& graph) { draw_loop(graph, {}); };
  Machine writing(draw, smooth_methods()[4].make), resumed(draw, smooth_methods()[4].make);
  writing.simulation.checkpoint(path, every(0.05));
  resumed.simulation.checkpoint(path, every(0.05));
  writing.simulation.run(writing.state, 0.12);
  std::filesystem::copy_file(path, half);
  writing.simulation.run(writing.state, 0.3);
  resumed.state = resumed.simulation.resume(half);
  EXPECT_LT(resumed.state.time, 0.12);
  resumed.simulation.run(resumed.state, 0.12);
  resumed.simulation.run(resumed.state, 0.3);
  EXPECT_TRUE(same(writing.state, resumed.state));
  EXPECT_EQ(writing.simulation.statistics().evaluations, resumed.simulation.statistics().evaluations);
  EXPECT_EQ(writing.recorder.table().values, resumed.recorder.table().values);
}

TEST(CheckpointFile, that_cannot_be_written_ends_a_run_that_can_be_gone_on_with) {
  const ScratchFolder folder;
  write_text(folder.path("taken"), "a file where a folder is wanted");
  const auto draw = [](SystemGraph& graph) { draw_loop(graph, {}); };
  Machine plain(draw, smooth_methods()[8].make), failing(draw, smooth_methods()[8].make);
  failing.simulation.run(failing.state, 0.1);
  failing.simulation.checkpoint(folder.path("taken/run.h5"), every(0.05));
  const std::string message = message_of<FileError>([&] { failing.simulation.run(failing.state, 0.2); });
  EXPECT_NE(message.find("taken/run.h5"), std::string::npos) << message;
  failing.simulation.checkpoint(folder.path("run.h5"), every(0.05));
  failing.simulation.run(failing.state, 0.2);
  plain.simulation.run(plain.state, 0.1);
  plain.simulation.run(plain.state, 0.2);
  EXPECT_TRUE(same(plain.state, failing.state));
  EXPECT_EQ(failing.simulation.statistics().steps, plain.simulation.statistics().steps);
}

/// What resuming says that is to be refused.
template <class Expected>
std::string refusal(
    const std::string& path, const std::function<void(SystemGraph&)>& draw, const MakeMethod& make,
    const std::function<void(Machine&)>& change = [](Machine&) {}) {
  Machine run(draw, make);
  change(run);
  return message_of<Expected>([&] { run.simulation.resume(path); });
}

TEST(CheckpointFile, is_refused_in_another_scene_or_by_another_integrator) {
  const ScratchFolder folder;
  const std::string path = folder.path("run.h5");
  const MakeMethod make = of<ExplicitRungeKutta>({.tolerance = kTolerance});
  const auto draw_with = [](Drawing d) { return [=](SystemGraph& graph) { draw_loop(graph, d); }; };
  Machine run(draw_with({}), make);
  run.simulation.run(run.state, 0.1);
  run.simulation.save(run.state, path);
  EXPECT_EQ(refusal<Error>(path, draw_with({}), make), "");

  const auto says = [&](const std::string& message, std::initializer_list<const char*> words) {
    for (const char* word : words) EXPECT_NE(message.find(word), std::string::npos) << word << " in:\n" << message;
    EXPECT_NE(message.find(path), std::string::npos) << message;
  };
  says(refusal<SceneError>(path, draw_with({.spare = true}), make), {"another scene", "had 4", "has 5"});
  says(refusal<SceneError>(path, draw_with({.name = "lever"}), make), {"'rocker'", "'lever'"});
  says(refusal<SceneError>(path, draw_with({.mass = 1.0000001}), make), {"other parameters of body 'coupler'"});
  says(refusal<SceneError>(path, draw_with({.stiffness = 40.1}), make), {"other parameters", "'spring'"});
  says(refusal<SceneError>(path, draw_driven, make), {"'constraint'", "had 4", "has 5"});
  says(refusal<SceneError>(path, draw_with({}), of<ExplicitRungeKutta>({.tolerance = {1e-5, 1e-8}})),
       {"relative tolerance", "1e-06", "1e-05"});
  says(refusal<SceneError>(path, draw_with({}), of<MoreauJean>({.step = 1e-3})),
       {"integrator", "Moreau-Jean", "explicit Runge-Kutta 5(4)"});
  const auto another_event = [](Machine& r) {
    r.simulation.on({.name = "more", .function = [](Snapshot& now) { return now.state().v[1] - 1; }});
  };
  says(refusal<SceneError>(path, draw_with({}), make, another_event), {"events/count"});
  Recorder more({Machine::coordinate_of_first()});
  const auto another_observer = [&](Machine& r) { r.simulation.observe(more, every(0.1)); };
  EXPECT_EQ(refusal<Error>(path, draw_with({}), make, another_observer), "");  // it begins here
  // Of this program, other versions and numbers cannot be had: they are told from attributes of the file.
  const auto with = [&](const char* name, auto value) {
    const std::string other = folder.path("other.h5");
    const Archive archive = read_checkpoint(path);
    write_checkpoint(archive, other);
    {
      Hdf5Writer file(other);
      for (const auto& [key, text] : std::map<std::string, std::string>{
               {"kind", "lithe checkpoint"}, {"lithe", "0.1.0"}, {"byte order", "little"}})
        if (key != name) file.attribute("/", key, text);
      for (const auto& [key, number] : std::map<std::string, std::int64_t>{{"format", 1}, {"bytes of a number", 8}})
        if (key != name) file.attribute("/", key, number);
      file.attribute("/", name, value);
      file.commit();
    }
    const std::string message = refusal<FileError>(other, draw_with({}), make);
    EXPECT_NE(message.find(other), std::string::npos) << message;
    return message;
  };
  EXPECT_NE(with("format", std::int64_t{7}).find("has format 7, known is 1"), std::string::npos);
  EXPECT_NE(with("lithe", std::string("0.0.9")).find("of Lithe 0.0.9"), std::string::npos);
  EXPECT_NE(with("bytes of a number", std::int64_t{4}).find("have 4 bytes"), std::string::npos);
  EXPECT_NE(with("byte order", std::string("big")).find("big end first"), std::string::npos);
  EXPECT_NE(with("kind", std::string("lithe table")).find("not a checkpoint but a 'lithe table'"), std::string::npos);
}

TEST(CheckpointFile, is_refused_wherever_it_is_damaged_or_cut) {
  const ScratchFolder folder;
  const std::string path = folder.path("run.h5"), other = folder.path("other.h5");
  const auto draw = [](SystemGraph& graph) { draw_loop(graph, {}); };
  const MakeMethod make = of<ExplicitRungeKutta>({.tolerance = kTolerance});
  Machine run(draw, make);
  run.simulation.run(run.state, 0.1);
  run.simulation.save(run.state, path);
  const std::string good = file_text(path);
  std::mt19937 random(5);
  int refused = 0, same_content = 0;
  for (int i = 0; i < 200; ++i) {
    std::string bad = good;
    if (i % 4 == 0)
      bad.resize(random() % bad.size());
    else
      bad[random() % bad.size()] ^= static_cast<char>(1 << random() % 8);
    write_text(other, bad);
    try {
      const Archive read = read_checkpoint(other);
      same_content += read.bytes() == read_checkpoint(path).bytes();  // in a gap of the format
      EXPECT_TRUE(read.bytes() == read_checkpoint(path).bytes());
    } catch (const FileError& error) {
      ++refused;
      EXPECT_FALSE(error.fix().empty());
    }
  }
  EXPECT_EQ(refused + same_content, 200);
  EXPECT_GT(refused, 120);
}

// ---- kills ----

/// What is told how far a run has come, in memory that its killer shares.
class Progress final : public Observer {
 public:
  explicit Progress(double* shared) : shared_(shared) {}
  void observe(Snapshot& snapshot) override { *shared_ = snapshot.time(); }

 private:
  double* shared_;
};

struct Killed {
  static constexpr double kEnd = 1.0, kRows = 0.01, kCheckpoints = 0.03, kLongestStep = 0.05;
  Machine run;
  std::string folder;
  Killed(const std::string& path, bool text)
      : run([](SystemGraph& graph) { draw_loop(graph, {}); }, of<ExplicitRungeKutta>({.tolerance = kTolerance})),
        folder(path) {
    rows_path = path + (text ? "/rows.csv" : "/rows.h5");
    rows.stream(rows_path);
    run.simulation.observe(rows, every(kRows));
    run.simulation.checkpoint(checkpoint(), every(kCheckpoints));
  }
  std::string checkpoint() const { return folder + "/run.h5"; }
  Table read() const { return rows_path.ends_with(".csv") ? read_csv(rows_path) : read_hdf5_table(rows_path); }
  std::string rows_path;
  Recorder rows{{Machine::coordinate_of_first()}};
};

TEST(KilledRun, loses_no_more_than_an_interval_and_goes_on_with_the_same_bits) {
  const ScratchFolder folder;
  auto* reached =
      static_cast<double*>(::mmap(nullptr, sizeof(double), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0));
  // How long it takes, and how it ends.
  std::filesystem::create_directories(folder.path("whole"));
  Killed whole(folder.path("whole"), true);
  const auto begun = std::chrono::steady_clock::now();
  whole.run.simulation.run(whole.run.state, Killed::kEnd);
  const double microseconds =
      std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - begun).count();
  const std::string expected = file_text(whole.rows_path);

  std::mt19937 random(11);
  int resumed = 0, with_rows = 0;
  for (int i = 0; i < 100; ++i) {
    const std::string place = folder.path("run" + std::to_string(i));
    std::filesystem::create_directories(place);
    *reached = -1;
    const pid_t child = ::fork();
    if (child == 0) {
      Killed run(place, i % 2 == 0);
      Progress progress(reached);
      run.run.simulation.observe(progress, every_step());
      run.run.simulation.run(run.run.state, Killed::kEnd);
      ::_exit(0);
    }
    ASSERT_GT(child, 0);
    ::usleep(static_cast<useconds_t>(microseconds * std::uniform_real_distribution<double>(0, 1)(random)));
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);

    Killed again(place, i % 2 == 0);
    if (std::filesystem::exists(again.rows_path)) {  // it opens, and lacks little
      const Table rows = again.read();
      ++with_rows;
      EXPECT_GE(rows.row_count() > 0 ? rows.at(rows.row_count() - 1, 0) : 0,
                *reached - Killed::kRows - Killed::kLongestStep);
      EXPECT_LE(rows.row_count(), whole.rows.table().row_count());
    }
    if (!std::filesystem::exists(again.checkpoint())) {
      EXPECT_LE(*reached, Killed::kLongestStep);
      continue;
    }
    ++resumed;
    // Progress came after the recorders: a place is kept for it.
    double unused = 0;
    Progress progress(&unused);
    again.run.simulation.observe(progress, every_step());
    again.run.state = again.run.simulation.resume(again.checkpoint());
    EXPECT_GE(again.run.state.time, *reached - Killed::kCheckpoints - Killed::kLongestStep);
    again.run.simulation.run(again.run.state, Killed::kEnd);
    EXPECT_TRUE(same(again.run.state, whole.run.state)) << i;
    EXPECT_EQ(again.rows.table().values, whole.rows.table().values) << i;
    EXPECT_EQ(again.read().values, whole.rows.table().values) << i;
    if (i % 2 == 0) {
      EXPECT_EQ(file_text(again.rows_path), expected);
    }
  }
  EXPECT_GT(resumed, 40);
  EXPECT_GT(with_rows, 40);
  ::munmap(reached, sizeof(double));
}

}  // namespace
}  // namespace lithe::test::restart_test
