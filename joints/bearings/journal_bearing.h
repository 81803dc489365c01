#pragma once

#include "engine/assembly/batch.h"
#include "engine/model/appearance.h"
#include "engine/model/force_element.h"
#include "engine/observe/sensors.h"

namespace lithe {

/// Plain journal bearing, short (Ocvirk): Reynolds' equation with flow along z alone, in the film's half with pressure
/// (Gümbel's boundary, which moves with the journal), between the markers of journal and bush. In the axes of the bush,
/// ε = e/c the journal's centre and ω its speed relative to the bush,
///   h = c (1 - ε·n),   w = (2 ẋ + ω y, 2 ẏ - ω x),   F = -(μ R L³ / 2 c³) ∫ (w·n) n (1 - ε·n)⁻³ dβ  where w·n > 0
/// with n = (cos β, sin β), in closed form. Torque on the journal about its centre: -2π μ R³ L ω / (c (1 - ε²)^(1/2))
/// of shear and -½ (e × F) of pressure, so that the film never gives power. No axial force, no moment across z: combine
/// it with what holds these. The force grows beyond all bounds as the film closes. From ε = 0.9999 on it is that of the
/// film there, so that no step of a method meets a pole; beyond 1.5 SimulationError.
class JournalBearing final : public Force</*markers=*/2, /*rows=*/0>, public DrawableConnector {
 public:
  struct Parameters {
    double radius = 0;     // R, m
    double length = 0;     // L, m: below the diameter, for the theory of the short bearing
    double clearance = 0;  // c, m: radial
    double viscosity = 0;  // μ, dynamic, Pa s
  };
  /// Throws SceneError for what is not positive, a clearance of a tenth of the radius or more, and L > 2 R.
  explicit JournalBearing(Parameters parameters);
  bool depends_on_time() const override { return false; }
  void evaluate(double time, std::span<const MarkerView> markers, ForceRows& rows) const override;
  /// Refuses z axes that differ and a journal drawn outside its clearance.
  void initialize(std::span<const MarkerView> markers) override;
  std::vector<DrawnShape> drawn_shapes(int marker) const override;

  /// Force of the film on the journal, N: at its place (x, y), m, with its velocity, m/s, both in the axes of the bush,
  /// at the speed ω of the journal relative to the bush, rad/s.
  Eigen::Vector2d film_force(const Eigen::Vector2d& place, const Eigen::Vector2d& velocity, double speed) const;
  double clearance() const { return parameters_.clearance; }

 private:
  const Parameters parameters_;
};

extern template std::unique_ptr<ForceBatch> make_force_batch<JournalBearing>();

/// ε = e/c of a journal bearing, and the angle of its line of centres about z of the bush, from x, rad: columns
/// eccentricity, angle.
Sensor eccentricity(const JournalBearing& bearing, Located name = "");

}  // namespace lithe
