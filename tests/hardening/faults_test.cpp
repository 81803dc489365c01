// What goes wrong around a run gives one Error that says what, where and how to fix it, and what was computed is kept.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sys/mount.h>
#include <sys/resource.h>

#include <csignal>
#include <map>
#include <optional>

#include "bodies/flexible/basis_file.h"
#include "bodies/flexible/flexible_body.h"
#include "bodies/flexible/reduction.h"
#include "bodies/flexible/result_writer.h"
#include "engine/base/interrupt.h"
#include "engine/observe/recorder.h"
#include "engine/output/binary.h"
#include "engine/output/csv.h"
#include "engine/output/hdf5_file.h"
#include "engine/output/hdf5_table.h"
#include "engine/output/vtu.h"
#include "joints/fixed_joint.h"
#include "joints/revolute_joint.h"
#include "tests/bodies/bar_model.h"
#include "tests/engine/output/output_scratch_folder.h"
#include "tests/hardening/failing_memory.h"
#include "tests/hardening/troubles.h"
#include "tests/support/methods.h"

namespace lithe::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;

constexpr double kStep = 1e-2;

std::shared_ptr<const ModalBasis> bar_basis() {
  static const auto basis = [] {
    const FiniteElementModel bar = bar_model({.bricks = {3, 1, 1}});
    return make_basis(bar, TangentFrame{bar.node_set("start")}, 3);
  }();
  return basis;
}

/// A rod or a flexible bar on a pin, and room for something that goes wrong.
struct Pendulum {
  explicit Pendulum(bool flexible = false) {
    const Matrix3 y_axis = rotation_about({1, 0, 0}, -M_PI / 2);
    Marker at_pin;
    if (flexible) {
      auto& bar = graph.add<FlexibleBody>("bar", {.basis = bar_basis()});
      at_pin = bar.average(bar_basis()->node_sets.at("start"), y_axis);
      tip = bar.average(bar_basis()->node_sets.at("end"));
    } else {
      auto& rod = graph.add<RigidBody>("rod", {.mass = 2, .inertia = {1e-2, 0.2, 0.2}, .position = {0.5, 0, 0}});
      at_pin = rod.marker({-0.5, 0, 0}, y_axis);
      tip = rod.marker({0.5, 0, 0});
    }
    graph.add<RevoluteJoint>("pin", {graph.ground().marker({0, 0, 0}, y_axis), at_pin});
  }
  SystemGraph graph{{.gravity = {0, 0, -9.81}}};
  Marker tip;
};

/// What `f` throws, as printed, and that it is an Error of the expected kind.
template <class Expected, class F>
std::string message(F&& f) {
  try {
    f();
  } catch (const Expected& error) {
    EXPECT_FALSE(error.problem().empty());
    EXPECT_FALSE(error.where().empty());
    EXPECT_FALSE(error.fix().empty());
    return error.what();
  } catch (const std::exception& error) {
    ADD_FAILURE() << "another kind of error: " << error.what();
  }
  return "";
}

// ---- elements, observers and events of a user ----

struct Case {
  const char* what;
  Trouble trouble;
  bool flexible;
  Method (*method)();
  const char* method_name;
};

