// Time and memory to reduce a large mesh: reduction [dofs] [modes] [interfaces] [C3D8 deck for CalculiX].
// A block 4 x 1 x 1 of 8-node bricks, mean axes, eigenmodes and static modes of interfaces on its end and side faces.
// One JSON line: seconds of each step, peak memory, the first frequencies. With a deck name, writes the same mesh as a
// CalculiX *FREQUENCY job instead: reduction_calculix.sh runs both.
#include <sys/resource.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>

#include "bodies/flexible/basis_file.h"
#include "bodies/flexible/elements/meshes.h"
#include "bodies/flexible/readers/calculix_deck.h"
#include "bodies/flexible/reduction.h"
#include "tools/bench/brick_mesh.h"

namespace {

using namespace lithe;
using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

double peak_gib() {
  rusage used{};
  getrusage(RUSAGE_SELF, &used);
  return static_cast<double>(used.ru_maxrss) / (1 << 20);
}

bench::BrickMesh block_of(int dofs) {
  // (4 k + 1)(k + 1)² nodes.
  int k = 1;
  while (3 * (4 * (k + 1) + 1) * (k + 2) * (k + 2) <= dofs) ++k;
  return {.bricks = {4 * k, k, k}, .size = {0.4, 0.1, 0.1}, .young = 2.1e11, .poisson = 0.3, .density = 7800};
}

/// Faces of the block: x = 0, x = end, y = 0, z = 0.
std::vector<WeightedNodes> interfaces_of(const FiniteElementModel& model, int count) {
  const Vector3 high = model.nodes.rowwise().maxCoeff();
  std::vector<WeightedNodes> found(static_cast<size_t>(count));
  for (int i = 0; i < model.node_count(); ++i) {
    const Vector3 r = model.nodes.col(i);
    const bool middle = std::abs(r.x() - high.x() / 2) < 0.05 * high.x();
    const bool on[] = {r.x() == 0, r.x() == high.x(), r.y() == 0 && middle, r.z() == 0 && middle};
    for (int k = 0; k < count; ++k)
      if (on[k]) found[static_cast<size_t>(k)].ids.push_back(i + 1);
  }
  return found;
}

void write_deck(const bench::BrickMesh& mesh, int modes, const char* path) {
  write_calculix_deck(path, brick_mesh({.size = mesh.size,
                                        .divisions = mesh.bricks,
                                        .type = "C3D8",
                                        .material = {mesh.young, mesh.poisson, mesh.density},
                                        .name = "block"}));
  std::ofstream(path, std::ios::app) << "*STEP\n*FREQUENCY\n" << modes + 6 << "\n*NODE FILE\nU\n*END STEP\n";
}

}  // namespace

int main(int count, char** words) {
  const auto number = [&](int k, int otherwise) { return count > k ? std::atoi(words[k]) : otherwise; };
  const int modes = number(2, 30), interfaces = number(3, 4);
  const bench::BrickMesh mesh = block_of(number(1, 30000));
  auto start = Clock::now();
  if (count > 4) {
    write_deck(mesh, modes, words[4]);
    return 0;
  }
  const FiniteElementModel model = bench::brick_model(mesh);
  const double assembly = seconds_since(start), before = peak_gib();
  start = Clock::now();
  const auto basis = make_basis(model, MeanAxisFrame{}, modes, {.loaded = interfaces_of(model, interfaces)});
  const double reduction = seconds_since(start), peak = peak_gib();
  const std::string path = "reduction_benchmark.h5";
  start = Clock::now();
  write_modal_basis(*basis, path);
  const double saving = seconds_since(start);
  start = Clock::now();
  const auto read = read_modal_basis(path);
  const double loading = seconds_since(start);
  std::remove(path.c_str());
  std::printf(
      "{\"dofs\": %d, \"modes\": %d, \"interfaces\": %d, \"kept\": %d, \"assembly_s\": %.3f, \"reduction_s\": %.3f, "
      "\"mesh_gib\": %.2f, \"peak_gib\": %.2f, \"save_s\": %.3f, \"load_s\": %.4f, \"frequencies_hz\": [%.6f, %.6f, "
      "%.6f]}\n",
      model.dof_count(), modes, interfaces, read->mode_count(), assembly, reduction, before, peak, saving, loading,
      basis->frequencies[0], basis->frequencies[1], basis->frequencies[2]);
}
