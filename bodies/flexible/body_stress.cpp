#include "bodies/flexible/body_stress.h"

#include "engine/base/error.h"

namespace lithe {
namespace {

std::shared_ptr<const StressRecovery> recovery_of(const ModalBasis& basis) {
  return std::make_shared<StressRecovery>(basis,
                                          basis.deflection ? StrainMeasure::green_lagrange : StrainMeasure::small);
}

}  // namespace

BodyStress::BodyStress(const FlexibleBody& body) : BodyStress(body, nullptr) {}

BodyStress::BodyStress(const FlexibleBody& body, std::shared_ptr<const StressRecovery> recovery)
    : body_(&body), recovery_(recovery ? std::move(recovery) : recovery_of(body.basis())) {
  const ModalBasis& basis = body.basis();
  const int fields = basis.mode_count() + (basis.deflection ? basis.deflection->field_count() : 0);
  const auto nodes = static_cast<int>(basis.nodes.cols());
  if (recovery_->coordinate_count() != fields || recovery_->node_count() != nodes)
    throw SceneError("stresses of " + std::to_string(recovery_->coordinate_count()) + " fields at " +
                         std::to_string(recovery_->node_count()) + " nodes, for a basis of " + std::to_string(fields) +
                         " at " + std::to_string(nodes),
                     "'" + body.name() + "' of " + body.where(), "make the recovery from the body's own basis");
}

/// Of all fields of the basis: those beyond the body's modes rest.
VectorX BodyStress::coordinates(Snapshot& snapshot) const {
  const VectorX moved = body_->field_coordinates(snapshot.body_state(*body_));
  if (moved.size() > recovery_->coordinate_count())
    throw SceneError("stresses of " + std::to_string(recovery_->coordinate_count()) + " fields of '" + body_->name() +
                         "', which now has " + std::to_string(moved.size()),
                     body_->where(), "make what reads its stresses after set_fidelity()");
  VectorX all = VectorX::Zero(recovery_->coordinate_count());
  all.head(moved.size()) = moved;
  return all;
}

Matrix6X BodyStress::stress(const VectorX& coordinates) const {
  return turned_stress(recovery_->stress(coordinates), body_->basis().rotation);
}

Matrix6X BodyStress::strain(Snapshot& snapshot) const {
  Matrix6X strain = recovery_->strain(coordinates(snapshot));
  strain.bottomRows<3>() /= 2;  // a tensor to be turned
  strain = turned_stress(strain, body_->basis().rotation);
  strain.bottomRows<3>() *= 2;
  return strain;
}

}  // namespace lithe
