#pragma once

#include "bodies/beam/beam_span.h"
#include "bodies/beam/se3_internal.h"

namespace lithe {

/// The twist of a span at ξ by those of its ends, v = (v_A, v_B): V = N v, V_dot = N v_dot + bias(v); with P =
/// [-T⁻¹(-d), T⁻¹(d)], d_dot = P v and y = Ad(exp(-ξ d)) v_A
///   N = [Ad(exp(-ξ d)), 0] + ξ T(ξ d) P
///   bias = ad(y) W + ξ² (∂T(ξ d) d_dot) d_dot + ξ T(ξ d) (∂T⁻¹(d) v_B + ∂T⁻¹(-d) v_A) d_dot,   W = ξ T(ξ d) d_dot
class SpanField {
 public:
  using Vector12 = BeamSpan::Vector12;
  using Matrix6x12 = Eigen::Matrix<double, 6, 12>;

  SpanField(double xi, const Vector6& d);
  const Matrix6x12& shapes() const { return N_; }
  /// exp(ξ d).
  const se3::Pose& pose() const { return here_; }
  Vector6 bias(const Vector12& v) const;
  /// Its derivative by v.
  Matrix6x12 bias_rates(const Vector12& v) const;

 private:
  const double xi_;
  const Vector6 d_, along_;
  const se3::Analytic right_, inverse_;
  const se3::Pose here_;
  Matrix6 carry_, T_;  // Ad(exp(-ξ d)), ξ T(ξ d)
  Matrix6x12 P_, N_;
};

}  // namespace lithe
