#pragma once

#include <memory>
#include <span>

#include "engine/base/math.h"
#include "engine/factor/linear_pattern.h"
#include "engine/model/element.h"
#include "engine/model/marker.h"

namespace lithe {

/// Two frames of a body, first < second, that share a block of its tangent: mass or stiffness couples them.
struct FramePair {
  int first, second;
};

/// The coordinates of a body: frames, each with a position p and a unit quaternion e, then linear coordinates eta.
///   one frame:  q = (p, e, eta),  v = (p_dot, omega, eta_dot): 7 + n and 6 + n numbers
///   several:    q = (p_1, e_1, p_2, e_2, …, eta),  v = (p_1_dot, omega_1, …, eta_dot): 7 and 6 numbers a frame
///   none:       q = eta,  v = eta_dot
struct Coordinates {
  int frames = 1;
  int linear = 0;                          // n, length of eta
  const LinearPattern* pattern = nullptr;  // of the linear-linear block, the body's own; null: it is diagonal
  std::span<const FramePair> pairs{};      // of several frames; the body's own
  int q_count() const { return 7 * frames + linear; }
  int v_count() const { return 6 * frames + linear; }
};

/// Terms that a body computes once per state and shares among residual, tangent and markers. Bodies derive their own.
struct BodyCache {
  Matrix3 A = Matrix3::Identity();  // body axes to world axes
  virtual ~BodyCache();
};

/// One body's slice of a state. `cache` has been filled by Body::evaluate.
struct BodyState {
  const double* q;
  const double* v;
  BodyCache* cache;
};

/// Weights of the iteration matrix  alpha_q ∂r/∂q + alpha_v ∂r/∂v + alpha_a ∂r/∂v_dot.
struct TangentWeights {
  double position = 0, velocity = 0, acceleration = 1;
};

/// Where a body adds its block of the iteration matrix: frame-frame (6 x 6), frame-linear (6 x n), linear-frame (n x
/// 6), column-major, and linear-linear: n diagonal entries, or one value for each entry of Coordinates::pattern. Of
/// several frames each has a block and two with the linear coordinates, and each pair of them two.
struct BodyTangent {
  Eigen::Map<Matrix6> frame;
  Eigen::Map<Matrix6X> frame_linear;
  Eigen::Map<MatrixX> linear_frame;
  Eigen::Map<VectorX> linear;
  /// Of several frames: where in `values` the blocks (first, second) and (second, first) of a pair begin.
  struct PairPlace {
    int upper, lower;
  };
  double* values = nullptr;
  std::span<const PairPlace> pairs{};  // in the order of Coordinates::pairs

  /// The block of the i-th of several frames, and those of the i-th pair.
  Eigen::Map<Matrix6> frame_block(int i) { return Eigen::Map<Matrix6>(frame.data() + 36 * i); }
  Eigen::Map<Matrix6X> frame_linear_block(int i) {
    return {frame_linear.data() + frame_linear.size() * i, 6, frame_linear.cols()};
  }
  Eigen::Map<MatrixX> linear_frame_block(int i) {
    return {linear_frame.data() + linear_frame.size() * i, linear_frame.rows(), linear_frame.cols()};
  }
  Eigen::Map<Matrix6> upper_block(int i) const { return Eigen::Map<Matrix6>(values + pairs[i].upper); }
  Eigen::Map<Matrix6> lower_block(int i) const { return Eigen::Map<Matrix6>(values + pairs[i].lower); }
};

/// Joules, gravity relative to the origin of the world.
struct BodyEnergy {
  double kinetic = 0, elastic = 0, gravity = 0;
  double total() const { return kinetic + elastic + gravity; }
};

/// A body has mass. It computes its share of  M v_dot - f = 0  (f: quadratic velocity force, internal forces,
/// gravity) and the motion of its markers. evaluate() fills the cache before any other function is called.
class Body : public Element {
 public:
  virtual Coordinates coordinates() const = 0;
  virtual std::unique_ptr<BodyCache> make_cache() const = 0;
  virtual void initial_state(VectorRef q, VectorRef v) const = 0;
  virtual void evaluate(const BodyState&, Level) const = 0;
  /// r += M v_dot - f_v - f_internal - f_gravity, gravity in world axes.
  virtual void add_residual(const BodyState&, const double* v_dot, const Vector3& gravity, double* r) const = 0;
  /// Adds the derivative of that residual; with weights {0, 0, 1} exactly the mass matrix. Terms that Newton does not
  /// need may be left out of the velocity and position parts; the linear-linear block is symmetric positive definite.
  virtual void add_tangent(const BodyState&, const double* v_dot, const Vector3& gravity, const TangentWeights&,
                           BodyTangent&) const = 0;
  virtual void marker_kinematics(const BodyState&, int marker, Level, MarkerKinematics&) const = 0;
  virtual BodyEnergy energy(const BodyState&, const Vector3& gravity) const = 0;

  int marker_count() const { return marker_count_; }

 protected:
  /// The handle of a new marker, numbered from 0.
  Marker new_marker() { return {this, marker_count_++}; }
  /// Of a body whose markers are made with it.
  void set_marker_count(int count) { marker_count_ = count; }

 private:
  int marker_count_ = 0;
};

}  // namespace lithe
