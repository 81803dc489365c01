#pragma once

#include <vector>

#include "engine/assembly/system.h"
#include "engine/model/state.h"

namespace lithe {

struct EquilibriumPathOptions {
  double end = 1;            // s, where the path ends; before the start's time: it runs backwards
  double first_step = 0.02;  // of the time between start and end, on the first step
  double max_turn = 0.2;     // rad a step, of any body
  double max_step = 0.1;     // of the time between start and end, a step
  double tolerance = 1e-9;   // out-of-balance force, of the largest force or weight at play
  int max_states = 1000;
};

struct EquilibriumPath {
  std::vector<State> states;  // at rest, in the order of the path; the first is the start, the last is at `end`
  int iterations = 0;         // of Newton: tangents factorised
};

/// The equilibria that follow from a balanced start as loads and drives change: F(q, λ, t) = 0, g(q, t) = 0. Here
/// time is only the parameter of their laws (DistributedLoad::amplitude, UserForce, drives). It may reverse:
/// past a limit point the path continues with less load, where find_equilibrium() would jump or fail.
///
/// By pseudo-arclength (Keller 1977; Crisfield 1981): with the factor of (K, G) the tangent (a, 1) solves K a + Gᵀ l =
/// -∂F/∂t, G a = -∂g/∂t; each step starts along it and Newton returns to the path at right angles to it, in the metric
/// aᵀ M a / S² + 1/T² with S the motion that the first tangent foretells for the whole time T. Steps are as long as
/// Newton takes some five iterations.
///   for (const State& s : follow_equilibria(system, start).states) snapshot.evaluate(s), … // load factor s.time
/// Throws SimulationError, with the time reached, if the path is lost or max_states do not reach its end;
/// SceneError for a start that is not in balance, and for a state of another system.
EquilibriumPath follow_equilibria(const System& system, const State& start, const EquilibriumPathOptions& options = {});

}  // namespace lithe
