#pragma once

#include <limits>

#include "engine/assembly/batch.h"
#include "engine/model/force_element.h"
#include "engine/model/joint_coordinate.h"

namespace lithe {

/// Limits the travel of a joint coordinate: at δ beyond a limit a Hunt-Crossley contact, which never pulls, pushes it
/// back.
///   F = k δⁿ max(0, 1 + d δ̇),   V = k δⁿ⁺¹ / (n + 1)
/// (Hunt and Crossley 1975; d = 3/2 (1 - e) / v_impact for a restitution e near 1)
class CoordinateStop final : public Force</*markers=*/2, /*rows=*/1> {
 public:
  struct Parameters {
    double lower = -std::numeric_limits<double>::infinity();  // m or rad
    double upper = std::numeric_limits<double>::infinity();   // m or rad
    double stiffness = 0;                                     // k, N/mⁿ or N m/radⁿ
    double exponent = 1.5;                                    // n
    double dissipation = 0;                                   // d, s/m or s/rad
  };
  /// Throws SceneError for a lower limit that is not below the upper, no limit at all, a stiffness that is not
  /// positive, an exponent below one, a negative dissipation, and for more than one coordinate.
  CoordinateStop(CoordinateSet coordinate, Parameters parameters);

  std::vector<MeasuredAngle> angles() const override { return coordinate_.angles(); }
  bool depends_on_time() const override { return false; }
  void evaluate(double time, std::span<const MarkerView> markers, ForceRows& rows) const override;
  std::vector<CoordinateSwitch> switches() const override;

 private:
  const CoordinateSet coordinate_;
  const Parameters parameters_;
};

extern template std::unique_ptr<ForceBatch> make_force_batch<CoordinateStop>();

}  // namespace lithe
