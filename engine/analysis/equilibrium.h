#pragma once

#include <string>

#include "engine/analysis/left_out.h"
#include "engine/assembly/system.h"
#include "engine/model/state.h"

namespace lithe {

struct EquilibriumOptions {
  double tolerance = 1e-9;  // out-of-balance force, of the largest force or weight at play, preloads included; it
                            // continues below it as far as round-off allows
  int max_load_steps = 1000;
};

/// Of a rest: whether the smallest ω² of K d = ω² M d is positive, d the motions that the joints allow.
enum class RestStability {
  stable,
  unstable,  // some motion away from it grows
  unknown,  // ω² is zero but for its uncertainty (a motion that nothing holds or drives), or loads follow the motion:
            // then K alone does not tell, linearize() does
};

struct Equilibrium {
  State state;                // v = 0, v_dot = 0, multipliers in balance: a simulation started from it stays at rest
  int load_steps = 0;         // steps that held part of the load back
  int iterations = 0;         // of Newton: tangents factorised, those of steps refused among them
  double out_of_balance = 0;  // largest |Gᵀ λ - f| left, N or N m
  double round_off = 0;       // what round-off makes of it at most, in the row where that is largest
  RestStability stability = RestStability::unknown;
  double lowest_stiffness = 0;              // the smallest ω², 1/s²; infinite where the joints hold everything
  double stiffness_uncertainty = 0;         // of it, 1/s²: differences and round-off
  VectorX softest;                          // its motion, as velocities
  std::vector<DeflectionLeftOut> left_out;  // an estimate of what the modes of deformable bodies leave out

  /// "stable, lowest stiffness 39.2 1/s²"
  std::string stability_text() const;
};

/// Static equilibrium near a state: F(q, λ) = Gᵀ λ - f(q, 0, t) = 0, g(q, t) = 0 at the start's time, with drives held
/// there.
///
/// Newton with K = ∂F/∂q, (K + σM) d + Gᵀ Δλ = -F, G d = -g, judged by its corrections (natural monotonicity: Deuflhard
/// 2004, 3.3) in the metric of the mass. A share s of the step is taken, with (1 - s) F held back, and corrected until
/// corrections c are small beside it: with the step's factor while they contract, with new ones where bodies turned
/// too far for it. A residual would mislead: a beam that bends by θ in one step is stretched by half θ² on the
/// way, and its axial forces, EA θ²/2, hide that the step is good; its corrections, of θ²/2 its length, do not.
/// A few vectors of GMRES on the differenced balance compensate for terms missing in the bodies' tangents.
///
/// The shift σ ("pseudo-transient continuation": Kelley & Keyes 1998) is as small as possible. It grows where energy
/// is concave along the step, dᵀ(K + σM) d <= 0, where bodies would move too far, and where no share of a step is good:
///   - a mechanism far from rest sinks to a stable equilibrium, not to the nearest unstable one;
///   - a free motion that no load drives (a pendulum's rotation about the vertical) keeps its position;
///   - d = 0 at the end: the balance is exact whatever σ is.
/// Each row is balanced down to `tolerance`, or to its round-off if that is larger, as it may be for stiff rows.
/// A start already in balance is returned unchanged, stable or not. One within round-off of an unstable equilibrium may
/// be left for a stable one or end there. Equilibrium::stability tells (engine/analysis/rest_stability.h), and a rest
/// that is unstable is reported.
/// Redundant rows are left out and their multipliers are those of least norm.
/// Modes that bodies have and do not use are estimated (Equilibrium::left_out), and reported above kLeftOutToTell.
/// Throws SimulationError naming the worst coordinate if no equilibrium is found (a body that nothing holds falls),
/// SceneError for a state of another system.
Equilibrium find_equilibrium(const System& system, const State& start, const EquilibriumOptions& options = {});

}  // namespace lithe
