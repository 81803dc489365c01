#pragma once

#include "engine/base/math.h"

namespace lithe::bench {

/// A rubber strip of 1 m, 20 x 10 mm: E = 1e7 Pa, ν = 0.5, 1100 kg/m³, its section as BeamSection::rectangle() would
/// make it but for the shear and torsion factors.
struct BeamScene {
  static constexpr double kLength = 1, kModulus = 1e7, kShear = kModulus / 3, kDensity = 1100;
  static constexpr double kEdge2 = 0.02, kEdge3 = 0.01;
  static constexpr double kArea = kEdge2 * kEdge3, kMass = kDensity * kArea;
  static constexpr double kI2 = kEdge2 * kEdge3 * kEdge3 * kEdge3 / 12, kI3 = kEdge3 * kEdge2 * kEdge2 * kEdge2 / 12;

  /// N; N m².
  static Vector6 stiffness() {
    return (Vector6() << kModulus * kArea, 5.0 / 6 * kShear * kArea, 5.0 / 6 * kShear * kArea,
            0.7 * kShear * (kI2 + kI3), kModulus * kI2, kModulus * kI3)
        .finished();
  }
  /// Mass moments per length, kg m.
  static Vector3 inertia() { return {kDensity * (kI2 + kI3), kDensity * kI2, kDensity * kI3}; }
};

}  // namespace lithe::bench
