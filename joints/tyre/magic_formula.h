#pragma once

#include "joints/tyre/tyre_coefficients.h"

namespace lithe {

/// Force and moment of a tyre by its slip: the Magic Formula, version 6.1, pure and combined slip with camber and
/// inflation pressure (Besselink, Schmeitz and Pacejka, Vehicle System Dynamics 48 (2010) 337-352; Pacejka, Tire and
/// Vehicle Dynamics, 3rd edition 2012, section 4.3, equations 4.E1 to 4.E78), without turn slip (ζ_i = 1).
/// Where these differ the paper is followed: q_dz3 takes the signed camber, q_bz4 is that of .tir files. Each force is
///   y = D sin(C atan(B x - E (B x - atan(B x))))
/// of a slip x, times a cosine of the same make of the other slip. Axes of the contact patch (ISO 8855, W): x forward
/// in the wheel's plane, y to the left, z normal to the road; forces and moments of the road on the tyre. A value,
/// without a state of the engine.
class MagicFormula {
 public:
  struct Slip {
    double kappa = 0;     // κ = -V_sx / |V_x|
    double alpha = 0;     // rad; tan α = V_sy / |V_x|: positive where the wheel slips to the left
    double camber = 0;    // γ, rad: positive about x, a wheel that leans to the right seen from behind
    double load = 0;      // F_z, N
    double speed = 0;     // V_x, m/s
    double pressure = 0;  // p, Pa; 0: inflpres of the tyre
  };
  struct Reaction {
    double Fx = 0, Fy = 0;          // N
    double Mx = 0, My = 0, Mz = 0;  // N m
  };
  /// ∂F_x/∂κ and ∂F_y/∂α at zero slip, N: K_xκ > 0, K_yα < 0 of usual tyres.
  struct Stiffness {
    double longitudinal, cornering;
  };

  /// Throws SceneError for a coefficient that is not finite, and for nominal load, radius, speeds, shape factors and
  /// slip stiffnesses that are zero or have the wrong sign.
  explicit MagicFormula(const TyreCoefficients& coefficients);

  /// Zero without load. Slip, camber and load beyond the tyre's ranges act as at their end. Aligning and rolling
  /// moments turn with the direction of travel, smoothly within ± vxlow: at rest there are none.
  Reaction at(const Slip& slip) const;
  Stiffness stiffness(double load, double camber = 0, double pressure = 0) const;
  /// Of the direction of travel: -1 to 1, sin(π V_x / (2 vxlow)) within ± vxlow.
  double direction(double speed) const;

  const TyreCoefficients& coefficients() const { return c_; }

 private:
  struct Point;  // what all formulas of one load, camber and pressure share
  Point point(double load, double camber, double pressure) const;

  TyreCoefficients c_;
};

}  // namespace lithe
