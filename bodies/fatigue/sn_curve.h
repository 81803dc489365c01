#pragma once

#include "bodies/fatigue/rainflow.h"

namespace lithe {

/// How many cycles a material or a detail endures (Basquin 1910), with one or two slopes and a cut-off, by the stress
/// range Δσ (twice the amplitude):
///   N = cycles (range / Δσ)^exponent,   below the knee (Δσ < range) with exponent_below,   ∞ below cut_off
/// A mean stress σ_m counts by Goodman's line, if a tensile strength R_m is given: Δσ / (1 - σ_m / R_m) for σ_m > 0;
/// compression is no help. The curve is then that of alternating stress.
/// EN 1993-1-9, a detail of category 71: {.range = 52.3e6, .cycles = 5e6, .exponent = 3, .exponent_below = 5,
/// .cut_off = 28.7e6}.
struct SnCurve {
  double range = 0;             // Pa, at the knee
  double cycles = 2e6;          // endured there
  double exponent = 5;          // above the knee
  double exponent_below = 0;    // below it; 0: the same
  double cut_off = 0;           // Pa: ranges below do no damage
  double tensile_strength = 0;  // Pa; 0: the mean does not count

  /// Throws SceneError for a figure that is not finite, a range, number of cycles or exponent not above 0, a negative
  /// other one.
  void check() const;
  /// Endured cycles of a range (Pa) about no mean; infinite below the cut-off.
  double endured(double stress_range) const;
  /// Share of the life that a cycle takes. SceneError where it reaches the tensile strength.
  double damage(const LoadCycle& cycle) const;
};

/// Palmgren-Miner's sum D = Σ n_i / N_i: failure at 1. SceneError as SnCurve::damage.
double miner_sum(std::span<const LoadCycle> cycles, const SnCurve& curve);

}  // namespace lithe
