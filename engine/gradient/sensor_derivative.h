#pragma once

#include <vector>

#include "engine/gradient/parametric_scene.h"
#include "engine/observe/snapshot.h"

namespace lithe {

/// One column of a sensor, differentiated by positions and velocities; accelerations and multipliers are those of the
/// equations at (t, q, v). Differences of fourth order over the coordinates of the bodies that it depends on.
class SensorDerivative {
 public:
  /// `probes`: states at which it is found out which bodies those are.
  SensorDerivative(const Drawing& drawing, Drawing::Place place, const std::vector<State>& probes);

  double value(const State& state);
  /// Adds weight ∂F/∂q (turns of the state) and weight ∂F/∂v.
  void add(const State& state, double weight, Eigen::Ref<VectorX> turn, Eigen::Ref<VectorX> velocity);

 private:
  const Drawing& drawing_;
  Drawing::Place place_;
  Snapshot snapshot_;
  const bool bends_;           // some force law has kinks
  double scales_[2] = {0, 0};  // of its derivatives by positions and velocities
  struct Part {
    int first, count;
    bool velocity;  // else position
  };
  std::vector<Part> parts_;
};

}  // namespace lithe
