#pragma once

#include <memory>

#include "bodies/flexible/elements/stress_recovery.h"
#include "bodies/flexible/flexible_body.h"
#include "engine/observe/snapshot.h"

namespace lithe {

/// Stresses and strains of a flexible body in a scene, as observers read them off its states: 6 x n, xx yy zz xy xz yz
/// as in StressRecovery, in the axes of the mesh, which turn with the body frame, as the finite-element code shows
/// them.
class BodyStress {
 public:
  /// By the elements of the body's basis: with small strain, or, where the deflection is quadratic, Green-Lagrange
  /// (small strain would take its foreshortening for compression). Throws SceneError without elements or materials.
  explicit BodyStress(const FlexibleBody& body);
  /// By a recovery that is there: of another measure, of stress modes from a file; null: as above. SceneError for
  /// another number of nodes or coordinates than the body's basis has.
  BodyStress(const FlexibleBody& body, std::shared_ptr<const StressRecovery> recovery);

  const FlexibleBody& body() const { return *body_; }
  Matrix6X stress(Snapshot& snapshot) const { return stress(coordinates(snapshot)); }
  /// Of all fields of the basis; and the stress of such coordinates, kept from a run. SceneError for another number.
  VectorX coordinates(Snapshot& snapshot) const;
  Matrix6X stress(const VectorX& coordinates) const;
  /// Engineering shear. SceneError for stress modes.
  Matrix6X strain(Snapshot& snapshot) const;

 private:
  const FlexibleBody* body_;
  std::shared_ptr<const StressRecovery> recovery_;
};

}  // namespace lithe
