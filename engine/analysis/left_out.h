#pragma once

#include <string>
#include <vector>

#include "engine/assembly/system.h"
#include "engine/model/state.h"

namespace lithe {

/// What the modes that a deformable body has, and does not use, would add to its deflection.
struct DeflectionLeftOut {
  std::string name;
  int used, candidates;
  double deflection;  // largest displacement of a node by the modes of the richer answer, a bound, m
  double missing;     // by what these modes have moved on or are new, likewise, m
  bool known() const { return used < candidates; }
  double share() const { return deflection > 0 ? missing / deflection : 0; }
};

/// Above it, find_equilibrium() tells in a line of the log what share of its deflection a body leaves out, linearize()
/// by how much the lowest frequency is too high.
inline constexpr double kLeftOutToTell = 0.05;

/// An estimate at a state, a line a body that has candidate modes: those left out deflect by f/ω² under the loads,
/// reactions and inertia that the state has. What they change of the loads themselves is not seen, nor contacts and
/// modal markers: exact where supports are statically determinate and the body linear. A body that uses all its modes
/// has nothing to compare with. Costs one reading of the joints and forces on these bodies; without them nothing.
/// find_modes_left_out() (engine/study/modes_left_out.h) solves again with all modes.
std::vector<DeflectionLeftOut> deflection_left_out(const System& system, const State& state);

/// By how much a small motion's frequency is too high by the same modes, relative; 1: with them it would be unstable.
/// By Rayleigh's quotient: they follow the loads that change along the shape, δω² = -Σ δf²/(ω_k² - ω²) / inertia.
/// `shape`: v_count long, in the engine's velocities; `inertia`: shapeᵀ M shape; `stiffness`: ω² > 0, 1/s².
double frequency_left_out(const System& system, const State& state, const VectorX& shape, double inertia,
                          double stiffness);

/// The line of the log, one a body above kLeftOutToTell.
void tell_left_out(const std::vector<DeflectionLeftOut>& bodies);

}  // namespace lithe
