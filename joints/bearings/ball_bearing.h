#pragma once

#include <optional>

#include "joints/bearings/hertz.h"
#include "joints/bearings/rolling_bearing.h"
#include "joints/bearings/spinning_ball.h"

namespace lithe {

/// Ball bearing, deep groove or angular contact, between the markers of inner ring and outer ring (see RollingBearing).
/// The centres of curvature of the two grooves are A₀ = r_i + r_o - D apart where the ball just touches; in its plane
///   d = (A₀ sin α + w - R q,  A₀ cos α - s/2 + p + z q),   δ = |d| - A₀,   Q = k δ^(3/2),   V = ⅖ k δ^(5/2)
/// d: axial and radial, from the outer groove's centre to the inner one's; R, z: radius and place along z of the
/// latter; k: both contacts in series, k^(-2/3) = k_i^(-2/3) + k_o^(-2/3), each by HertzPoint at the contact angle α.
/// The line of d is that of contact: its angle changes with the load. (Harris & Kotzalas, Rolling Bearing Analysis, ch.
/// 7; de Mul, Vree & Maas 1989.) At a given `speed` the balls are thrown outwards and lie in a balance of their own
/// (SpinningBall): the outer ring's angle falls, the inner one's rises, and the stiffness depends on the speed.
class BallBearing final : public RollingBearing {
 public:
  struct Parameters {
    int balls = 0;                   // Z
    double ball_diameter = 0;        // D, m
    double pitch_diameter = 0;       // d_m, m: of the circle of the balls' centres
    double inner_groove_radius = 0;  // r_i, m, some 0.515 D
    double outer_groove_radius = 0;  // r_o, m
    double contact_angle = 0;        // α, rad: without load; positive where the inner ring is pushed along +z
    double clearance = 0;            // s, m: diametral, of the rings as drawn; negative: interference
    double preload = 0;              // N: axial load of the rings as drawn, in the sense of the contact angle, at rest
    double speed = 0;                // rad/s: of the inner ring, the outer one at rest, for the balls' centrifugal load
    double ball_density = 7800;      // kg/m³; 3200 of silicon nitride
    BearingMaterial material{};
    BearingLosses losses{};
  };
  /// Throws SceneError for balls that do not fit, grooves narrower than the balls, and a preload beyond the grooves.
  explicit BallBearing(Parameters parameters);
  /// k, N/m^(3/2): of a ball between both rings.
  double contact_stiffness() const { return stiffness_; }

 private:
  PlaneLoad in_plane(const Vector3& motion) const override;
  PlaneLoad at_rest(const Vector3& motion) const;
  Eigen::Matrix<double, 2, 3> by_motion() const;  // ∂d/∂(w, p, q)

  double distance_ = 0, stiffness_ = 0;  // A₀, k
  double axial_ = 0, radial_ = 0;        // d as drawn
  double groove_radius_ = 0, groove_place_ = 0;
  std::optional<SpinningBall> spinning_;
};

extern template std::unique_ptr<ForceBatch> make_force_batch<BallBearing>();

}  // namespace lithe
