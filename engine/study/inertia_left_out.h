#pragma once

#include <vector>

#include "engine/study/model_run.h"

namespace lithe {

/// What inertia and gravity deform of each body beyond its candidate modes, at most, in the norm of the mass, √kg m;
/// the largest along a run with its dynamics.
///
/// They load the whole body, by f = -(a + G x) a unit of mass, G = ω̃ω̃ + α̃, of which each candidate takes its part
/// Q_k. The rest, ρ² = ∫ |f|² dm - Σ Q_k² less what moves the body as a whole, is on modes that are not among them. As
/// eigenmodes are complete up to their highest frequency ω, these follow a slow load by no more than ρ/ω². Loads at
/// joints are not in it: static modes of interfaces are for those, which among the candidates raise ω beyond what these
/// are complete up to. The graph is left at the models of the run.
std::vector<double> inertia_left_out(const SystemGraph& graph, BodyModels& bodies, const ModelRun& run);

}  // namespace lithe
