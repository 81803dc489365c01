#pragma once

#include "engine/motion/integrator.h"
#include "engine/motion/projection.h"
#include "engine/observe/sensors.h"

namespace lithe {

/// Kinematic analysis: the motion of a mechanism whose degrees of freedom are all driven. Nothing is integrated: at
/// each time
///   g(q, t) = 0,   G v = -∂g/∂t,   G v̇ = γ,   then   M v̇ + Gᵀ λ = f
/// so errors do not grow, and λ is the inverse dynamics: the forces of the drives that make this motion, and all
/// reactions. It is used like any integrator, so observers, schedules and failures are those of Simulation:
///   Kinematics kinematics{{.step = 1e-3}};
///   Simulation simulation{system, kinematics};
///   simulation.observe(recorder, every(0.01));   // recorder: drive_force(motor), reaction(pin, 0) …
///   simulation.run(state, 2.0);
/// start() throws SceneError naming the freedoms that are not driven. A time that cannot be reached (lock-up, a dead
/// centre under a drive) ends the run with SimulationError naming time and worst row; what was observed is kept. A
/// change point, where two branches of assembly cross, is passed on the branch that keeps the velocities. Elastic
/// coordinates are not driven: with flexible bodies run the dynamics (any integrator) with the same drives;
/// drive_force() then shows the load with vibration, as Adams does. Start from find_equilibrium() to avoid initial
/// vibration.
class Kinematics final : public Integrator {
 public:
  struct Parameters {
    double step = 1e-2;        // s, largest step in time; smaller ones are taken where bodies turn far
    double tolerance = 1e-13;  // of positions, in the units of the rows
  };
  /// Throws SceneError unless both are positive.
  explicit Kinematics(Parameters parameters);

  std::string name() const override { return "kinematic analysis"; }
  const IntegratorStatistics& statistics() const override { return statistics_; }

 protected:
  void prepare(EquationsOfMotion& equations, State& state) override;
  StepResult advance(EquationsOfMotion& equations, State& state, double t_stop) override;
  bool keep(Archive& archive, EquationsOfMotion& equations, const State& state) override;

 private:
  bool reach(EquationsOfMotion& equations, double time, State& state);
  std::string worst(EquationsOfMotion& equations, double time);

  Parameters parameters_;
  IntegratorStatistics statistics_;
  State trial_;
  VectorX predicted_, moved_, rows_;
};

// ---- inverse dynamics: effort and power of a drive ----

/// Force (N) or torque (N m) that the last row of a drive exerts along its own coordinate, positive if it pushes the
/// coordinate up:  -λ, for rows g = coordinate - f(t). True of any run whose drives are constraints.
Sensor drive_force(const Constraint& drive, Located name = "");
/// Power that the drive gives to the system, W:  Σ λ ∂g/∂t over its rows.
Sensor drive_power(const Constraint& drive, Located name = "");

}  // namespace lithe