class UsersCode : public testing::TestWithParam<Case> {
 protected:
  /// Runs to 0.6 s, which fails at 0.305 s, or at the next time of an observer; returns the message. State and rows are
  /// those up to there.
  std::string run(
      SystemGraph& graph, const std::function<void(Simulation&)>& prepare = [](Simulation&) {}, double latest = 0.31) {
    const System system = assemble(graph);
    State state = system.initial_state();
    const Method method = GetParam().method();
    Simulation simulation(system, *method);
    Recorder recorder{{total_energy()}};
    simulation.observe(recorder, every(0.05));
    prepare(simulation);
    const std::string text = message<SimulationError>([&] { simulation.run(state, 0.6); });
    EXPECT_GT(state.time, 0.24);
    EXPECT_LE(state.time, latest + 1e-9);
    for (const VectorX* x : {&state.q, &state.v, &state.v_dot}) EXPECT_TRUE(x->allFinite());
    const ScratchFolder folder;
    recorder.write_csv(folder.path("energy.csv"));
    const Table kept = read_csv(folder.path("energy.csv"));
    EXPECT_GE(kept.row_count(), 5);
    EXPECT_LE(kept.at(kept.row_count() - 1, 0), state.time);
    // It goes on from there, up to the same trouble.
    State again = state;
    const std::string next = message<SimulationError>([&] { simulation.run(again, 0.6); });
    EXPECT_LE(again.time, latest + 1e-9);
    EXPECT_FALSE(next.empty());
    return text;
  }
  When when() const { return {.trouble = GetParam().trouble}; }
  std::string cause() const {
    return GetParam().trouble == Trouble::throws         ? "threw: no such entry in the table"
           : GetParam().trouble == Trouble::not_a_number ? "not finite"
                                                         : "not a std::exception";
  }
  testing::Matcher<std::string> tells(const std::string& name) const {
    return AllOf(HasSubstr("'" + name + "'"), HasSubstr(cause()), HasSubstr("faults_test.cpp:"), HasSubstr("t = 0."),
                 HasSubstr("fix:  "));
  }
};

TEST_P(UsersCode, in_a_force_is_told_by_name_line_and_time) {
  Pendulum p(GetParam().flexible);
  p.graph.add<TroubledForce>("wind", {p.tip}, when());
  EXPECT_THAT(run(p.graph), tells("wind"));
}

TEST_P(UsersCode, in_a_joint_is_told_by_name_line_and_time) {
  Pendulum p(GetParam().flexible);
  auto& bob = p.graph.add<RigidBody>("bob", {.position = {1, 0, 0}});
  p.graph.add<TroubledBall>("ball", {p.tip, bob.marker()}, when());
  EXPECT_THAT(run(p.graph), tells("ball"));
}

TEST_P(UsersCode, in_a_body_is_told_by_name_line_and_time) {
  Pendulum p(GetParam().flexible);
  p.graph.add<TroubledSlider>("slider", when());
  EXPECT_THAT(run(p.graph), tells("slider"));
}

TEST_P(UsersCode, in_a_sensor_is_told_by_name_line_and_time) {
  Pendulum p(GetParam().flexible);
  Recorder sick{
      {Sensor{"sag", {"sag"}, [&](Snapshot& now, std::span<double> out) { out[0] = when().check(now.time()); }}}};
  const std::string text = run(
      p.graph, [&](Simulation& s) { s.observe(sick, every(0.05)); }, 0.35);
  EXPECT_THAT(text, AllOf(HasSubstr("'sag'"), HasSubstr("faults_test.cpp:"), HasSubstr("t = 0.35")));
  EXPECT_EQ(sick.table().row_count(), 7);
}

/// Observers return nothing, so they cannot give NaN.
class UsersObserver : public UsersCode {};

TEST_P(UsersObserver, is_told_by_its_type_and_time) {
  Pendulum p(GetParam().flexible);
  Caller caller([&](double now) { when().check(now); });
  const std::string text = run(
      p.graph, [&](Simulation& s) { s.observe(caller, every(0.05)); }, 0.35);
  EXPECT_THAT(text, AllOf(HasSubstr("lithe::test::Caller"), HasSubstr(cause()), HasSubstr("t = 0.35")));
}

