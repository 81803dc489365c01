#pragma once

#include "engine/assembly/batch.h"
#include "engine/model/force_element.h"

namespace lithe {

/// Elastic bearing: six springs and dampers between two markers, coupled by its matrices.
///   e = (R_Aᵀ d, log(R_Aᵀ R_B)) - e₀,   F = K e + D ė,   V = ½ eᵀ K e,   d = p_B - p_A, e₀ as drawn or zero
/// Displacements and rotations (rotation vector, below half a turn) in the axes of A, in that order. K and D may be any
/// symmetric positive semidefinite matrices: they are diagonalised together (K = P Λ Pᵀ, D = P (E - Λ) Pᵀ), which gives
/// six compliant rows.
class Bushing final : public Force</*markers=*/2, /*rows=*/6> {
 public:
  struct Parameters {
    Matrix6 stiffness = Matrix6::Zero();  // K: N/m, N, N m/rad
    Matrix6 damping = Matrix6::Zero();    // D: N s/m, N s, N m s/rad
    bool relaxed_as_drawn = true;         // false: free of force where the markers coincide
  };
  /// Throws SceneError for matrices that are not symmetric, have a negative eigenvalue, or hold a value that is not
  /// finite.
  explicit Bushing(Parameters parameters);
  /// K or D of a bushing without couplings.
  static Matrix6 diagonal(const Vector3& translation, const Vector3& rotation);

  bool depends_on_time() const override { return false; }
  void evaluate(double time, std::span<const MarkerView> markers, ForceRows& rows) const override;
  void initialize(std::span<const MarkerView> markers) override;

 private:
  const bool relaxed_as_drawn_;
  Matrix6 rows_;                 // Pᵀ
  Vector6 stiffness_, damping_;  // Λ, E - Λ
  Vector6 offset_ = Vector6::Zero();
};

extern template std::unique_ptr<ForceBatch> make_force_batch<Bushing>();

}  // namespace lithe
