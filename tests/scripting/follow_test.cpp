#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <thread>

#include "tests/engine/output/output_scratch_folder.h"
#include "tests/scripting/command.h"
#include "tests/support/http_client.h"

/// `lithe view --follow`, with the test as its browser.
namespace lithe::test::follow_test {
namespace {

/// The address that the command prints into a file.
LiveAddress wait_for_address(const std::string& file) {
  std::string text;
  for (int i = 0; i < 3000 && text.find("/\n") == std::string::npos; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    text = file_text(file);
  }
  const std::size_t from = text.find("http://");
  if (from == std::string::npos) throw std::runtime_error("no address in: " + text);
  return LiveAddress(text.substr(from, text.find('\n', from) - from));
}

TEST(Follow, ASceneThatRecordsNoRunIsShownAndItsResultsAreTheSame) {
  const ScriptFolder folder;
  folder.write("scene.cpp", pendulum_scene());
  ASSERT_EQ(folder.shell("lithe run scene.cpp 0.5").exit_code, 0);
  const std::string alone = file_text(folder.path() / "tip.csv");

  Outcome outcome{};
  std::jthread running([&] { outcome = folder.shell("lithe view --follow scene.cpp 0.5 2> address.txt"); });
  const LiveAddress address = wait_for_address(folder.path() / "address.txt");
  EXPECT_TRUE(address.get("").starts_with("HTTP/1.1 200"));
  LiveFrames frames(address);
  frames.read(std::string::npos);
  running.join();
  EXPECT_TRUE(frames.is_over());
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_NE(outcome.output.find("rows 51\n"), std::string::npos) << outcome.output;
  EXPECT_EQ(file_text(folder.path() / "tip.csv"), alone);
  // Every hundredth of the run, at the steps that first reach it.
  ASSERT_GT(frames.frames.size(), 50u);
  for (std::size_t i = 1; i < frames.frames.size(); ++i)
    EXPECT_GE(frames.frames[i][0] - frames.frames[i - 1][0], 0.005 - 1e-9);
}

TEST(Follow, APortThatIsInUseAndOptionsThatDoNotFitAreToldSo) {
  const ScriptFolder folder;
  folder.write("scene.cpp", pendulum_scene());
  Outcome outcome{};
  std::jthread running([&] { outcome = folder.shell("lithe view --follow scene.cpp 60 2> address.txt"); });
  const LiveAddress address = wait_for_address(folder.path() / "address.txt");
  const Outcome taken = folder.shell("lithe view --follow --port " + std::to_string(address.port) + " scene.cpp");
  EXPECT_EQ(taken.exit_code, 1);
  EXPECT_NE(taken.output.find("cannot be had: Address already in use"), std::string::npos) << taken.output;
  EXPECT_NE(folder.shell("lithe view --follow -o page.html scene.cpp").exit_code, 0);
  EXPECT_NE(folder.shell("lithe view --port 80 run.h5").exit_code, 0);

  // The page ends the run; the scene goes on behind it, and finds that time is missing.
  LiveFrames frames(address);
  address.post(R"({"do": "stop"})");
  running.join();
  // However far it came: one state, or some more where the machine is busy; never the 6,001 of a minute.
  const std::size_t told = outcome.output.find("rows ");
  ASSERT_NE(told, std::string::npos) << outcome.output;
  const int rows = std::stoi(outcome.output.substr(told + 5));
  EXPECT_LT(rows, 6000);
  EXPECT_EQ(outcome.exit_code, rows > 1 ? 0 : 3) << "the scene finds that states are missing; " << outcome.output;
  EXPECT_TRUE(std::filesystem::exists(folder.path() / "tip.csv"));
}

}  // namespace
}  // namespace lithe::test::follow_test
