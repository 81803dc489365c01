#pragma once

#include <complex>
#include <functional>
#include <vector>

#include "engine/base/math.h"
#include "engine/model/body.h"
#include "engine/model/contact_memory.h"
#include "engine/model/layout.h"

namespace lithe {

class RigidContacts;
class ThreadTeam;
struct State;

/// Weights of an iteration matrix at a complex point (stages of implicit Runge-Kutta methods).
struct ComplexTangentWeights {
  std::complex<double> position = 0, velocity = 0, acceleration = 1;
};
using ComplexVectorX = Eigen::VectorXcd;
using ComplexVectorRef = Eigen::Ref<ComplexVectorX>;

/// Accelerations without multipliers, where a scene is such that its free motions can be solved by themselves in a cost
/// that bodies with constraints cannot reach: rigid trees, planar mechanisms.
class ForwardDynamics {
 public:
  virtual ~ForwardDynamics() = default;
  /// v_dot at a state on the constraints, or as near to them as a stage of an integrator is.
  virtual void accelerations(double time, ConstVectorRef q, ConstVectorRef v, VectorRef v_dot) = 0;
  /// Moves q, then v, onto the constraints, to `tolerance` in the units of the rows or to round-off if that is larger;
  /// false if they are not reached. Not by the shortest way that masses know (Projector), but as near.
  virtual bool project(double time, VectorRef q, VectorRef v, double tolerance) = 0;
};

/// Factors of the iteration matrix at complex weights, beside the real one.
class ComplexFactor {
 public:
  virtual ~ComplexFactor() = default;
  /// As EquationsOfMotion::factorize. The first call allocates it.
  virtual void factorize_complex(const ComplexTangentWeights& weights, ConstVectorRef v_dot, ConstVectorRef lambda,
                                 const VectorX* increment) = 0;
  virtual void solve_complex(ComplexVectorRef rv, ComplexVectorRef rl) const = 0;
};

/// What evaluations carry along besides time, q and v: a step takes it from its state and writes it there, so that it
/// depends on nothing but its state. Integrator does both, a step.
class StepMemory {
 public:
  virtual ~StepMemory() = default;
  /// The whole turns of the angles that joints measure (State::quarter_turns): taken over from a state that evaluations
  /// will be near, and brought up to the state evaluated last.
  virtual void recall(const VectorX& quarter_turns) = 0;
  virtual void track(VectorX& quarter_turns) const = 0;
  /// Rows that are left out (State::left_out): the choice has a memory.
  virtual void recall_rows(const std::vector<int>& /*left_out*/) {}
  virtual void track_rows(std::vector<int>& /*left_out*/) const {}
  /// Contacts (State::contacts): what compliant ones remember, and what rigid ones do, who act in evaluations by what
  /// they did last. Tracking evaluates the state.
  virtual void recall(const ContactMemory& /*contacts*/) {}
  virtual void track_contacts(State& /*state*/) {}
  /// Whether an angle that is read was lost in the step to this state, of which check() throws: a shorter step may see
  /// the way round.
  virtual bool loses_angle(const State& /*state*/) { return false; }
  /// What no method sees of a state that a step has reached: throws SimulationError where rows that are left out
  /// contradict those that they repeat, or a joint is beyond its limits. Evaluates the state.
  virtual void check(const State& /*state*/) {}
};

/// Holds linear coordinates of bodies where they are.
class HeldCoordinates {
 public:
  virtual ~HeldCoordinates() = default;
  /// The rows of these velocities become v_dot = 0, and no other row and no joint knows their acceleration. Their v
  /// must be zero. Replaces those held before; none: lets all go, from the next evaluate() on. A factor needs an
  /// acceleration part. False, and nothing is changed, for other velocities.
  virtual bool hold(const std::vector<int>& velocities) = 0;
};

/// M(q) v_dot + G(q, t)ᵀ lambda = f(q, v, t),  g(q, t) = 0: all that an integrator sees of a scene. One object a
/// thread: it holds the scratch of the state evaluated last, to which everything after evaluate() refers.
class EquationsOfMotion {
 public:
  virtual ~EquationsOfMotion() = default;

  struct Facts {
    const Layout* layout = nullptr;
    /// Rows that repeat others, sorted: handled by solve(), to be left out by codes that factorise for themselves.
    /// Their number is that of the scene; which they are depends on the pose: factorize() leaves out a row that comes
    /// to depend on the others instead of one that no longer does.
    std::vector<int> redundant_rows;
    std::vector<int> velocity_rows;  // on velocities alone (rolling), sorted: their g is zero always
    bool reacts = false;             // f depends on lambda (friction by reactions)
    bool has_loops = false;          // joints close loops: only then can constraints lose rank on the way
    ThreadTeam* team = nullptr;      // for a method's own loops over bodies (share_bodies()); null: no threads
  };
  virtual const Facts& facts() const = 0;
  const Layout& layout() const { return *facts().layout; }
  const std::vector<int>& redundant_rows() const { return facts().redundant_rows; }
  const std::vector<int>& velocity_rows() const { return facts().velocity_rows; }
  bool reacts() const { return facts().reacts; }

  /// What only some integrators ask for. Null: these equations have no such part.
  struct Parts {
    StepMemory* memory = nullptr;  // never null
    ComplexFactor* complex_factor = nullptr;
    ForwardDynamics* forward_dynamics = nullptr;
    RigidContacts* rigid_contacts = nullptr;  // rigid surfaces: a method that cannot handle them refuses the scene
    HeldCoordinates* held = nullptr;
  };
  virtual Parts parts() = 0;
  StepMemory& memory() { return *parts().memory; }

  virtual void evaluate(double time, ConstVectorRef q, ConstVectorRef v, Level level) = 0;
  /// r = M v_dot + Gᵀ lambda - f; f knows lambda where joints rub. Needs Level::velocity.
  virtual void residual(ConstVectorRef v_dot, ConstVectorRef lambda, VectorRef r) = 0;
  /// g (Level::position), g_dot = G v + ∂g/∂t (velocity), or gamma with G v_dot = gamma (acceleration).
  virtual void constraint(Level which, VectorRef out) const = 0;
  /// Of all bodies and force elements (theirs counts as elastic) at the state evaluated last. Needs Level::velocity.
  virtual BodyEnergy energy() = 0;

  /// Forms and factorises [S Gᵀ; G 0], S = weighted derivative of r. `increment`: the step's increment d = q_n -> q in
  /// the chart of q_n if S is to act on corrections of d' = v (null: corrections are turns of the present state).
  virtual void factorize(const TangentWeights& weights, ConstVectorRef v_dot, ConstVectorRef lambda,
                         const VectorX* increment) = 0;
  /// Solves [S Gᵀ; G 0] (x, y) = (rv, rl) in place with the last factor. Redundant rows get y = 0.
  virtual void solve(VectorRef rv, VectorRef rl) const = 0;
  /// Every block of the last [S Gᵀ; G 0] as assembled: row, column (constraint rows follow the velocities), values. The
  /// sparse codes of others (KLU) need it.
  virtual void visit_blocks(const std::function<void(int row, int column, ConstMatrixRef block)>& visit) const = 0;
};

}  // namespace lithe
