#pragma once

#include <array>

#include "engine/assembly/batch.h"
#include "engine/model/appearance.h"
#include "joints/gears/tooth_mesh.h"

namespace lithe {

/// Two involute gears with elastic teeth and backlash on about parallel z axes, spur or helical, external or internal;
/// it ties nothing else: hold each by a bearing, on ground or on a carrier.
///   δ = ±T - j(a)/2 - E(ψ),   T = T₀ - r_bA φ_A - r_bB φ_B + u tan β_b,   cos α = |r_bA + r_bB|/a
/// φ: angles of the line of centres against each gear, u: axial displacement of B at the pitch point, a: distance of
/// the axes; all as they are now, so that errors of alignment and bearings that give way change line of action and
/// backlash (GearGeometry). The flank with + is the one that touches where A drives with a torque about +z; on it B
/// feels F along the line of action and -F tan β_b along z. Tilted axes move the load along the face (ToothMesh). As
/// drawn, teeth stand in the middle of their backlash. Limits: every section along the face is at the same phase of its
/// cycle; gear bodies are rigid beyond the foundation of their teeth; Newton's matrix, not the force, neglects the
/// coupling of friction with elastic coordinates.
///   graph.add<ToothedGearPair>("mesh", {pinion.marker(), wheel.marker()},
///       {.gears = {.module = 3e-3, .teeth_A = 20, .teeth_B = 31, .face_width = 0.03}, .teeth = {.damping = 200}});
class ToothedGearPair final : public Force</*markers=*/2, ToothMesh::kRows>, public DrawableConnector {
 public:
  struct Parameters {
    GearDesign gears{};
    ToothContact teeth{};
  };
  /// Throws SceneError as GearGeometry and ToothMesh do, and for numbers of teeth that are not whole, or a rack.
  explicit ToothedGearPair(Parameters parameters);

  const GearGeometry& geometry() const { return geometry_; }
  const ToothMesh& mesh() const { return mesh_; }

  /// The sides of the teeth that touch where A drives with a torque about +z and about -z.
  std::array<ToothMesh::Flank, 2> flanks(std::span<const MarkerView> markers, const AngleMemory& memory) const;

  std::vector<MeasuredAngle> angles() const override {
    return {{.A = 0, .B = 1, .axis = 2, .to_point = true}, {.A = 1, .B = 0, .axis = 2, .to_point = true}};
  }
  bool depends_on_time() const override { return false; }
  void evaluate(double time, std::span<const MarkerView> markers, ForceRows& rows) const override;
  /// Refuses axes that are not about parallel, and centres a hundredth off the centre distance or so near that teeth
  /// overlap.
  void initialize(std::span<const MarkerView> markers) override;
  /// The gear with its teeth.
  std::vector<DrawnShape> drawn_shapes(int marker) const override;

 private:
  const Parameters parameters_;
  const GearGeometry geometry_;
  const ToothMesh mesh_;
  double bearing_A_ = 0, bearing_B_ = 0, axial_ = 0;  // as drawn
};

extern template std::unique_ptr<ForceBatch> make_force_batch<ToothedGearPair>();

/// Critical damping of teeth in contact, 2 √(k m), N s/m, for gears with these inertias about their axes (kg m²): k the
/// mean of the mesh cycle, 1/m = r_bA²/J_A + r_bB²/J_B. For a ratio of it: .damping = 0.07 * critical_damping(…).
/// Throws SceneError as ToothedGearPair does, and for an inertia that is not positive.
double critical_damping(const ToothedGearPair::Parameters& gears, double inertia_A, double inertia_B);

}  // namespace lithe
