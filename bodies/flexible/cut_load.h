#pragma once

#include <vector>

#include "bodies/flexible/flexible_body.h"
#include "engine/observe/sensors.h"

namespace lithe {

/// Where a flexible body is cut, as drawn: a part of its elements comes off. Mesh axes, which turn with the body frame.
struct BodyCut {
  Vector3 point{0, 0, 0};              // m: moments are about it; it moves with the mean of the cut's nodes
  Matrix3 axes = Matrix3::Identity();  // of the results: columns 1 (out of the part), 2 and 3
  std::vector<int> nodes{};            // labels: elements that have nodes among these alone are the part;
                             // none: elements whose centre lies behind the plane through `point` across axis 1
};

/// The stress resultants over a cut: force and moment of the rest of the body on the part, as the elements of the part
/// have them at the nodes that they share with others,
///   F = Σ_i f_i,   M = Σ_i (r_i + u_i - c) × f_i,   f = K_part u,
/// by a matrix on the elastic coordinates that is made once: n_1 is the axial force (tension positive), n_2 and n_3 are
/// shear forces, m_1 is the torque, m_2 and m_3 are bending moments. With a quadratic deflection, f holds the terms of
/// second order in η of the Green-Lagrange strain, and u counts; else the loads are linear in η.
/// These are the integrals of the stress. Of inertia and loads, those at the nodes of the cut itself count for the
/// other part: both parts' forces differ by them, a layer of half an element. Like stresses, the loads are those of the
/// modes in use: a load close to the cut wants a static mode (Reduction::loaded). Viscous damping is left out.
class CutLoad {
 public:
  /// Throws SceneError for axes that are no rotation, unknown nodes, elements without material, a part that shares no
  /// node with the rest.
  CutLoad(const FlexibleBody& body, const BodyCut& cut);

  /// (n, m), N and N m. SceneError if the body has another basis since (set_fidelity()).
  Vector6 load(Snapshot& snapshot) const;
  /// Labels of the nodes on the cut, rising.
  const std::vector<int>& nodes() const { return nodes_; }

 private:
  const FlexibleBody* body_;
  std::shared_ptr<const ModalBasis> basis_;
  std::vector<int> nodes_;
  Matrix6X linear_;  // of the coordinates of all fields
  MatrixX pairs_;    // 6 x pairs (QuadraticDeflection); no columns: linear
};

/// The same as a sensor: n_1 … n_3 (N), m_1 … m_3 (N m).
Sensor cut_load(const FlexibleBody& body, const BodyCut& cut, Located name = "");

}  // namespace lithe
