#pragma once

#include <span>
#include <vector>

#include "engine/model/body.h"

namespace lithe {

/// How deformation moves the nodes of a body.
enum class Deflection {
  linear,     // u = B η: no stiffening by spin or load
  stiffened,  // with the displacements of second order that carry geometric stiffness: small deflection, any load
  quadratic,  // and with the strain energy to fourth order: moderately large deflection
  exact,      // no modes: coordinates of the body's nodes, any deflection
};

/// The detail in which a scene models a deformable body: a selection of its candidate modes, none for a rigid body; or
/// its nodes, Deflection::exact. The coordinate of a mode means the same at every fidelity, as does the body's frame.
struct Fidelity {
  std::vector<int> modes{};  // from 0, rising
  Deflection deflection = Deflection::linear;
  int elements = 0;  // of a body that can be drawn with any number; 0: as drawn
  bool operator==(const Fidelity&) const = default;
};

/// A force and a torque at a marker of a body, about the marker's point, world axes.
struct MarkerLoad {
  int marker;  // of the body
  Vector3 force, torque;
};

/// A body that can be modelled in more or less detail, from which solve() chooses (engine/study/solve.h). Its candidate
/// modes are orthonormal in mass and orthogonal in stiffness: M = E, K = diag(ω²).
class DeformableBody : public Body {
 public:
  /// ω² of each candidate mode, rad²/s²; empty: the body has one model only.
  virtual VectorX candidate_stiffness() const = 0;
  /// 2 ζ ω of each, 1/s.
  virtual VectorX candidate_damping() const = 0;
  /// The highest order for which its modes have data.
  virtual Deflection finest_deflection() const = 0;
  /// Of a body that can be drawn with any number of elements, and exact: how many it gets where so many are asked for
  /// (0: as drawn). 0: it has one mesh.
  virtual int element_count(int /*asked*/) const { return 0; }
  virtual const Fidelity& fidelity() const = 0;
  /// Takes effect with the next assemble(); systems assembled before must not be used any more. Markers stay valid.
  /// Throws SceneError for modes or a deflection that the body does not have.
  virtual void set_fidelity(Fidelity fidelity) = 0;
  /// The body's frame, which does not follow the deformation; always the same marker.
  virtual Marker body_frame() = 0;
  /// Largest displacement of a node by a unit of each candidate mode, m.
  virtual VectorX candidate_reach() const = 0;
  /// Generalised force on each candidate mode, in use or not, N per unit of η (√kg m): of loads at markers, of gravity,
  /// and of the inertia of the frame's motion (v_dot: of the body, v_count long), at the present deflection; with its
  /// second order where that is in use. Modal markers are left out. Empty: the body has one model only.
  virtual VectorX candidate_forces(const BodyState&, const double* v_dot, std::span<const MarkerLoad> loads,
                                   const Vector3& gravity) const = 0;
};

}  // namespace lithe
