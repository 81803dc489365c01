#pragma once

#include <string>
#include <vector>

#include "engine/gradient/gradient.h"

namespace lithe {

/// A quantity of a run as a sum over the steps' ends: Σ weight F(state). Of a maximum the weights hold for its change:
/// the value at an extremum changes as if its place did not.
struct SampleWeight {
  long step;
  double weight;
};

/// `times`: of the steps' ends, the first state's among them, twice where an event changes the state; `samples`: the
/// column there, for largest and smallest. Interpolation does not reach across events; a value at one is that before.
/// Throws SceneError for times outside the run and for an extremum that is reached twice.
std::vector<SampleWeight> sample_weights(const Quantity& quantity, const std::vector<double>& times,
                                         const std::vector<double>& samples);

}  // namespace lithe
