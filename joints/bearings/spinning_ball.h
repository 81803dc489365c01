#pragma once

#include "engine/base/math.h"

namespace lithe {

/// A ball between two grooves that its orbit throws outwards, in its plane (axial, radial), from the outer groove's
/// centre: Harris & Kotzalas, Advanced Concepts of Bearing Technology, ch. 3, without gyroscopic moment. The ball's
/// centre b takes the place of least energy,
///   U(d) = min_b  V_o(|b| - L_o) + V_i(|d - b| - L_i) - F b_r,   V(δ) = ⅖ k δ^(5/2),   F = m r ω_c²
/// d: the inner groove's centre; L: groove's radius less the ball's. So the contact angles differ: Q_o cos α_o = Q_i
/// cos α_i + F, Q_o sin α_o = Q_i sin α_i. U counts from a ball that the outer ring alone holds.
class SpinningBall {
 public:
  struct Contact {
    double length = 0, stiffness = 0;  // L, m; k, N/m^(3/2)
  };
  /// F positive, N.
  SpinningBall(Contact inner, Contact outer, double centrifugal);

  struct Balance {
    double energy = 0;                                        // U, J
    Eigen::Vector2d force = Eigen::Vector2d::Zero();          // ∂U/∂d: of the inner contact, N
    Eigen::Matrix2d stiffness = Eigen::Matrix2d::Zero();      // ∂²U/∂d²
    double inner_angle = 0, outer_angle = 0, outer_load = 0;  // rad, N
  };
  Balance at(const Eigen::Vector2d& d) const;

 private:
  Contact inner_, outer_;
  double centrifugal_;
  Eigen::Vector2d thrown_;  // b without the inner ring
  double thrown_energy_;
};

}  // namespace lithe
