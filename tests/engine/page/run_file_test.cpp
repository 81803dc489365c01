#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>

#include "bodies/rigid_body.h"
#include "engine/observe/event.h"
#include "engine/output/hdf5_file.h"
#include "engine/page/page.h"
#include "engine/run/simulation.h"
#include "integrators/generalized_alpha.h"
#include "tests/engine/page/page_reader.h"

/// Run files, read back.
namespace lithe::test::run_file_test {
namespace {

using namespace page;

TEST(RunFile, ComesBackAsItWasAndMakesTheSamePage) {
  const ScratchFolder folder;
  const auto simulate = [&](bool stream) {
    RodScene scene(Deflection::stiffened, 3);
    const System system = assemble(scene.graph);
    State state = system.initial_state();
    GeneralizedAlpha integrator{{.step = 2e-3, .spectral_radius = 0.8}};
    Simulation simulation(system, integrator);
    lithe::Run run{system, {position(scene.tip, "tip")}, {.name = "rod"}};
    if (stream) run.stream(folder.path("rod.h5"));
    simulation.observe(run, every(0.02));
    simulation.on({.name = "down", .function = watch(height(scene.tip)), .level = 0});
    simulation.run(state, 0.5);
    run.add(simulation.events());
    return run;
  };
  const lithe::Run kept = simulate(false);
  {
    const lithe::Run streamed = simulate(true);
    write_page(streamed, folder.path("streamed.html"));
  }
  write_page(kept, folder.path("kept.html"));
  const lithe::Run read = lithe::Run::read(folder.path("rod.h5"));
  write_page(read, folder.path("read.html"));
  EXPECT_EQ(read.frame_count(), 26);
  EXPECT_EQ(read.name(), "rod");
  EXPECT_EQ(read.channel("tip_z"), kept.channel("tip_z"));
  EXPECT_THROW(read.channel("tip"), SceneError);
  EXPECT_TRUE(file_text(folder.path("kept.html")) == file_text(folder.path("read.html")));
  EXPECT_TRUE(file_text(folder.path("kept.html")) == file_text(folder.path("streamed.html")));

  // Two variants on one page, under names of their own.
  const lithe::Run other = lithe::Run::read(folder.path("rod.h5"), "other");
  write_page({read, other}, folder.path("both.html"));
  const Page both(folder.path("both.html"));
  EXPECT_EQ(both.scene["title"], "rod, other");
  ASSERT_EQ(both.scene["runs"].size(), 2u);
  EXPECT_EQ(both.channel("tip_z", 0), both.channel("tip_z", 1));
  EXPECT_THROW(write_page({read, kept}, folder.path("twice.html")), SceneError);
}

TEST(RunFile, OfAProgramThatRunsOrWasKilledHoldsEveryStateThatWasObserved) {
  const ScratchFolder folder;
  for (const int states : {1, 7, 60}) {
    const std::string path = folder.path("killed" + std::to_string(states) + ".h5");
    int written[2];
    ASSERT_EQ(::pipe(written), 0);
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      SystemGraph graph;
      auto& ball = graph.add<RigidBody>("ball", {.velocity = {1, 0, 0}});
      const System system = assemble(graph);
      lithe::Run run{system, {position(ball.marker(), "ball")}};
      run.stream(path);
      State state = system.initial_state();
      Snapshot now(system);
      for (int i = 0; i < states; ++i) {
        state.time = state.q[0] = 0.01 * i;
        now.evaluate(state);
        run.observe(now);
      }
      if (::write(written[1], "x", 1) == 1) ::pause();
      ::_exit(0);
    }
    char byte = 0;
    ASSERT_EQ(::read(written[0], &byte, 1), 1);
    EXPECT_EQ(lithe::Run::read(path).frame_count(), states) << "beside the program";
    ::kill(child, SIGKILL);
    int status = 0;
    ::waitpid(child, &status, 0);
    ::close(written[0]), ::close(written[1]);
    const lithe::Run run = lithe::Run::read(path);
    EXPECT_EQ(run.frame_count(), states);
    EXPECT_DOUBLE_EQ(run.channel("ball_x").back(), 0.01 * (states - 1));
    write_page(run, folder.path("killed.html"));
  }
}

TEST(RunFile, IsRefusedWhereItIsNone) {
  const ScratchFolder folder;
  std::ofstream(folder.path("table.csv")) << "t,x\n0,1\n";
  EXPECT_EQ(told([&] { lithe::Run::read(folder.path("absent.h5")); }), "there is no such file.");
  EXPECT_EQ(told([&] { lithe::Run::read(folder.path("table.csv")); }), "this is not an HDF5 file, or it is cut short.");
  {
    Hdf5Writer other(folder.path("other.h5"));
    other.write("/rows", std::vector<double>{1, 2});
    other.commit();
  }
  EXPECT_EQ(told([&] { lithe::Run::read(folder.path("other.h5")); }), "this HDF5 file holds no run.");
  {
    Hdf5Writer later(folder.path("later.h5"));
    later.write("/rows", MatrixX::Zero(1, 1));
    later.write("/scene", std::vector<int>{'{', '}'});
    later.attribute("/", "format", "lithe run");
    later.attribute("/", "version", "9");
    later.commit();
  }
  EXPECT_NE(told([&] { lithe::Run::read(folder.path("later.h5")); }).find("version 9"), std::string::npos);

  // A run file that is cut short or changed: an error, or a run of fewer states; never a crash.
  {
    SystemGraph graph;
    auto& ball = graph.add<RigidBody>("ball", {});
    const System system = assemble(graph);
    lithe::Run run{system, {position(ball.marker(), "ball")}};
    run.stream(folder.path("run.h5"));
    State state = system.initial_state();
    Snapshot now(system);
    for (int i = 0; i < 300; ++i) {
      state.time = 0.01 * i;
      now.evaluate(state);
      run.observe(now);
    }
  }
  const std::string whole = file_text(folder.path("run.h5"));
  EXPECT_EQ(lithe::Run::read(folder.path("run.h5")).frame_count(), 300);
  // How much of a file must be there is HDF5's to say, by its version; what is read is what was written.
  for (std::size_t part = 1; part < 24; ++part) {
    std::ofstream(folder.path("cut.h5"), std::ios::binary) << whole.substr(0, whole.size() * part / 24);
    try {
      const std::vector<double> times = lithe::Run::read(folder.path("cut.h5")).channel("t");
      EXPECT_GT(part, 1u);
      EXPECT_LE(times.size(), 300u);
      for (std::size_t i = 0; i < times.size(); ++i) EXPECT_EQ(times[i], 0.01 * static_cast<double>(i));
    } catch (const FileError&) {  // NOLINT: refused
    }
  }
}

}  // namespace
}  // namespace lithe::test::run_file_test
