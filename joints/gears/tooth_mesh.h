#pragma once

#include <vector>

#include "engine/base/dual.h"
#include "engine/model/force_element.h"
#include "joints/forces/friction_law.h"
#include "joints/gears/mesh_stiffness.h"

namespace lithe {

/// How teeth in mesh act on each other; the same for gears, racks and bevel gears.
struct ToothContact {
  ToothStiffness model = ToothStiffness::weber_banaschek;
  ToothMaterial material{};
  std::vector<double> stiffness{};  // N/m, over the mesh cycle (MeshCycle); that of ToothStiffness::table
  double damping = 0;               // c, N s/m along the line of action
  std::vector<double> error{};      // E, m, over the mesh cycle: what profile error and tip relief take off
  double friction = 0;              // μ between flanks
  double creep_speed = 0.01;        // of the friction, m/s: FrictionLaw
  double phase = 0;                 // of the mesh cycle as drawn; 0: a pair at the pitch point
};

/// Teeth in contact along both lines of action, for either way of driving. On a flank, with its approach δ, its lead
/// mismatch γ and its phase ψ, and the contact spread evenly along the face b,
///   V = k(ψ)/b ∫ ½ max(0, δ - γ y)² dy, y from -b/2 to b/2;   F = ∂V/∂δ + D,   D: LimitedDamping
/// so that an even contact has F = k δ + c δ̇, limited to what never pulls, and where centres are tilted the load moves
/// to one end of the face. Forces are those of the potential: ½ k'(ψ) δ² too acts on the gears.
/// Friction μ(v) F on the sliding of every pair of teeth in contact, among which the force is shared evenly.
class ToothMesh {
 public:
  static constexpr int kRows = 12;
  using Coordinate = Dual<12>;  // with derivatives by the motions of both markers
  static Vector3 value(const Eigen::Matrix<Coordinate, 3, 1>& v) { return {v[0].value, v[1].value, v[2].value}; }

  /// One side of the teeth at one state; vectors in world axes.
  struct Flank {
    Coordinate approach, tilt, phase;  // δ along the line of action, m; γ, rad; ψ, cycles
    Vector3 pitch_point, normal;       // normal: of the transverse force on B
    Vector3 across;                    // unit, at right angles to it: along it teeth slide
  };

  /// Throws SceneError for what is negative or not finite, a table without values and values without a table.
  ToothMesh(const GearGeometry& geometry, const ToothContact& contact);

  /// Six compliant rows, and the friction's loads.
  void add(Flank flank, const MarkerView& A, const MarkerView& B, ForceRows& rows) const;
  /// How deep the teeth are in each other at most along their face, δ + |γ| b/2, m; negative: how far they are apart.
  double depth(const Flank& flank) const;
  /// ψ of the flank that B drives with, where that of A's is `phase`.
  Coordinate back_phase(const Coordinate& phase) const;
  /// Over the mesh cycle, N/m.
  const MeshCycle& stiffness() const { return stiffness_; }
  /// 2 √(k m), N s/m: k the mean of the mesh cycle, 1/m = `mobility` of the approach, 1/kg.
  double critical_damping(double mobility) const;

 private:
  void add_friction(const Flank& flank, double force, const MarkerView& A, const MarkerView& B, ForceRows& rows) const;

  MeshCycle stiffness_, error_;
  FrictionLaw friction_;
  double damping_, half_face_;
  bool rubs_;
  double base_pitch_, approach_, recess_, base_helix_, thickness_;  // thickness_: of a tooth of A, cycles
};

}  // namespace lithe
