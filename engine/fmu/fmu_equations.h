#pragma once

#include <string>
#include <vector>

#include "engine/fmu/fmu_variable.h"
#include "engine/observe/snapshot.h"
#include "engine/run/kinks.h"

namespace lithe {

/// A scene as ordinary differential equations x' = f(t, x, u), x = (q, v), for importers that integrate themselves:
///   ṗ, η̇ as in v,   ė = ½ e ∘ (0, ω),   [M Gᵀ; G 0] (v̇, λ) = (f, γ)
/// f keeps |e|, g and G v + ∂g/∂t where they are; what an importer's own errors make of them is measured by drift() and
/// taken back by project(). A quaternion of another norm is read as the rotation of its direction.
/// Event indicators are the kinks of force laws, with hysteresis: after an event none is at zero.
class FmuEquations {
 public:
  /// Lengths (m) of bodies' motions are taken to be of the size `length`.
  FmuEquations(const System& system, double length);

  /// What of a scene has no such form, by name; empty: all has. Contacts that act by impulses or remember, inputs that
  /// prescribe motions: their rates would have to be known.
  static std::string refusal(const System& system);
  /// Drift above which event mode is asked for: |g|, |G v + ∂g/∂t| in the units of the rows, |e| - 1. 1e-9; more for an
  /// importer that integrates with a larger tolerance (relative; 0: not known), whose every step would drift so far.
  double allowed_drift(double tolerance) const;

  int state_count() const { return static_cast<int>(nominals_.size()); }
  int indicator_count() const { return static_cast<int>(kinks_.size()); }
  /// Sizes of the states, positive: of bodies' positions the length, of rotations 1, of elastic coordinates that at
  /// which they have the kinetic energy of the whole body moved by a hundredth of the length.
  const VectorX& nominals() const { return nominals_; }
  /// States, their derivatives, event indicators.
  const std::vector<FmuVariable>& variables() const { return variables_; }

  VectorX states_of(const State& state) const;
  /// Into q and v. Throws SimulationError for what is not finite, and for a quaternion of norm zero.
  void read(const VectorX& x, State& state) const;
  /// Evaluates a state, with accelerations and multipliers of the equations. Throws SimulationError where there are
  /// none.
  void evaluate(const State& state, Snapshot& now) const;
  /// f of a snapshot of x.
  VectorX derivatives(Snapshot& now, const VectorX& x) const;

  /// By how much a snapshot of x is off its constraints and norms.
  double drift(Snapshot& now, const VectorX& x) const;
  /// Moves a state onto its constraints. Throws SimulationError where they are not reached. The snapshot is lost.
  void project(Snapshot& now, State& state) const;
  /// What the next evaluations take from a state that has been reached: turns of angles, rows left out, reactions.
  /// Whether they may differ by round-off from what they were.
  bool track(Snapshot& now, State& state) const;

  double indicator(int number, Snapshot& now, const std::vector<int>& sides) const;
  /// On which side of each kink a state is: +1 or -1.
  std::vector<int> sides(Snapshot& now) const;

 private:
  void find_nominals();

  const System& system_;
  const double length_;
  VectorX nominals_;
  std::vector<Kink> kinks_;
  std::vector<FmuVariable> variables_;
};

}  // namespace lithe
