#include "tests/scripting/command.h"

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <fstream>

namespace lithe::test {
namespace fs = std::filesystem;

ScriptFolder::ScriptFolder() {
  const auto* test = testing::UnitTest::GetInstance()->current_test_info();
  folder_ = fs::path(LITHE_SCRIPTING_SCRATCH) / test->name();
  fs::remove_all(folder_);
  fs::create_directories(cache() / "lithe");
  const fs::path headers = fs::path(LITHE_SCRIPTING_SCRATCH) / "cache" / "lithe" / "headers";
  fs::create_directories(headers);
  fs::create_directory_symlink(headers, cache() / "lithe" / "headers");
}

void ScriptFolder::write(const std::string& name, const std::string& text) const {
  fs::create_directories((folder_ / name).parent_path());
  std::ofstream(folder_ / name) << text;
}

Outcome ScriptFolder::shell(const std::string& command) const {
  const std::string line = "cd '" + folder_.string() + "' && export XDG_CACHE_HOME='" + cache().string() +
                           "' LITHE_LOG=warn LITHE_PRECOMPILED=off && unset CXX && lithe() { '" LITHE_COMMAND
                           "' \"$@\"; } && { " +
                           command + " ; } 2>&1";
  FILE* pipe = popen(line.c_str(), "r");
  Outcome outcome{-1, ""};
  if (!pipe) return outcome;
  std::array<char, 1024> buffer{};
  while (std::fgets(buffer.data(), buffer.size(), pipe)) outcome.output += buffer.data();
  const int status = pclose(pipe);
  outcome.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return outcome;
}

int ScriptFolder::program_count() const {
  int count = 0;
  if (!fs::exists(cache() / "lithe/programs")) return 0;
  for (const auto& entry : fs::recursive_directory_iterator(cache() / "lithe/programs"))
    if (entry.path().filename().string().starts_with("program-")) ++count;
  return count;
}

std::string pendulum_scene(const std::string& elbow) {
  return R"(// Two rods on hinges swing from rest; prints how often they were recorded.
#include <cstdio>
#include <string>

#include "lithe/lithe.h"

using namespace lithe;

int main(int argc, char** argv) {
  const double seconds = argc > 1 ? std::stod(argv[1]) : 0.1;

  // 1. Draw the graph: two rods, two hinges along the world's y axis.
  SystemGraph graph{{.gravity = {0, 0, -9.81}}};
  const Vector3 slender{1e-4, 1.0 / 12, 1.0 / 12};  // kg m²
  auto& upper = graph.add<RigidBody>("upper", {.mass = 1, .inertia = slender, .position = {0.5, 0, 0}});
  auto& lower = graph.add<RigidBody>("lower", {.mass = 1, .inertia = slender, .position = {1.5, 0, 0}});
  const Matrix3 along_y = rotation_about({1, 0, 0}, -M_PI / 2);
  const Marker ground = graph.ground().marker({0, 0, 0}, along_y);
  graph.add<RevoluteJoint>("pin", {ground, upper.marker({-0.5, 0, 0}, along_y)});
  )" + elbow +
         R"(
  const Marker tip = lower.marker({0.5, 0, 0});

  // 2. Assemble: the topology is now fixed.
  const System system = assemble(graph);
  State state = system.initial_state();

  // 3. Say what to watch, and let it swing.
  Recorder recorder{{position(tip, "tip"), velocity(tip, "tip_v"), total_energy("energy")}};
  GeneralizedAlpha integrator{{.step = 1e-3, .spectral_radius = 0.9}};
  Simulation simulation{system, integrator};
  simulation.observe(recorder, every(0.01));
  simulation.run(state, seconds);
  recorder.write_csv("tip.csv");

  // 4. Say what came out.
  const auto energy = recorder.table().column("energy");
  std::printf("energy %.3f J\n", energy.back());
  std::printf("rows %d\n", recorder.table().row_count());
  return energy.size() > 1 ? 0 : 3;
}
)";
}

}  // namespace lithe::test
