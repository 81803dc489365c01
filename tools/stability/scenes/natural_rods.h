#pragma once

#include "engine/assembly/batch.h"
#include "engine/model/body.h"
#include "engine/model/system_graph.h"
#include "tools/stability/bench.h"

namespace lithe::lab {

/// The rods of N four-bar windows in a row (R02) in natural coordinates: x and y of the joints B_0 ... B_N alone, so
/// that the mass matrix is constant and the only constraints are lengths (García de Jalón & Bayo 1994).
///   a uniform rod from a to b:  T = m/6 (ȧ·ȧ + ȧ·ḃ + ḃ·ḃ),  weight at its middle
/// N + 1 uprights from ground pins (i L, 0) to B_i and N couplers between the B_i.
class NaturalRods final : public Body {
 public:
  struct Parameters {
    int windows = 2;              // N
    double length = 1, mass = 1;  // of every rod, m, kg
    double angle = 0, speed = 1;  // of the uprights from the upward vertical, rad; of the B_i, m/s
  };
  struct Cache : BodyCache {
    explicit Cache(const NaturalRods&) {}
  };
  explicit NaturalRods(Parameters parameters);

  Marker joint(int i) { return {this, i}; }

  Coordinates coordinates() const override { return {.frames = 0, .linear = count_, .pattern = &pattern_}; }
  std::unique_ptr<BodyCache> make_cache() const override { return std::make_unique<Cache>(*this); }
  void initial_state(VectorRef q, VectorRef v) const override;
  void evaluate(const BodyState&, Level) const override {}
  void add_residual(const BodyState&, const double* v_dot, const Vector3& gravity, double* r) const override;
  void add_tangent(const BodyState&, const double*, const Vector3&, const TangentWeights& weights,
                   BodyTangent& tangent) const override;
  void marker_kinematics(const BodyState&, int marker, Level, MarkerKinematics&) const override;
  BodyEnergy energy(const BodyState&, const Vector3& gravity) const override;

 private:
  Parameters parameters_;
  int count_;
  MatrixX mass_;
  VectorX weight_;  // share of mass whose weight acts on each joint, kg
  LinearPattern pattern_;
  std::vector<MatrixX> shapes_;  // 6 x n of each joint
};

}  // namespace lithe::lab

namespace lithe {
extern template std::unique_ptr<BodyBatch> make_body_batch<lab::NaturalRods>();
}

namespace lithe::lab {

/// R02 in these coordinates, gravity along -y.
class Windows : public Bench {
 public:
  explicit Windows(const NaturalRods::Parameters& parameters);

  /// Of the uprights from the upward vertical, rad; whole turns are not counted.
  double angle(int upright) const;
  /// Largest difference between two uprights, rad.
  double mismatch() const;

 private:
  NaturalRods::Parameters parameters_;
};

/// The uprights' angle on the parallelogram branch, θ'' = κ sin θ: classical Runge-Kutta with steps below 0.1 ms.
double parallelogram_angle(const NaturalRods::Parameters& parameters, double time);
/// κ, 1/s²
double parallelogram_stiffness(const NaturalRods::Parameters& parameters);

}  // namespace lithe::lab
