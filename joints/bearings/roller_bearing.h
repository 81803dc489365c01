#pragma once

#include "joints/bearings/rolling_bearing.h"

namespace lithe {

/// Cylindrical roller bearing without ribs, of steel, between the markers of inner ring and outer ring (see
/// RollingBearing): it carries radial load and tilting moment, no axial load. Line contact in n slices along the
/// roller (ISO/TS 16281:2008, 5.2), at z_k from its middle,
///   δ_k = p + z_k q - s/2 - 2 P(z_k),   Q_k = (c/n) δ_k^(10/9),   c = 35948 N/mm^(10/9) (L/mm)^(8/9)
/// c: contacts with both rings. P: how much thinner the roller is there, on each side: a table, linear between its
/// points, or the logarithmic profile of the standard, P = 0.00035 D ln(1 / (1 - (2z/L)²)); of rollers longer than 2.5
/// D 0.0005 D ln(1 / (1 - ((2|z| - (L - 2.5 D)) / 2.5 D)²)) at the ends alone.
class RollerBearing final : public RollingBearing {
 public:
  struct Parameters {
    int rollers = 0;                      // Z
    double roller_diameter = 0;           // D, m
    double roller_length = 0;             // L, m: effective
    double pitch_diameter = 0;            // d_m, m
    double clearance = 0;                 // s, m: diametral; negative: interference
    int slices = 30;                      // n
    std::vector<double> profile_place{};  // z from the roller's middle, m, ascending
    std::vector<double> profile_drop{};   // P there, m; none: logarithmic
    BearingLosses losses{};
  };
  /// Throws SceneError for rollers that do not fit, and a profile that is no table over the roller's length.
  explicit RollerBearing(Parameters parameters);

 private:
  PlaneLoad in_plane(const Vector3& motion) const override;

  double stiffness_;                  // c/n
  std::vector<double> place_, free_;  // z_k; s/2 + 2 P(z_k)
};

extern template std::unique_ptr<ForceBatch> make_force_batch<RollerBearing>();

}  // namespace lithe
