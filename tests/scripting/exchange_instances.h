#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

#include "engine/fmu/fmu_instance.h"
#include "lithe/lithe.h"
#include "tests/scripting/exchange_importers.h"

/// Instances of FMUs in this process, and the native runs that they are compared with.
namespace lithe::test {

inline std::unique_ptr<Integrator> runge_kutta_8() {
  return std::make_unique<ExplicitRungeKutta>(ExplicitRungeKutta::Parameters{
      .method = ExplicitRungeKutta::Method::dormand_prince8, .tolerance = {1e-12, 1e-13}});
}

/// A scene as its own importer sees it, without a library between: the same calls as ImportedInstance.
struct Direct {
  explicit Direct(const FmuModel& model) : instance(model, FmuInstance::Form::model_exchange) { instance.begin(0); }
  int set_time(double time) { return instance.set_time(time), 0; }
  int set_states(std::span<const double> x) { return instance.set_states(x), 0; }
  int states(std::span<double> x) { return copy(instance.states(), x); }
  int derivatives(std::span<double> x) { return copy(instance.derivatives(), x); }
  int indicators(std::span<double> x) { return instance.indicators(x), 0; }
  int complete_step(bool& event) { return event = instance.complete_step(), 0; }
  int update(bool& changed) { return changed = instance.update(), 0; }
  int call(const std::string&) { return 0; }
  static int copy(const VectorX& from, std::span<double> to) {
    return std::copy(from.begin(), from.end(), to.begin()), 0;
  }
  FmuInstance instance;
};

/// The native run, with the inputs set so; all sensors at the times.
struct Native {
  SystemGraph graph;
  std::vector<Sensor> sensors;
  System system;
  std::unique_ptr<Integrator> method = runge_kutta_8();
  Simulation simulation;
  State state;

  explicit Native(const StudyScene& scene)
      : graph({.gravity = scene.gravity}),
        sensors(scene.draw(graph)),
        system(assemble(graph)),
        simulation(system, *method),
        state(system.initial_state()) {}
  Values at(double time) {
    simulation.run(state, time);
    Snapshot now(system);
    now.evaluate(state, Accelerations::solved);
    Values values;
    for (const Sensor& sensor : sensors)
      for (std::size_t c = 0; c < sensor.columns().size(); ++c)
        values.push_back(sensor.value(now, static_cast<int>(c)));
    return values;
  }
  Values x() const {
    Values all(state.q.begin(), state.q.end());
    all.insert(all.end(), state.v.begin(), state.v.end());
    return all;
  }
};

inline double difference(const Values& a, const Values& b, std::size_t count = 1000) {
  EXPECT_EQ(a.size(), b.size());
  double largest = 0;
  for (std::size_t i = 0; i < std::min(count, a.size()); ++i)
    largest = std::max(largest, std::abs(a[i] - b[i]) / std::max(1.0, std::abs(b[i])));
  return largest;
}

inline FmuModel model_of(const StudyScene& scene) { return {scene, runge_kutta_8, "token"}; }

inline unsigned reference(const FmuInstance& instance, const std::string& name) {
  const auto& all = instance.variables();
  const auto found = std::find_if(all.begin(), all.end(), [&](const FmuVariable& v) { return v.name == name; });
  EXPECT_NE(found, all.end()) << name;
  return static_cast<unsigned>(found - all.begin());
}

/// All that sensors of an instance tell.
inline Values outputs_of(FmuInstance& instance) {
  Values all;
  for (std::size_t i = 0; i < instance.variables().size(); ++i)
    if (instance.variables()[i].role == FmuVariable::Role::output)
      all.push_back(instance.get(static_cast<unsigned>(i)));
  return all;
}

}  // namespace lithe::test
