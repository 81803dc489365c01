#pragma once

#include <vector>

#include "bodies/beam/beam.h"

namespace lithe {

/// Where nodes are to be for a beam that is loaded as in some state.
struct BeamMesh {
  std::vector<double> stations;  // rising, m, without the ends: for Beam::Parameters::stations, with .elements = 1
  double error = 0;              // of the elastic energy, relative, as estimated

  int element_count() const { return static_cast<int>(stations.size()) + 1; }
};

/// Estimated error of a beam's elastic energy at a state, relative: what strains that change linearly along its
/// elements have over the constant ones,  Σ ½ L Δεᵀ C Δε / 12,  Δε the change along an element, from the strains beside
/// it (Zienkiewicz & Zhu, Int. J. Numer. Meth. Engng. 24 (1987) 337). Of a cantilever under a force at its end it is
/// 1/(4 n²), as the true one; under one load that is also the relative error of the deflection there. 0 without strain.
double energy_error(const Beam& beam, const BodyState& state);

/// As few elements as keep that error below `error` (relative): long ones where the strain is constant, that is where
/// the beam is straight and unloaded, or bent by moments alone; short ones where it changes. Nodes stay at the beam's
/// stations and at those of its sections; make a station where something is attached. No element turns by more than
/// one radian. The beam given should be fine enough that its own error is well below.
///   const BeamMesh mesh = coarsened(fine, now.body_state(fine), 1e-3);
///   parameters.stations = mesh.stations, parameters.elements = 1;
/// SceneError for an error that is not above zero.
BeamMesh coarsened(const Beam& beam, const BodyState& state, double error);

}  // namespace lithe