TEST_P(UsersCode, in_the_function_or_change_of_an_event_is_told_by_name_and_time) {
  Pendulum p(GetParam().flexible);
  const auto function = [&](Simulation& s) {
    s.on({.name = "alarm", .function = [&](Snapshot& now) { return 1 + when().check(now.time()); }});
  };
  EXPECT_THAT(run(p.graph, function), AllOf(HasSubstr("event 'alarm'"), HasSubstr("t = 0.")));
  if (GetParam().trouble == Trouble::not_a_number) return;
  const auto change = [&](Simulation& s) {
    s.on({.name = "kick",
          .function = [](Snapshot& now) { return now.time() - 0.306; },
          .action = Event::Action::restart,
          .change = [&](State& state) { when().check(state.time); }});
  };
  EXPECT_THAT(run(p.graph, change), AllOf(HasSubstr("event 'kick'"), HasSubstr(cause()), HasSubstr("t = 0.306")));
}

Method generalized_alpha() { return index3(kStep); }
Method fixed_runge_kutta() { return runge_kutta_fixed(kStep); }
Method free_runge_kutta() { return runge_kutta(1e-6); }
Method free_radau() { return radau(1e-6); }
Method free_ida() { return ida(1e-6); }

const Case kThrows[] = {{"a_throw", Trouble::throws, false, generalized_alpha, "alpha"},
                        {"a_throw", Trouble::throws, false, fixed_runge_kutta, "runge_kutta"},
                        {"a_throw", Trouble::throws, false, free_ida, "ida"},
                        {"a_throw", Trouble::throws, true, free_radau, "radau"},
                        {"a_strange_throw", Trouble::throws_no_exception, true, generalized_alpha, "alpha"}};
const Case kNan[] = {{"nan", Trouble::not_a_number, false, generalized_alpha, "alpha"},
                     {"nan", Trouble::not_a_number, false, fixed_runge_kutta, "runge_kutta"},
                     {"nan", Trouble::not_a_number, false, free_runge_kutta, "free_runge_kutta"},
                     {"nan", Trouble::not_a_number, false, free_ida, "ida"},
                     {"nan", Trouble::not_a_number, true, generalized_alpha, "alpha"},
                     {"nan", Trouble::not_a_number, true, free_radau, "radau"}};

std::string case_name(const testing::TestParamInfo<Case>& test) {
  return std::string(test.param.what) + "_" + test.param.method_name + (test.param.flexible ? "_flexible" : "_rigid");
}

/// The plate that the ball is on has become a part of the ground.
TEST(SimplerScene, NamesTheJointThatGivesNoNumber) {
  Pendulum pendulum;
  auto& plate = pendulum.graph.add<RigidBody>("plate", {.position = {1, 0, 0}});
  auto& rod = pendulum.graph.add<RigidBody>("rod 2", {.mass = 2, .inertia = {1e-2, 0.2, 0.2}, .position = {1.5, 0, 0}});
  pendulum.graph.add<FixedJoint>("mount", {pendulum.graph.ground().marker({1, 0, 0}), plate.marker()});
  pendulum.graph.add<TroubledBall>("ball", {plate.marker(), rod.marker({-0.5, 0, 0})}, When{Trouble::not_a_number});
  Simulation simulation(pendulum.graph, [] { return index3(kStep); }, {.simplify = true, .sleep = false});
  State state = simulation.start();
  EXPECT_THAT(message<SimulationError>([&] { simulation.run(state, 0.6); }),
              AllOf(HasSubstr("'ball' ("), HasSubstr("gives a value that is not finite")));
}

INSTANTIATE_TEST_SUITE_P(Throws, UsersCode, testing::ValuesIn(kThrows), case_name);
INSTANTIATE_TEST_SUITE_P(Nan, UsersCode, testing::ValuesIn(kNan), case_name);
INSTANTIATE_TEST_SUITE_P(Throws, UsersObserver, testing::ValuesIn(kThrows), case_name);

TEST(UsersException, is_kept_within_the_error) {
  Pendulum p;
  p.graph.add<TroubledForce>("wind", {p.tip}, {.trouble = Trouble::throws});
  const System system = assemble(p.graph);
  State state = system.initial_state();
  const Method method = generalized_alpha();
  try {
    Simulation(system, *method).run(state, 1);
    FAIL();
  } catch (const SimulationError& error) {
    EXPECT_THROW(std::rethrow_if_nested(error), std::out_of_range);
  }
}

