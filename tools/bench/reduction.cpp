// Time and memory to reduce a large mesh: reduction [dofs] [modes] [interfaces] [C3D8 deck for CalculiX].
// A block 4 x 1 x 1 of 8-node bricks, mean axes, eigenmodes and static modes of interfaces on its end and side faces.
// One JSON line: seconds of each step, peak memory, the first frequencies. With a deck name, writes the same mesh as a
// CalculiX *FREQUENCY job instead: reduction_calculix.sh runs both.
#include <cstdio>
#include <cstdlib>
#include <fstream>

#include "bodies/flexible/basis_file.h"
#include "bodies/flexible/elements/meshes.h"
#include "bodies/flexible/readers/calculix_deck.h"
#include "bodies/flexible/reduction.h"
#include "tools/bench/brick_mesh.h"
#include "tools/bench/measure.h"

namespace {

using namespace lithe;
using bench::wall_seconds;

double peak_gib() { return bench::peak_memory() / (1 << 30); }

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
  double start = wall_seconds();
  if (count > 4) {
    write_deck(mesh, modes, words[4]);
    return 0;
  }
  const FiniteElementModel model = bench::brick_model(mesh);
  const double assembly = wall_seconds() - start, before = peak_gib();
  start = wall_seconds();
  const auto basis = make_basis(model, MeanAxisFrame{}, modes, {.loaded = interfaces_of(model, interfaces)});
  const double reduction = wall_seconds() - start, peak = peak_gib();
  const std::string path = "reduction_benchmark.h5";
  start = wall_seconds();
  write_modal_basis(*basis, path);
  const double saving = wall_seconds() - start;
  start = wall_seconds();
  const auto read = read_modal_basis(path);
  const double loading = wall_seconds() - start;
  std::remove(path.c_str());
  bench::JsonLine line;
  line.add("dofs", model.dof_count()).add("modes", modes).add("interfaces", interfaces).add("kept", read->mode_count());
  line.add("assembly_s", assembly).add("reduction_s", reduction).add("mesh_gib", before, 3).add("peak_gib", peak, 3);
  line.add("save_s", saving).add("load_s", loading);
  line.add("frequencies_hz", {basis->frequencies[0], basis->frequencies[1], basis->frequencies[2]}, 10).print();
}
