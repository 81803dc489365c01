#pragma once

#include <optional>
#include <string>

#include "engine/motion/integrator.h"
#include "engine/motion/projection.h"

namespace lithe {

/// A method of fixed step that balances momenta M v at the ends of the step instead of accelerations within it: what
/// Rattle and EnergyMomentum share. It knows how to get from the equations of motion the momentum M D and the slope of
/// the Lagrangian L = T - V at a velocity D, and repeats a step that does not converge in halves.
class MomentumBalance : public Integrator {
 public:
  const IntegratorStatistics& statistics() const override { return statistics_; }

 protected:
  enum class Attempt { taken, no_convergence, no_number };

  /// Throws SceneError, for `type`, for a step or tolerance that is not positive.
  MomentumBalance(double step, double newton_tolerance, const std::string& type);

  void prepare(EquationsOfMotion& equations, State& state) override;
  StepResult advance(EquationsOfMotion& equations, State& state, double t_stop) final;
  bool keep(Archive& archive, EquationsOfMotion& equations, const State& state) override;
  /// One step from `start` by h to `time`: fills q_, v_, v_dot_, lambda_.
  virtual Attempt attempt(EquationsOfMotion& equations, const State& start, double h, double time) = 0;

  void evaluate(EquationsOfMotion& equations, double time, ConstVectorRef q, ConstVectorRef v);
  void factorize(EquationsOfMotion& equations, const TangentWeights& weights, const State& start,
                 ConstVectorRef lambda);
  /// out = M x at the state evaluated last.
  void multiply_mass(EquationsOfMotion& equations, ConstVectorRef x, VectorRef out);
  /// At the state evaluated last, coordinates q, velocities D: the momentum M D, and the slope ∂L/∂q - Gᵀλ with D held
  /// fixed (ṗ in world axes, ω in body axes), but for the deformation's part of (dM/dt) D.
  void slope(EquationsOfMotion& equations, ConstVectorRef q, ConstVectorRef D, ConstVectorRef lambda,
             VectorRef momentum, VectorRef out);
  /// out += weight M D with the deformation of the state evaluated last, coordinates q, and the orientations of q_axes.
  void add_deformed_momentum(EquationsOfMotion& equations, ConstVectorRef q, ConstVectorRef q_axes, ConstVectorRef D,
                             double weight, VectorRef out);
  /// Consistent v_dot_ and lambda_ at (time, q_, v_); false if they are not finite.
  bool finish(EquationsOfMotion& equations, double time, Projector::Factor factor);

  /// Watches Newton's corrections in the velocities, relative to 1 + the largest velocity.
  struct Corrections {
    double tolerance;
    bool wants_factor = true;  // a new one: at the start, and where corrections shrink too slowly
    bool done = false, diverges = false;
    double last = 0;
    int count = 0;
    void add(double size);
  };

  double newton_tolerance_;
  IntegratorStatistics statistics_;
  bool deforms_ = false;  // the mass of a body may depend on its linear coordinates, or on several frames
  VectorX q_, v_, v_dot_, lambda_;
  VectorX rv_, rl_, zero_v_, zero_rows_;

 private:
  double step_;
  EquationsOfMotion* equations_ = nullptr;  // those that projector_ works on
  std::optional<Projector> projector_;
  VectorX x_, product_, offset_;
};

/// Body axes to world axes of a body with a frame.
inline Matrix3 orientation(ConstVectorRef q, const Layout::BodySlice& body) {
  return rotation_matrix(q.segment<4>(body.q + 3));
}

}  // namespace lithe
