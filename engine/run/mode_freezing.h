#pragma once

#include <memory>
#include <string>
#include <vector>

#include "engine/motion/integrator.h"
#include "engine/run/driven_oscillator.h"

namespace lithe {

/// Lets modes of deformable bodies stand still while their motion is too small to matter, and move again when it is
/// not. An integrator around another one, whose steps the stiff modes then no longer limit:
///   ModeFreezing integrator{std::make_unique<ExplicitRungeKutta>(parameters), {.displacement = 1e-5}};
/// A frozen mode keeps the coordinate that it has, so that the body moves as if it were of that shape (hold() of
/// EquationsOfMotion): what is left is the same multibody system with one coordinate less, whatever the deflection.
///
/// Freezing: once a mode has stayed within a quarter of the displacement for two periods and an interval, its swing and
/// what carries it, and all stiffer modes, which would limit the steps without it, are frozen or freeze too; and then
/// only if the highest frequency that moves falls by a third or all do. Internal modal impulses take the rates away,
///   [M Gᵀ; G 0] (δv, Λ) = (M e, -ġ),   e: the rates that go; in the rows and columns of what moves on,
/// so that linear and angular momentum and joints stay as they are to round-off; kinetic energy that goes is kept in
/// an account.
///
/// Thawing: the force r that holds a mode drives the oscillator that the mode would be if it were let go,
///   z̈ + A (D ż + K z) = -A r,   A = its entry of the inverse of [M Gᵀ; G 0] when it froze,
/// solved exactly for r linear over a step: its quasi-static part, resonance, and the swing it froze with. Where the
/// amplitudes of a body's frozen modes together pass `displacement` at the node that each moves most, the largest are
/// let go, at the start of that step, which is made anew. Nothing jumps but accelerations.
///
/// Limits: the displacement is one of the shape at an instant; what shapes a little off make of the motion as a whole
/// adds up over time. K is the stiffness of the undeformed body: not near buckling. A push between two looks,
/// `interval` apart, goes unfelt. What starts the integrator anew (events) thaws all modes.
class ModeFreezing final : public Integrator {
 public:
  struct Parameters {
    double displacement = 1e-5;  // m, that the frozen modes of a body may lack at any node, together
    double interval = 0.01;      // s: how often, or more, the forces that hold them are looked at; steps are no longer
  };
  /// Throws SceneError for parameters that are not positive.
  explicit ModeFreezing(std::unique_ptr<Integrator> method, Parameters parameters);

  /// Of one mode, over all runs since time was last set back.
  struct History {
    std::string body;
    int mode = 0;            // of the body's candidates
    double frequency = 0;    // Hz, of the body held by its frame
    double frozen_part = 0;  // of the time
    int freezes = 0, thaws = 0;
    double energy_taken = 0;  // J; of modes that froze together each by the square of its rate
  };
  std::vector<History> history() const;
  /// J, kinetic energy that freezing has taken: the total energy and this change as the total energy alone without.
  double energy_taken() const;
  int frozen_count() const { return static_cast<int>(held_.size()); }
  /// One line, for a log.
  std::string report() const;

  std::string name() const override { return method_->name() + ", quiet modes frozen"; }
  const IntegratorStatistics& statistics() const override { return statistics_; }
  /// With modes frozen, the equations that observers could solve are not those that the scene moves by.
  bool approximates_accelerations() const override { return held_.empty() && method_->approximates_accelerations(); }
  bool follows_equations() const override { return held_.empty() && method_->follows_equations(); }
  void interpolate(const Layout& layout, const State& from, const State& to, double time, State& out) const override;

 protected:
  void prepare(EquationsOfMotion& equations, State& state) override;
  StepResult advance(EquationsOfMotion& equations, State& state, double t_stop) override;
  bool keep(Archive& archive, EquationsOfMotion& equations, const State& state) override;
  bool delegates() const override { return true; }

 private:
  /// z and its rate.
  struct Mode {
    int body, mode, q, v;  // body: of the layout
    double stiffness, damping, reach;
    // While it moves: since when it has been quiet, and within which bounds.
    double since = 0, low = 0, high = 0, fastest = 0, patience = 1;
    int seen = 0;
    // While it is frozen; force: -A r at the end of a step, then: at its start.
    bool frozen = false;
    double mobility = 1, frozen_since = 0, force = 0, force_then = 0;
    OscillatorState swing{}, swing_then{};

    double motion() const;
    double lack() const;
    History history{};
    double frozen_time = 0;
  };
  void list_modes(const Layout& layout);
  void start_method(EquationsOfMotion& equations, State& state);
  void hold(EquationsOfMotion& equations);
  void find_holding_forces(EquationsOfMotion& equations, const State& state);
  std::vector<Mode*> find_quiet(double time);
  bool freeze(EquationsOfMotion& equations, State& state, const std::vector<Mode*>& quiet);
  bool thaw(EquationsOfMotion& equations, State& state);
  double lack(int body) const;
  double wait(const Mode& mode) const;
  void watch(const State& state);
  void undo_freezing();

  std::unique_ptr<Integrator> method_;
  const Parameters parameters_;
  std::vector<Mode> modes_;   // that may freeze; of each body the stiffest first
  std::vector<int> held_;     // velocities
  State begun_;               // of the last step, after what froze there
  std::vector<Mode*> fresh_;  // frozen there
  std::vector<Mode*> order_;  // scratch
  std::vector<double> fresh_energy_;
  VectorX r_, zero_v_, zero_rows_;
  double watched_time_ = 0;  // s, in all
  IntegratorStatistics earlier_, statistics_;
};

}  // namespace lithe
