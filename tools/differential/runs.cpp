#include "tools/differential/runs.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "engine/archive/archive.h"
#include "engine/base/number_text.h"
#include "engine/observe/recorder.h"
#include "engine/observe/sensors.h"
#include "engine/run/simulation.h"
#include "integrators/automatic.h"
#include "integrators/explicit_runge_kutta.h"
#include "integrators/lie_bdf.h"
#include "integrators/moreau_jean.h"
#include "integrators/nonsmooth_generalized_alpha.h"
#include "integrators/radau.h"

namespace lithe::differential {
namespace {

constexpr int kLooks = 6;
double interval(const DrawnScene& scene) { return scene.duration / kLooks; }

std::unique_ptr<Integrator> make_method(const DrawnScene& scene, const Way& way) {
  const Tolerance tolerance{way.tolerance, way.tolerance * std::min(1.0, scene.units.length)};
  const double step = 1e5 * way.tolerance * scene.units.time;
  switch (way.method) {
    case Method::runge_kutta8:
      return std::make_unique<ExplicitRungeKutta>(ExplicitRungeKutta::Parameters{
          .method = ExplicitRungeKutta::Method::dormand_prince8, .tolerance = tolerance});
    case Method::radau:
      return std::make_unique<Radau>(Radau::Parameters{.tolerance = tolerance});
    case Method::bdf:
      return std::make_unique<LieBdf>(LieBdf::Parameters{.tolerance = tolerance});
    case Method::moreau_jean:
      return std::make_unique<MoreauJean>(MoreauJean::Parameters{.step = step});
    case Method::nonsmooth_alpha:
      return std::make_unique<NonsmoothGeneralizedAlpha>(NonsmoothGeneralizedAlpha::Parameters{.step = step});
    default:
      return std::make_unique<Automatic>(Automatic::Parameters{.tolerance = tolerance});
  }
}

/// A graph with its run; drawn anew for each.
class Machine {
 public:
  Machine(const DrawnScene& scene, const Way& way)
      : graph_(
            {.gravity = scene.gravity + way.nudge * Vector3(0.3, -0.5, 0.7) * scene.units.speed() / scene.units.time}) {
    for (const int i : order_of(scene, way.order)) scene.elements.begin()[i].add(graph_, way.nudge);
    std::vector<Sensor> sensors;
    for (const DrawnBody& body : scene.bodies) {
      const std::string& name = scene.elements.begin()[body.element].name;
      const Marker marker = body.watched(graph_);
      sensors.push_back(position(marker, "position of " + name));
      sensors.push_back(velocity(marker, "velocity of " + name));
    }
    sensors.push_back(total_energy("energy"));
    // Reactions are compared where they are unique, which the scene as drawn tells. Those of time stepping hold
    // impacts.
    system_.emplace(assemble(graph_));
    if (system_->redundant_rows().empty() && !scene.impacts)
      for (const std::string& joint : scene.joints)
        sensors.push_back(joint_reaction(*graph_.find<Constraint>(joint), "reaction of " + joint));
    recorder_.emplace(std::move(sensors));
    const auto make = [scene, way] { return make_method(scene, way); };
    if (way.simplify) {
      simulation_.emplace(graph_, make, SimulationOptions{.simplify = true, .sleep = false});
      state_ = simulation_->start();
    } else {
      method_ = make();
      simulation_.emplace(*system_, *method_);
      state_ = system_->initial_state();
    }
    simulation_->observe(*recorder_, every(interval(scene)));
  }
  void run(double end) { simulation_->run(state_, end); }
  void save(Archive& archive) { simulation_->save(state_, archive); }
  void resume(Archive& archive) { state_ = simulation_->resume(archive); }
  const Table& table() const { return recorder_->table(); }

 private:
  SystemGraph graph_;
  std::optional<System> system_;
  std::unique_ptr<Integrator> method_;
  std::optional<Recorder> recorder_;
  std::optional<Simulation> simulation_;
  State state_;
};

Kind kind_of(const std::string& column) {
  if (column.starts_with("position")) return Kind::position;
  if (column.starts_with("velocity")) return Kind::velocity;
  if (column.starts_with("energy")) return Kind::energy;
  return column.find("moment") == std::string::npos ? Kind::force : Kind::torque;
}

double unit_of(const Units& units, Kind kind) {
  switch (kind) {
    case Kind::position:
      return units.length;
    case Kind::velocity:
      return units.speed();
    case Kind::force:
      return units.force();
    default:
      return units.energy();
  }
}

}  // namespace

Track run(const DrawnScene& scene, const Way& way) {
  Track track;
  try {
    auto machine = std::make_unique<Machine>(scene, way);
    machine->run(kLooks / 2 * interval(scene));
    if (way.resume) {
      Archive archive;
      machine->save(archive);
      machine = std::make_unique<Machine>(scene, way);
      machine->resume(archive);
    }
    machine->run(kLooks * interval(scene));
    const Table& table = machine->table();
    track.columns.assign(table.columns.begin() + 1, table.columns.end());
    for (const std::string& column : track.columns) track.kinds.push_back(kind_of(column));
    const std::size_t width = table.columns.size();
    for (std::size_t row = 0; row < table.values.size() / width; ++row) {
      const auto begin = table.values.begin() + static_cast<std::ptrdiff_t>(row * width);
      track.values.emplace_back(begin + 1, begin + static_cast<std::ptrdiff_t>(width));
    }
  } catch (const SceneError& error) {
    track.refused = std::string("SceneError: ") + error.what(), track.problem = error.problem();
  } catch (const SimulationError& error) {
    track.refused = std::string("SimulationError: ") + error.what(), track.problem = error.problem();
  }
  return track;
}

Difference difference(const Units& units, const Track& first, const Track& second) {
  Difference out;
  double scale[static_cast<int>(Kind::count)] = {};
  for (int k = 0; k < static_cast<int>(Kind::count); ++k) scale[k] = 1e-3 * unit_of(units, static_cast<Kind>(k));
  for (const std::vector<double>& row : first.values)
    for (std::size_t c = 0; c < row.size(); ++c) {
      double& largest = scale[static_cast<int>(first.kinds[c])];
      largest = std::max(largest, std::abs(row[c]));
    }
  for (std::size_t c = 0; c < first.columns.size(); ++c) {
    const auto found = std::find(second.columns.begin(), second.columns.end(), first.columns[c]);
    const int kind = static_cast<int>(first.kinds[c]);
    for (std::size_t row = 0; row < first.values.size(); ++row) {
      // A column or a row that the other lacks, and NaN: as far apart as can be.
      double apart = 1e300;
      if (found != second.columns.end() && row < second.values.size())
        apart = std::abs(first.values[row][c] -
                         second.values[row][static_cast<std::size_t>(found - second.columns.begin())]) /
                scale[kind];
      if (apart <= out.of[kind]) continue;
      out.of[kind] = apart;
      out.where[kind] = first.columns[c] + ", look " + std::to_string(row);
    }
  }
  return out;
}

}  // namespace lithe::differential
