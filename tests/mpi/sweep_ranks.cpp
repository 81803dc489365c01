// A program for check_ranks.cmake to start under mpirun: sweeps, and ranks that go astray.
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <fstream>
#include <string>
#include <thread>

#include "lithe/lithe.h"

using namespace lithe;

namespace {

/// A pendulum of two rods; those of negative mass fail. By Runge-Kutta and by IDA, whose library knows MPI too.
SweepValues double_pendulum(const SweepPoint& point) {
  SystemGraph graph{{.gravity = {0, 0, -9.81}}};
  const Inertia slender{1e-3, 1.0 / 12, 1.0 / 12};
  const Matrix3 along_y = rotation_about({1, 0, 0}, -M_PI / 2);
  auto& upper = graph.add<RigidBody>("upper", {.mass = point["mass"], .inertia = slender, .position = {0.5, 0, 0}});
  auto& lower = graph.add<RigidBody>("lower", {.mass = 1, .inertia = slender, .position = {1.5, 0, 0}});
  graph.add<RevoluteJoint>("shoulder",
                           {graph.ground().marker({0, 0, 0}, along_y), upper.marker({-0.5, 0, 0}, along_y)});
  graph.add<RevoluteJoint>("elbow", {upper.marker({0.5, 0, 0}, along_y), lower.marker({-0.5, 0, 0}, along_y)});
  const System system = assemble(graph);
  const auto height_after = [&](Integrator&& integrator) {
    State state = system.initial_state();
    Simulation{system, integrator}.run(state, point["time"]);
    return state.q[9];
  };
  const double tolerance = 1e-6;
  return {{"z", height_after(ExplicitRungeKutta{{.tolerance = {tolerance, tolerance}}})},
          {"z_ida", height_after(Ida{{.tolerance = {tolerance, tolerance}}})}};
}

/// Until the table that is kept lacks no more points than this rank has been handed, one a thread.
void wait_for_others(const std::string& kept) {
  for (int tries = 0; tries < 300; ++tries) {
    std::ifstream file(kept);
    int missing = 0;
    for (std::string line; std::getline(file, line);) missing += line.find("it was not computed") != std::string::npos;
    if (file.eof() && missing <= 2) return;
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
}

const Table kPoints = grid({{"mass", {1, -1, 2, 3}}, {"time", evenly_spaced(0.1, 0.5, 5)}});

}  // namespace

/// sweep_ranks FILE.csv: two sweeps, the second written.   sweep_ranks HOW: rank 1 goes astray after the first.
/// sweep_ranks HOW FILE.csv: the table of the second is kept there meanwhile.
int main(int count, char** arguments) {
  const std::string what = arguments[1], kept = count > 2 ? arguments[2] : "";
  const auto twice = [](const SweepPoint& point) -> SweepValues { return {{"twice", 2 * point["x"]}}; };
  const SweepResult first = sweep(twice, grid({{"x", evenly_spaced(0, 1, 11)}}));
  for (int row = 0; row < 11; ++row)
    if (first.table.at(row, 1) != 2 * first.table.at(row, 0)) return 2;  // on every rank

  const bool astray = first.rank == 1;
  if ((what == "leaves" && astray) || (what == "first_leaves" && !astray)) return 0;
  if (what == "throws" && astray) throw SceneError("rank 1 has had enough", "sweep_ranks", "none");
  Table points = kPoints;
  if (what == "differs" && astray) points.values[0] = 1.5;
  const SweepResult second = sweep(
      [&](const SweepPoint& point) {
        if (what == "dies" && astray) std::raise(SIGKILL);
        if ((what == "dies_late" || what == "node_dies") && astray) {
          wait_for_others(kept);
          if (what == "node_dies") kill(getppid(), SIGKILL);  // the daemon that started it
          std::raise(SIGKILL);
        }
        if (what == "first_dies") {
          if (first.rank > 0) std::this_thread::sleep_for(std::chrono::milliseconds(500));
          static std::atomic<int> own = 0;
          if (first.rank == 0 && ++own > 2) std::raise(SIGKILL);  // its first outcome is in the file by then
        }
        return double_pendulum(point);
      },
      points, {.threads = 2, .file = kept});
  second.write_csv(what);
  if (second.rank == 0) std::printf("%s", second.report().c_str());
  bool whole = second.failures.size() == 5 && second.table.row_count() == 20;
  for (int row = 0; row < 20; ++row) whole = whole && std::isnan(second.table.at(row, 2)) == (row / 5 == 1);
  return whole ? 0 : 3;
}