// ---- no memory ----

/// A scene from its drawing to its files. What is kept after a failure: the state, the rows, and no half of a file.
struct WholeRun {
  WholeRun(bool flexible, bool hdf5, const std::string& path)
      : p(flexible), with_hdf5(hdf5), files{path + ".csv", path + ".table", path + ".h5"} {
    // A file that takes the place of an older one is flushed to the disk by some file systems: slow.
    for (const std::string& file : files) std::filesystem::remove(file);
  }

  void assemble_it() {
    System made = assemble(p.graph);
    state = made.initial_state();
    system.emplace(std::move(made));
  }
  void run() {
    if (!ready) {
      simulation.emplace(*system, *method);
      simulation->observe(recorder, every(0.02));
      ready = true;
    }
    simulation->run(state, 0.06);
    done = true;
  }
  void write() {
    recorder.write_csv(files[0]);
    recorder.write_binary(files[1]);
    if (with_hdf5) recorder.write_hdf5(files[2]);
  }
  /// All of it; starts again where it failed.
  void all() {
    if (!system) assemble_it();
    if (!done) run();
    write();
  }

  Pendulum p;
  bool with_hdf5;
  std::array<std::string, 3> files;
  std::optional<System> system;
  State state;
  Recorder recorder{{total_energy(), position(p.tip, "tip")}};
  const Method method = index3(kStep);
  std::optional<Simulation> simulation;
  bool ready = false, done = false;  // to run, and having run
};

struct Shortage {
  bool flexible;
  memory::Shortage shortage;
  memory::Layer layer;
};

class NoMemory : public testing::TestWithParam<Shortage> {};

/// Allocation n fails, for every n there is, and a second try goes on from what was kept. Of HDF5 alone our own
/// allocations fail: it does not outlive failures of its own.
TEST_P(NoMemory, at_any_moment_is_an_error_that_leaves_a_state_to_go_on_from_and_loses_no_block) {
  const auto [flexible, shortage, layer] = GetParam();
  const bool hdf5 = layer == memory::Layer::cpp;
  const ScratchFolder folder;
  WholeRun expected(flexible, hdf5, folder.path("expected"));
  expected.all();  // also lets the libraries allocate what they keep for good
  const int files = folder.file_count();
  int errors = 0, bare = 0;
  for (long n = 0;; ++n) {
    const long before = memory::blocks();
    bool failed = false;
    {
      WholeRun run(flexible, hdf5, folder.path("run"));
      memory::fail_at(n, shortage, layer);
      try {
        run.all();
        failed = memory::recover();
      } catch (const Error& error) {
        failed = memory::recover();
        ++errors;
        ASSERT_FALSE(error.fix().empty());
      } catch (const std::bad_alloc&) {
        failed = memory::recover();
        ++bare;
      }
      if (run.system) {
        for (const VectorX* x : {&run.state.q, &run.state.v}) ASSERT_TRUE(x->allFinite()) << "allocation " << n;
        ASSERT_EQ(run.state.q.size(), expected.state.q.size()) << "allocation " << n;
      }
      run.all();
      ASSERT_EQ(run.state.time, 0.06);
      // The integrator started anew; the fastest modes are not resolved.
      ASSERT_LT((run.state.q - expected.state.q).norm(), flexible ? 1e-3 : 1e-6) << "allocation " << n;
      ASSERT_EQ(read_csv(folder.path("run.csv")).row_count(), 4) << "allocation " << n;
      ASSERT_EQ(folder.file_count(), 2 * files) << "allocation " << n;
    }
    ASSERT_EQ(memory::blocks(), before) << "allocation " << n;
    if (!failed) break;
  }
  EXPECT_GT(errors + bare, 100);
  // The test's own copies of what assemble() returns may fail too; under a shortage that lasts there is no room for a
  // message.
  constexpr int kOwn = 10;
  EXPECT_TRUE(shortage == memory::Shortage::lasting || bare <= kOwn) << bare << ", " << errors;
}

