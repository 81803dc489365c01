#pragma once

#include "engine/base/math.h"

namespace lithe {

/// Elastic coordinates of a scene as uncoupled oscillators about a motion that does not know them:
///   δη̈ + A (D δη̇ + K δη) = a(t),   A = the elastic block of the inverse of [M Gᵀ; G 0], D and K diagonal,
/// a(t): the accelerations that the motion would give them. A takes in that bodies recoil and what joints hold. In the
/// eigenvectors of √K A √K each is  z̈ + d ż + Λ z = g(t), whose response is exact for g linear between the samples.
class DrivenOscillators {
 public:
  /// A (n x n, symmetric, maybe singular: what joints hold), D and K > 0 by their diagonals.
  DrivenOscillators(const MatrixX& A, const VectorX& damping, const VectorX& stiffness);

  struct Response {
    MatrixX displacement, rate, acceleration;  // of δη, n x samples
  };
  /// `accelerations`: n x samples, evenly spaced by `interval` s; start: δη and δη̇ at the first.
  Response respond(const MatrixX& accelerations, double interval, const VectorX& start,
                   const VectorX& start_rate) const;
  /// Accelerations of unit forces.
  const MatrixX& mobility() const { return A_; }
  /// Forces of unit accelerations: the inverse, zero for what is held.
  MatrixX inertia() const;
  /// ω of the oscillators, rad/s, ascending; 0: held.
  const VectorX& frequencies() const { return frequencies_; }

 private:
  MatrixX A_, V_;  // V: eigenvectors
  VectorX root_;   // √K
  VectorX frequencies_, damping_;
};

}  // namespace lithe
