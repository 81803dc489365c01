// reference NAME|all FOLDER: scenes in nonlinear finite elements (bricks in the inertial frame), each run at two
// tolerances. The finer run goes to FOLDER/NAME.csv; by how much the two differ, to FOLDER/references.json. Beams: with
// two numbers of elements, extrapolated; a tenth of what that changes in the finer run.
#include <algorithm>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>

#include "integrators/radau.h"
#include "tools/certify/scenes.h"

using namespace lithe;
using namespace lithe::certify;

namespace {

constexpr double kCoarse = 1e-7, kFine = 1e-8;  // tolerances

Sampled run_at(const Scene& scene, double tolerance, bool finer) {
  Radau integrator{{.tolerance = {tolerance, 0.01 * tolerance}}};
  return run_for_reference(scene, integrator, finer);
}

/// Beams err by the square of their elements' length: what is left of it in the finer run goes out.
void extrapolate(Table& fine, const Table& coarse) {
  for (std::size_t i = 0; i < fine.values.size(); ++i) fine.values[i] += (fine.values[i] - coarse.values[i]) / 3;
}

/// Twelve digits: what the references are good for, at half the size.
void write_short_csv(const Table& table, const std::string& path) {
  std::ofstream out(path);
  for (size_t i = 0; i < table.columns.size(); ++i) out << (i ? "," : "") << table.columns[i];
  for (size_t i = 0; i < table.values.size(); ++i) {
    char text[32];
    std::snprintf(text, sizeof text, "%.12g", table.values[i]);
    out << (i % table.columns.size() ? ',' : '\n') << text;
  }
  out << '\n';
  if (!out.flush()) throw FileError("cannot write it", path, "see whether the folder exists and is not full");
}

nlohmann::json read_if_there(const std::string& path) {
  std::ifstream in(path);
  return in ? nlohmann::json::parse(in) : nlohmann::json::object();
}

}  // namespace

int main(int count, char** arguments) try {
  if (count != 3) {
    std::printf("usage: reference NAME|all FOLDER\n");
    return 2;
  }
  const std::string chosen = arguments[1], folder = arguments[2], sheet = folder + "/references.json";
  bool good = true;
  for (const Scene& scene : chosen == "all" ? scenes() : std::vector<Scene>{find_scene(chosen)}) {
    if (scene.known) continue;  // its reference came with its data
    const Sampled coarse = run_at(scene, kCoarse, false);
    Sampled fine = run_at(scene, kFine, true);
    const Table finer = fine.table;
    if (scene.beam_elements > 0) extrapolate(fine.table, coarse.table);
    const std::vector<double> error =
        deviations(fine.watched, scene.beam_elements > 0 ? finer : coarse.table, fine.table);
    // What extrapolation leaves is of fourth order: less than a tenth of what it takes out.
    const double largest = (scene.beam_elements > 0 ? 0.1 : 1) * *std::max_element(error.begin(), error.end());
    std::printf("%-28s %5.1f s + %5.1f s of CPU, error %.1e\n", scene.name.c_str(), coarse.cpu, fine.cpu, largest);
    std::fflush(stdout);
    write_short_csv(fine.table, folder + "/" + scene.name + ".csv");
    nlohmann::json all = read_if_there(sheet);
    all[scene.name] = {{"error", largest}, {"cpu", fine.cpu}, {"coordinates", fine.coordinates}};
    std::ofstream(sheet) << all.dump(1) << '\n';
    good &= largest < 2e-4;
  }
  return good ? 0 : 1;
} catch (const Error& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