INSTANTIATE_TEST_SUITE_P(Faults, NoMemory,
                         testing::Values(Shortage{false, memory::Shortage::once, memory::Layer::any},
                                         Shortage{false, memory::Shortage::lasting, memory::Layer::any},
                                         Shortage{false, memory::Shortage::once, memory::Layer::cpp},
                                         Shortage{true, memory::Shortage::once, memory::Layer::any},
                                         Shortage{true, memory::Shortage::lasting, memory::Layer::cpp}),
                         [](const auto& test) {
                           return std::string(test.param.flexible ? "flexible" : "rigid") +
                                  (test.param.shortage == memory::Shortage::once ? "_once" : "_lasting") +
                                  (test.param.layer == memory::Layer::cpp ? "_of_operator_new" : "");
                         });

// ---- files that cannot be written ----

using Write = std::function<void(const std::string& path)>;

Table small_table() {
  Table table{.columns = {"t", "x"}};
  for (int i = 0; i < 5000; ++i) table.add_row({i * 0.1, std::sin(0.1 * i)});
  return table;
}

/// Every writer, by the ending of its files.
std::map<std::string, Write> writers() {
  return {{"csv", [](const std::string& path) { write_csv(small_table(), path); }},
          {"table", [](const std::string& path) { write_binary(small_table(), path); }},
          {"h5", [](const std::string& path) { write_hdf5(small_table(), path); }},
          {"basis", [](const std::string& path) { write_modal_basis(*bar_basis(), path); }},
          {"vtu", [](const std::string& path) { write_vtu(path, Matrix3X::Random(3, 4000), {}, {}); }},
          {"results", [](const std::string& path) {
             Pendulum p(true);
             const System system = assemble(p.graph);
             State state = system.initial_state();
             const Method method = index3(kStep);
             Simulation simulation(system, *method);
             ResultWriter results(static_cast<const FlexibleBody&>(*system.layout().bodies()[0].body), path,
                                  {.positions = true});
             simulation.observe(results, every_step());
             simulation.run(state, 4.0);
           }}};
}

class Disk : public testing::TestWithParam<std::string> {
 protected:
  void expect_refused(const std::string& path) const {
    const std::string text = message<Error>([&] { writers().at(GetParam())(path); });
    EXPECT_THAT(text, AllOf(HasSubstr(path), HasSubstr("cannot write"), HasSubstr("fix:  choose a path")));
  }
  /// An older file of that name stays what it was.
  void expect_kept(const std::string& path) const { EXPECT_EQ(file_text(path), "older"); }
};

TEST_P(Disk, a_path_beneath_a_file_or_of_a_folder_is_refused_and_nothing_is_left) {
  const ScratchFolder folder;
  write_text(folder.path("file"), "older");
  expect_refused(folder.path("file/run." + GetParam()));
  std::filesystem::create_directory(folder.path("run." + GetParam()));
  expect_refused(folder.path("run." + GetParam()));
  EXPECT_EQ(folder.file_count(), 1);
  expect_kept(folder.path("file"));
}

/// Files that appear when they are whole. Results are there from the beginning of a run and grow by rows.
class WholeFile : public Disk {};

TEST_P(WholeFile, that_outgrows_its_limit_is_refused_and_the_older_one_stays) {
  const ScratchFolder folder;
  const std::string path = folder.path("run." + GetParam());
  write_text(path, "older");
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit old{}, small{};
  getrlimit(RLIMIT_FSIZE, &old);
  small = {4096, old.rlim_max};
  setrlimit(RLIMIT_FSIZE, &small);
  expect_refused(path);
  setrlimit(RLIMIT_FSIZE, &old);
  expect_kept(path);
  EXPECT_EQ(folder.file_count(), 1);
  writers().at(GetParam())(path);  // with room again
  EXPECT_GT(std::filesystem::file_size(path), 4096u);
}

