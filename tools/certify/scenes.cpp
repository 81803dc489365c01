#include "tools/certify/scenes.h"

#include <algorithm>
#include <cmath>

#include "engine/observe/recorder.h"
#include "engine/output/csv.h"
#include "engine/run/simulation.h"
#include "tools/bench/measure.h"

namespace lithe::certify {

std::vector<Scene> scenes() {
  std::vector<Scene> all;
  add_pendulums(all);
  add_mechanisms(all);
  add_robots(all);
  add_flights(all);
  add_structures(all);
  add_beams(all);
  add_contacts(all);
  add_long_runs(all);
  add_large_and_weak(all);
  for (std::size_t i = 0; i < all.size(); ++i) all[i].seen = i % 2 == 0;
  return all;
}

Scene find_scene(const std::string& name) {
  std::string known;
  for (const Scene& scene : scenes()) {
    if (scene.name == name) return scene;
    known += (known.empty() ? "" : ", ") + scene.name;
  }
  throw SceneError("no scene '" + name + "'", "tools/certify", "known are " + known);
}

Table reference_of(const Scene& scene) {
  return scene.known ? scene.known() : read_csv(LITHE_SOURCE_DIR "/tools/certify/references/" + scene.name + ".csv");
}

Sampled run(const Scene& scene, ElasticParts& parts, Integrator& integrator) {
  SystemGraph graph{{.gravity = scene.gravity}};
  const std::vector<Sensor> watched = scene.draw(graph, parts);
  Recorder recorder(watched);
  const double start = bench::cpu_seconds();
  const System system = assemble(graph);
  State state = system.initial_state();
  Simulation simulation{system, integrator};
  simulation.observe(recorder, every(scene.duration / scene.samples));
  simulation.run(state, scene.duration);
  const double cpu = bench::cpu_seconds() - start;
  return {recorder.table(), watched, static_cast<int>(state.v.size()), cpu};
}

Sampled run_for_reference(const Scene& scene, Integrator& integrator, bool finer) {
  constexpr int kMoreModes = 30;  // of a linear reference, beside the candidates
  ElasticParts parts(scene.linear_reference ? ElasticParts::Kind::modes : ElasticParts::Kind::bricks);
  parts.more_eigenmodes = finer ? 2 * kMoreModes : kMoreModes;
  parts.elements = finer ? scene.beam_elements : scene.beam_elements / 2;
  return run(scene, parts, integrator);
}

std::vector<double> deviations(const std::vector<Sensor>& watched, const Table& table, const Table& reference) {
  std::vector<double> found;
  const int rows = std::min(table.row_count(), reference.row_count());
  int first = 1;
  for (const Sensor& sensor : watched) {
    const int columns = static_cast<int>(sensor.columns().size());
    double off = 0, change = 0;
    for (int row = 0; row < rows; ++row) {
      double off_squared = 0, change_squared = 0;
      for (int column = first; column < first + columns; ++column) {
        off_squared += std::pow(table.at(row, column) - reference.at(row, column), 2);
        change_squared += std::pow(reference.at(row, column) - reference.at(0, column), 2);
      }
      off = std::max(off, std::sqrt(off_squared));
      change = std::max(change, std::sqrt(change_squared));
    }
    found.push_back(off / change);
    first += columns;
  }
  return found;
}

MotionLaw run_up(double rate, double time) {
  return [=](double t) -> Motion {
    if (t >= time) return {rate * (t - time / 2), rate, 0};
    const double x = t / time;
    return {rate * time * std::pow(x, 4) * (2.5 - 3 * x + x * x), rate * std::pow(x, 3) * (10 - 15 * x + 6 * x * x),
            rate / time * x * x * (30 - 60 * x + 30 * x * x)};
  };
}

double pulse(double time, double begin, double end) {
  if (time <= begin || time >= end) return 0;
  return std::pow(std::sin(M_PI * (time - begin) / (end - begin)), 2);
}

Sensor relative_position(Marker marker, Marker seen_from, const std::string& name) {
  return {name, {name + "_x", name + "_y", name + "_z"}, [=](Snapshot& now, std::span<double> out) {
            const MarkerKinematics from = now.marker(seen_from);
            Eigen::Map<Vector3>(out.data()) = from.R.transpose() * (now.marker(marker).p - from.p);
          }};
}

Sensor deflection_between(Marker middle, Marker first, Marker last, const std::string& name) {
  return {name, {name + "_x", name + "_y", name + "_z"}, [=](Snapshot& now, std::span<double> out) {
            const MarkerKinematics from = now.marker(first);
            const Vector3 along = (now.marker(last).p - from.p).normalized(), arm = now.marker(middle).p - from.p;
            Eigen::Map<Vector3>(out.data()) = from.R.transpose() * (arm - along.dot(arm) * along);
          }};
}

Sensor pointing(Marker marker, const std::string& name) {
  return {name, {name + "_x", name + "_y", name + "_z"}, [=](Snapshot& now, std::span<double> out) {
            Eigen::Map<Vector3>(out.data()) = now.marker(marker).R.col(0);
          }};
}

}  // namespace lithe::certify
