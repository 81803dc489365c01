#pragma once

#include <memory>

#include "engine/assembly/evaluator.h"
#include "engine/gradient/parametric_scene.h"
#include "engine/observe/snapshot.h"

namespace lithe {

/// A scene drawn with some parameters moved, evaluated at states of the scene itself.
struct MovedDrawing {
  MovedDrawing(const ParametricScene& scene, const std::vector<DesignParameter>& parameters)
      : drawing(scene, parameters), equations(drawing.system()) {}

  double value(const Drawing::Place& place, const State& state) {
    if (!snapshot) snapshot = std::make_unique<Snapshot>(drawing.system());
    snapshot->evaluate(state, Accelerations::solved);
    return drawing.sensor(place.sensor).value(*snapshot, place.column);
  }

  Drawing drawing;
  Evaluator equations;
  std::unique_ptr<Snapshot> snapshot;  // once a sensor is read
};

}  // namespace lithe
