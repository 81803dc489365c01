#pragma once

#include <memory>

#include "engine/assembly/system.h"
#include "engine/model/marker.h"
#include "engine/model/state.h"

namespace lithe {

class ContactForces;
class Evaluator;
class LeastNorm;
struct BodyEnergy;

/// Those of a snapshot: as the integrator left them in the state, or solved for at (t, q, v):
///   M v̇ + Gᵀλ = f,  G v̇ = γ
enum class Accelerations { as_left, solved };

/// One state of a system as observers see it: evaluated once, at Level::acceleration, and read by all sensors. Has an
/// evaluator of its own, so that observing does not disturb the integrator. Sensors can be read without a simulation:
///   Snapshot now{system, state};   double z = height(link.node(42)).value(now);
class Snapshot {
 public:
  /// Nothing may be read before evaluate().
  explicit Snapshot(const System& system);
  Snapshot(const System& system, const State& state) : Snapshot(system) { evaluate(state); }
  Snapshot(const System&& system) = delete;  // borrowed: a temporary would be gone
  Snapshot(const System&& system, const State& state) = delete;
  ~Snapshot();

  /// Copies the state and evaluates the system there. Throws SceneError for a state of another system. `solved`: when
  /// first asked for, by one factorisation; if there is no solution (friction that locks), those of the state are kept.
  void evaluate(const State& state, Accelerations accelerations = Accelerations::as_left);

  double time() const { return state_.time; }
  /// As the integrator left it, possibly without lambda: use multipliers().
  const State& state() const { return state_; }
  const System& system() const { return *system_; }
  /// Evaluated at the state. Do not factorise or evaluate it again: that invalidates the snapshot for later observers.
  Evaluator& evaluator() { return *evaluator_; }

  /// Position, axes, velocity of a marker. Throws SceneError for a marker of another system.
  MarkerKinematics marker(const Marker& marker);
  /// q, v and what its evaluation keeps, of a body. Throws SceneError for a body of another system.
  BodyState body_state(const Body& body);
  /// Of all bodies and forces (theirs counts as elastic), joules.
  BodyEnergy energy();
  /// The quarter turns of the angles that a joint or force measures, as ConnectorRows::recall() takes them.
  const double* quarter_turns_of(const Connector& connector) const;
  /// Null: the scene has no contacts.
  ContactForces* contacts();
  /// v_dot of the whole system.
  const VectorX& accelerations() { return solve() ? v_dot_ : state_.v_dot; }
  /// (v_dot, w_dot) = J v_body_dot + bias, world axes.
  Vector6 acceleration(const Marker& marker);
  /// lambda that belongs to accelerations(); with redundant rows that of least norm that loads the bodies alike.
  const VectorX& multipliers();
  /// Those of the state; computed here if the integrator has left them out.
  const VectorX& found_multipliers();

 private:
  bool solve();

  const System* system_;
  std::unique_ptr<Evaluator> evaluator_;  // only declared here: sensors include this header, and few need more
  State state_;
  bool solves_ = false, solved_ = false;  // v_dot_ and lambda_ are to be used; they are there
  VectorX v_dot_, lambda_;
  VectorX multipliers_;
  bool has_multipliers_ = false;
  std::unique_ptr<LeastNorm> least_norm_;  // once asked for
};

}  // namespace lithe
