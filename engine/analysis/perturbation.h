#pragma once

#include <optional>

#include "engine/analysis/free_motions.h"
#include "engine/analysis/linearization.h"
#include "engine/assembly/evaluator.h"
#include "engine/model/state.h"
#include "engine/observe/sensors.h"

namespace lithe {

/// The equations of motion near a state, as functions of small changes in the axes above: what linearize() differences.
class Perturbation {
 public:
  /// Accelerations and multipliers of the base are made consistent with its (time, q, v).
  /// `step`: of the differences, of the bodies' size.
  Perturbation(const System& system, const State& base, PerturbationAxes axes, double step = 1e-3);

  /// A change of position ζ, velocity ξ and acceleration ξ̇, of an input, and of the multipliers of rows() as sensors
  /// see them; an empty one is zero.
  struct Direction {
    VectorX position{}, velocity{}, acceleration{};
    const Input* input = nullptr;
    Motion motion{};  // of the input
    VectorX multipliers{};
  };
  /// Derivatives along a direction, by central differences of fourth order.
  VectorX residual(const Direction& direction);           // M v̇ + Gᵀ λ - f at the base's λ
  VectorX position_rows(const Direction& direction);      // g, redundant rows left out
  VectorX velocity_rows(const Direction& direction);      // G v + ∂g/∂t, redundant rows left out
  VectorX acceleration_rows(const Direction& direction);  // G v̇ - γ
  /// The columns of all these sensors, one after another.
  VectorX sensors(const Direction& direction, const std::vector<Sensor>& sensors);

  /// M x, in the axes.
  VectorX mass_times(const VectorX& x);
  /// G at the base, in the axes: all rows.
  MatrixX jacobian();
  /// dG/dt along the motion.
  MatrixX jacobian_rate();
  /// Numbers of the rows that velocity_rows() and acceleration_rows() give.
  const std::vector<int>& rows() const { return kept_; }
  /// ξ = ζ̇ + transport(ζ): the table above.
  VectorX transport(const VectorX& zeta) const;

  /// From the axes to the engine's velocities (ṗ world, ω body, η̇) at the base, and back.
  VectorX to_engine(const VectorX& x) const { return resolved(base_.q, x, false); }
  VectorX to_axes(const VectorX& x) const { return resolved(base_.q, x, true); }
  const State& base() const { return base_; }
  const Layout& layout() const { return equations_.layout(); }

 private:
  template <class Read>
  VectorX derivative(const Direction& direction, Read&& read);
  VectorX resolved(const VectorX& q, VectorX x, bool to_axes) const;
  void load(const Direction& direction, double h);
  void read_rows(Level level, VectorX& out);
  double step(const Direction& direction) const;

  Evaluator equations_;
  std::optional<Snapshot> snapshot_;  // once asked for
  State base_, near_;
  PerturbationAxes axes_;
  double step_;
  double length_;        // of the bodies, m
  VectorX xi_, xi_dot_;  // velocity and acceleration of the base, in the axes
  VectorX still_, no_load_, rows_;
  std::vector<int> kept_;  // rows that are not redundant
};

}  // namespace lithe
