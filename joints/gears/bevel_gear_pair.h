#pragma once

#include <array>

#include "engine/assembly/batch.h"
#include "engine/model/appearance.h"
#include "joints/gears/tooth_mesh.h"

namespace lithe {

/// Two straight bevel gears with elastic teeth and backlash on z axes that meet in an apex, at any shaft angle; their
/// markers lie anywhere on the axes, z away from the apex. It ties nothing else.
///   δ = ±T - (sin α (m·e + R (Σ - Σ₀)) + backlash/2) - E(ψ),   T = T₀ - cos α (r_A φ_A + r_B φ_B + t·e)
/// φ: angle of the other axis about either gear's own, e: apex of B from that of A, Σ: angle between the axes, R: cone
/// distance to the middle of the face, r = R sin(cone angle); t: across the axes, the way in which A's teeth move under
/// the torque +z for which the flank with + touches; m: at right angles to t and to the cones' common line. Teeth are
/// those of the virtual spur gears, z/cos(cone angle) (Tredgold), with the module in the middle of the face. T is taken
/// within half a base pitch: teeth that are pushed further skip. As drawn, teeth stand in the middle of their backlash.
/// Limits: no crowning, no shift of the load along the face.
class BevelGearPair final : public Force</*markers=*/2, ToothMesh::kRows>, public DrawableConnector {
 public:
  struct Parameters {
    double module = 0;                           // in the middle of the face, m
    double teeth_A = 0, teeth_B = 0;             // z
    double shaft_angle = 1.5707963267948966;     // Σ₀, rad
    double pressure_angle = 0.3490658503988659;  // α, rad: 20°
    double face_width = 0;                       // b, m
    double backlash = 0;                         // play along the line of action, m
    ToothContact teeth{};
  };
  /// Throws SceneError as GearGeometry and ToothMesh do of the virtual gears, for numbers of teeth that are not whole,
  /// a shaft angle at which a cone is flat or hollow, and a face that reaches the apex.
  explicit BevelGearPair(Parameters parameters);

  /// Of the virtual spur gears.
  const GearGeometry& geometry() const { return geometry_; }
  const ToothMesh& mesh() const { return mesh_; }
  double cone_angle_A() const { return cone_A_; }  // δ_A, rad
  double cone_angle_B() const { return parameters_.shaft_angle - cone_A_; }

  /// The sides of the teeth that touch where A drives with a torque about +z and about -z. Its angles are taken within
  /// half a base pitch: no memory is read.
  std::array<ToothMesh::Flank, 2> flanks(std::span<const MarkerView> markers, const AngleMemory& memory) const;

  bool depends_on_time() const override { return false; }
  void evaluate(double time, std::span<const MarkerView> markers, ForceRows& rows) const override;
  /// Refuses axes that do not meet to a tenth of a module, and another angle between them than shaft_angle.
  void initialize(std::span<const MarkerView> markers) override;
  std::vector<DrawnShape> drawn_shapes(int marker) const override;

 private:
  const Parameters parameters_;
  const double cone_A_;
  const GearGeometry geometry_;
  const ToothMesh mesh_;
  double bearing_A_ = 0, bearing_B_ = 0;  // as drawn
  double apex_A_ = 0, apex_B_ = 0;        // along z of either marker, m
};

extern template std::unique_ptr<ForceBatch> make_force_batch<BevelGearPair>();

/// As of ToothedGearPair: 1/m = cos²α (r_A²/J_A + r_B²/J_B), the radii in the middle of the face. Throws SceneError as
/// BevelGearPair does, and for an inertia that is not positive.
double critical_damping(const BevelGearPair::Parameters& gears, double inertia_A, double inertia_B);

}  // namespace lithe
