#pragma once

#include <memory>
#include <string>
#include <vector>

#include "bodies/flexible/modal_basis.h"
#include "engine/observe/observer.h"

namespace lithe {

/// The groups of inertia terms that a body can do without; with any subset of them energy and momenta are conserved
/// (docs/equations.md 2.4), as long as the mass matrix is positive definite.
enum class InertiaGroup {
  Ct,  // the centre of mass moves with the deformation; gravity and acceleration load it
  C0,  // angular momentum of a deformation rate; angular acceleration loads the deformation
  C1,  // the same at second order: Coriolis and gyroscopic forces among modes
  J1,  // the inertia tensor at first order; centrifugal load
  J2,  // the inertia tensor at second order: centrifugal softening
};
std::string to_string(InertiaGroup group);

/// Bounds of a motion, all not negative, body axes.
struct MotionBounds {
  VectorX eta, eta_rate, eta_acceleration;         // a mode each
  Vector3 acceleration = Vector3::Zero();          // of the frame less gravity, m/s²
  Vector3 spin = Vector3::Zero();                  // rad/s
  Vector3 angular_acceleration = Vector3::Zero();  // rad/s²
  /// Widened by a state of a flexible body.
  void include(Snapshot& now, const Body& body);
};
/// Bounds of the motion of a run: simulation.observe(watch, every_step()).
class MotionWatch final : public Observer {
 public:
  explicit MotionWatch(const Body& body) : body_(body) {}
  void observe(Snapshot& now) override { bounds_.include(now, body_); }
  void history(Archive& archive) override;
  const MotionBounds& bounds() const { return bounds_; }

 private:
  const Body& body_;
  MotionBounds bounds_;
};
/// Bounds for a largest displacement (m) expected of the first mode, the others with its energy; each at its own
/// frequency.
MotionBounds motion_of_displacement(const ModalBasis& basis, double displacement);

/// Upper bounds of the terms of a group within the motion's bounds, relative to all terms.
struct InertiaEffect {
  InertiaGroup group;
  double force = 0;       // on the frame, of all that act along
  double moment = 0;      // on the frame, of all that turn it
  double deflection = 0;  // static deflection under the group's modal forces, of that within the bounds, by energy
  double largest() const;
};
struct InertiaEffects {
  std::vector<InertiaEffect> groups;
  std::string report() const;  // a table
};
/// Sizes by the triangle inequality: no motion within the bounds has larger ones. SceneError for a basis that is not
/// of eigenmodes, has a quadratic deflection, or other modes than the bounds.
InertiaEffects inertia_effects(const ModalBasis& basis, const MotionBounds& bounds);

/// Integrals with these groups zero. Where the frame does not have mean axes, the groups balance each other: SceneError
/// if the mass matrix of the undeformed body is then no longer positive definite (only one of Ct and C0 left out). That
/// of a deformed body is as long as what is left out is small.
InertiaIntegrals without(InertiaIntegrals integrals, const std::vector<InertiaGroup>& groups);

struct ReducedInertia {
  std::shared_ptr<const ModalBasis> basis;
  std::vector<InertiaGroup> left_out;
  double error = 0;  // at most this part of forces, moments and deflection is left out: the sum of the groups'
};
/// The basis without the smallest groups that together stay within `bound`. It is one on loads at any instant: over
/// many swings the motions drift apart in phase.
ReducedInertia reduced_to(double bound, const ModalBasis& basis, const MotionBounds& bounds);
/// The basis with other integrals of its modes.
std::shared_ptr<const ModalBasis> with_inertia(const ModalBasis& basis, InertiaIntegrals integrals);

}  // namespace lithe
