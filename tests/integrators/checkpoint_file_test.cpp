// Checkpoint files: written within a run, refused where they do not fit or are damaged, and resumed after a kill.
#include <gtest/gtest.h>

#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <map>

#include "bodies/rigid_body.h"
#include "engine/output/csv.h"
#include "engine/output/hdf5_file.h"
#include "engine/output/hdf5_table.h"
#include "integrators/explicit_runge_kutta.h"
#include "integrators/moreau_jean.h"
#include "tests/engine/output/output_scratch_folder.h"
#include "tests/integrators/restart_scenes.h"

namespace lithe::test::checkpoint_file_test {
namespace {

using namespace restart;

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
      for (const auto& [key, number] : std::map<std::string, std::int64_t>{{"format", 4}, {"bytes of a number", 8}})
        if (key != name) file.attribute("/", key, number);
      file.attribute("/", name, value);
      file.commit();
    }
    const std::string message = refusal<FileError>(other, draw_with({}), make);
    EXPECT_NE(message.find(other), std::string::npos) << message;
    return message;
  };
  EXPECT_NE(with("format", std::int64_t{7}).find("has format 7, known is 4"), std::string::npos);
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
}  // namespace lithe::test::checkpoint_file_test