/// A small file system of its own in a folder.
struct SmallDisk {
  SmallDisk(const std::string& folder, const char* size) : path(folder) {
    std::filesystem::create_directory(path);
    mounted = mount("lithe", path.c_str(), "tmpfs", 0, size) == 0;
  }
  ~SmallDisk() {
    if (mounted) umount(path.c_str());
  }
  SmallDisk(const SmallDisk&) = delete;
  std::string path;
  bool mounted;
};

TEST_P(Disk, a_full_one_is_told_and_what_was_written_before_stays) {
  const ScratchFolder folder;
  const bool grows = GetParam() == "results";
  const SmallDisk disk(folder.path("disk"), grows ? "size=416k" : "size=64k");
  if (!disk.mounted) GTEST_SKIP() << "may not mount a file system";
  const std::string path = disk.path + "/run." + GetParam();
  if (!grows) {
    write_text(path, "older");
    write_text(disk.path + "/filler", std::string(60000, 'x'));
  }
  expect_refused(path);
  if (!grows) return expect_kept(path);
  const Hdf5Reader rows(path);
  const MatrixX times = rows.matrix("/time");
  EXPECT_GT(times.size(), 100);
  EXPECT_NEAR(times(0, 100), 1.0, 1e-9);
  EXPECT_TRUE(rows.matrix("/frame").allFinite());
}

std::string file_name(const testing::TestParamInfo<std::string>& test) { return test.param; }
INSTANTIATE_TEST_SUITE_P(Faults, Disk, testing::Values("csv", "table", "h5", "basis", "vtu", "results"), file_name);
INSTANTIATE_TEST_SUITE_P(Faults, WholeFile, testing::Values("csv", "table", "h5", "basis", "vtu"), file_name);

TEST(Device, is_written_straight_away_and_stays_a_device) {
  const Table table = small_table();
  write_csv(table, "/dev/null");
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/null"));
  EXPECT_THAT(message<FileError>([&] { write_csv(table, "/dev/full"); }), HasSubstr("No space left on device"));
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/full"));
}

// ---- signals ----

TEST(Interrupt, ends_the_run_after_its_step_and_it_goes_on_from_there) {
  for (const int signal : {SIGINT, SIGTERM}) {
    Pendulum p;
    const System system = assemble(p.graph);
    State state = system.initial_state();
    const Method method = generalized_alpha();
    Simulation simulation(system, *method);
    Recorder recorder{{total_energy()}};
    simulation.observe(recorder, every(0.05));
    bool raised = false;
    Caller caller([&](double now) {
      if (now > 0.29 && !std::exchange(raised, true)) std::raise(signal);
    });
    simulation.observe(caller, every(0.1));
    {
      const InterruptGuard guard;
      EXPECT_THAT(message<SimulationError>([&] { simulation.run(state, 1); }),
                  AllOf(HasSubstr("interrupted by signal " + std::to_string(signal)), HasSubstr("t = 0.3")));
    }
    EXPECT_NEAR(state.time, 0.3, 1e-9);
    EXPECT_EQ(recorder.table().row_count(), 7);
    simulation.run(state, 1);
    EXPECT_EQ(state.time, 1);
    EXPECT_EQ(recorder.table().row_count(), 21);
  }
}

TEST(InterruptDeathTest, a_second_signal_and_one_that_no_run_has_seen_kill_as_usual) {
  EXPECT_EXIT(
      {
        const InterruptGuard guard;
        std::raise(SIGINT);
        std::raise(SIGINT);
      },
      testing::KilledBySignal(SIGINT), "");
  EXPECT_EXIT(
      {
        {
          const InterruptGuard guard;
          const InterruptGuard inner;
          std::raise(SIGTERM);
        }
        std::fputs("never reached", stderr);
      },
      testing::KilledBySignal(SIGTERM), "^$");
}

}  // namespace
}  // namespace lithe::test
