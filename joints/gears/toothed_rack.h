#pragma once

#include <array>

#include "engine/assembly/batch.h"
#include "engine/model/appearance.h"
#include "joints/gears/tooth_mesh.h"

namespace lithe {

/// Gear A with elastic teeth and backlash on rack B, spur or helical; it ties nothing else.
///   δ = ±T - j(h)/2 - E(ψ),   T = T₀ + cos α (x - r φ) + u tan β_b,   j(h)/2 = (h - r - x_A m) sin α + backlash/2
/// x, h: of the gear's centre from the rack's marker along x and y of the rack; φ: angle from A's x axis to the rack's
/// about z; u as of ToothedGearPair, whose other conventions hold: z axes about parallel, the flank with + touches
/// where A drives with a torque about +z and pushes the rack along +x. The rack's marker lies on its datum line, where
/// tooth and space are equally wide, its y axis towards the gear. The rack has no end.
class ToothedRack final : public Force</*markers=*/2, ToothMesh::kRows>, public DrawableConnector {
 public:
  struct Parameters {
    GearDesign gears{};  // without teeth_B and shift_B; centre_distance: h
    ToothContact teeth{};
  };
  /// Throws SceneError as GearGeometry and ToothMesh do, and for teeth_B and a number of teeth that is not whole.
  explicit ToothedRack(Parameters parameters);

  const GearGeometry& geometry() const { return geometry_; }
  const ToothMesh& mesh() const { return mesh_; }

  /// The sides of the teeth that touch where the gear drives with a torque about +z and about -z.
  std::array<ToothMesh::Flank, 2> flanks(std::span<const MarkerView> markers, const AngleMemory& memory) const;

  std::vector<MeasuredAngle> angles() const override { return {{.A = 0, .B = 1, .axis = 2}}; }
  bool depends_on_time() const override { return false; }
  void evaluate(double time, std::span<const MarkerView> markers, ForceRows& rows) const override;
  /// Refuses axes that are not about parallel, and a gear a tenth of a module off its distance, or so near that teeth
  /// overlap.
  void initialize(std::span<const MarkerView> markers) override;
  /// The gear with its teeth.
  std::vector<DrawnShape> drawn_shapes(int marker) const override;

 private:
  const Parameters parameters_;
  const GearGeometry geometry_;
  const ToothMesh mesh_;
  double angle_ = 0, place_ = 0, axial_ = 0, pitch_at_ = 0;  // as drawn; pitch_at_: of the pitch point about A
};

extern template std::unique_ptr<ForceBatch> make_force_batch<ToothedRack>();

/// As of ToothedGearPair, for the gear's inertia about its axis (kg m²) and the mass that moves along the rack (kg):
/// 1/m = cos²α (r²/J_A + 1/m_B). Throws SceneError as ToothedRack does, and for one that is not positive.
double critical_damping(const ToothedRack::Parameters& gear, double inertia_A, double mass_B);

}  // namespace lithe
