#pragma once

#include "engine/assembly/batch.h"
#include "engine/model/appearance.h"
#include "joints/gears/chain_span.h"

namespace lithe {

/// A closed roller chain, or toothed belt, around two sprockets on about parallel z axes; mean ratio z_A/z_B.
///   T = max(0, k (Λ - L)) + D,   k = EA/L₀,   V = ½ k (Λ - L)²,   D: LimitedDamping
/// A chain lies on polygons: joints at the radius p/(2 sin(π/z)), one of them on each marker's x axis. Its span runs
/// along the common tangent of both polygons, Λ between two joints; where a sprocket turns by a tooth the next joint
/// takes over, and with it a link of length p (polygon effect: speed and arm change by 1 - cos(π/z)). A belt lies on
/// the pitch circles, p z/2π. L: material of the span, which sprockets take in and give out; L₀ that of the drawing,
/// where both spans have the pretension. Slack spans carry nothing. Joints stay on their teeth. Limits: no mass, so no
/// weight, no catenary and no centrifugal force; the number of links is what the drawing asks for, whole or not.
///   graph.add<SprocketPair>("chain", {crank.marker(), wheel.marker()},
///       {.teeth_A = 17, .teeth_B = 38, .pitch = 12.7e-3, .axial_stiffness = 1e6, .pretension = 50});
class SprocketPair final : public Force</*markers=*/2, /*rows=*/2>, public DrawableConnector {
 public:
  struct Parameters {
    int teeth_A = 0, teeth_B = 0;  // z
    double pitch = 0;              // p, m
    double axial_stiffness = 0;    // EA, N
    double damping = 0;            // c of a span, N s/m
    double pretension = 0;         // as drawn, N
    double slack = 0;              // of either span as drawn, m; where there is no pretension
    bool polygon = true;           // false: a toothed belt
  };
  /// Throws SceneError for fewer than five teeth, a pitch or stiffness that is not positive, and what is negative or
  /// not finite.
  explicit SprocketPair(Parameters parameters);

  std::vector<MeasuredAngle> angles() const override { return ChainSpan::bearings(); }
  bool depends_on_time() const override { return false; }
  void evaluate(double time, std::span<const MarkerView> markers, ForceRows& rows) const override;
  /// Refuses axes that are not about parallel, and sprockets that overlap.
  void initialize(std::span<const MarkerView> markers) override;
  std::vector<DrawnShape> drawn_shapes(int marker) const override;
  void drawn_line(std::span<const MarkerView> markers, const AngleMemory& memory, Matrix3X& points) const override;

 private:
  /// On the left (1) or on the right (-1) of the way from A to B seen against z.
  ChainSpan span(int side, std::span<const MarkerView> markers, const AngleMemory& memory) const;

  const Parameters parameters_;
  const ChainDrive chain_;
  const double radius_A_, radius_B_;
  ChainMaterial material_[2];
};

extern template std::unique_ptr<ForceBatch> make_force_batch<SprocketPair>();

}  // namespace lithe
