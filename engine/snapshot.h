#pragma once

#include "engine/assembler.h"
#include "engine/marker.h"
#include "engine/state.h"
#include "engine/system.h"

namespace lithe {

/// One state of a system as observers see it: evaluated once, at Level::acceleration, and read by all sensors. Has an
/// assembler of its own, so that looking does not disturb the integrator. Sensors can be read without a simulation:
///   Snapshot now{system, state};   double z = height(link.node(42)).value(now);
class Snapshot {
 public:
  /// Nothing may be read before evaluate().
  explicit Snapshot(const System& system) : assembler_(system) {}
  Snapshot(const System& system, const State& state) : Snapshot(system) { evaluate(state); }
  Snapshot(const System&& system) = delete;  // borrowed: a temporary would be gone
  Snapshot(const System&& system, const State& state) = delete;

  /// Copies the state and evaluates the system there. Throws SceneError for a state of another system.
  void evaluate(const State& state);

  double time() const { return state_.time; }
  /// Without lambda where the integrator has left it out: multipliers() has it.
  const State& state() const { return state_; }
  const System& system() const { return assembler_.system(); }
  /// Evaluated at the state. To factorise or evaluate it anew spoils the snapshot for the observers that follow.
  Assembler& assembler() { return assembler_; }

  /// Position, axes, velocity of a marker. Throws SceneError for a marker of another system.
  MarkerKinematics marker(const Marker& marker) { return assembler_.marker(marker, Level::acceleration); }
  /// (v_dot, w_dot) = J v_body_dot + bias, world axes, with the accelerations that the integrator left.
  Vector6 acceleration(const Marker& marker);
  /// Those of the state; found here where the integrator has left them out.
  const VectorX& found_multipliers();
  /// The same; with redundant rows the multipliers of least norm that load the bodies alike.
  const VectorX& multipliers();

 private:
  Assembler assembler_;
  State state_;
  VectorX multipliers_;
  bool has_multipliers_ = false;
};

}  // namespace lithe
