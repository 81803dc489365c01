#pragma once

#include "engine/state.h"
#include "engine/system.h"

namespace lithe {

struct EquilibriumOptions {
  double tolerance = 1e-9;  // out-of-balance force, of the largest force or weight at play; iteration goes on below it
                            // for as long as round-off lets it
  int max_load_steps = 200;
};

struct Equilibrium {
  State state;                // v = 0, v_dot = 0, multipliers in balance: a simulation started from it stays at rest
  int load_steps = 0;         // until the whole load was on
  int iterations = 0;         // of Newton, all load steps together
  double out_of_balance = 0;  // largest |Gᵀ λ - f| left, N or N m
};

/// Static equilibrium near a state: Gᵀ λ = f(q, 0, t), g(q, t) = 0 at the start's time, drives held there.
///
/// Each load step solves, by KINSOL (SUNDIALS; Newton with line search, sparse Jacobian, KLU),
///   M d/τ + Gᵀ λ - f(q₀ ⊕ d) = 0,   g(q₀ ⊕ d) = 0
/// so -M d/τ is that part of the load which is held back: τ = 0 leaves everything where it is, τ = ∞ is the
/// equilibrium. τ grows from step to step (pseudo-transient continuation: Kelley & Keyes 1998) and shrinks where Newton
/// fails, bodies turn by more than half a radian, or would move against their forces. In this way
///   - a mechanism far from rest sinks to a stable equilibrium, not to the nearest unstable one;
///   - a motion that nothing holds and nothing drives (a pendulum's turn about the vertical) keeps its place: M/τ makes
///     the matrix regular and does not move the solution;
///   - the last steps are Newton's, and d = 0 there: the balance is exact whatever τ is.
/// A start that is in balance already is returned as it is, stable or not: Linearization::lowest_stiffness() tells.
/// Redundant rows are left out and their multipliers are those of least norm.
/// Throws SimulationError naming the worst coordinate if no equilibrium is found (a body that nothing holds falls),
/// SceneError for a state of another system.
Equilibrium find_equilibrium(const System& system, const State& start, const EquilibriumOptions& options = {});

}  // namespace lithe
