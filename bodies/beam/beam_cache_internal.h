#pragma once

#include <deque>

#include "bodies/beam/beam.h"

namespace lithe {

class SpanField;

/// A marker between two nodes.
class BetweenNodes final : public MarkerBetween {
 public:
  /// By d with central differences of what the wrench does at both nodes, by the turns of their axes exactly.
  void add_load_stiffness(const Vector3& force, const Vector3& torque, Eigen::Matrix<double, 12, 12>& K) const override;

  const BeamSpan* span = nullptr;
  double share = 0;  // ξ
  Vector3 offset = Vector3::Zero();
  // At the state evaluated last:
  Vector6 d = Vector6::Zero();
  Matrix3 A = Matrix3::Identity(), B = Matrix3::Identity();  // axes of the nodes

 private:
  /// What a wrench at the marker does at both nodes, all in the nodes' axes (the wrench in those of the first).
  BeamSpan::Vector12 at_nodes(const SpanField& field, const Vector3& force_A, const Vector3& torque_A) const;
};

struct Beam::Cache : BodyCache {
  explicit Cache(const Beam& beam);
  BetweenNodes& marker(const Beam& beam, int index);
  std::vector<Matrix3> axes;           // of the nodes
  std::vector<Vector6> twists;         // of the nodes, in their axes
  std::vector<Vector6> d, resultants;  // of the elements
  std::deque<BetweenNodes> between;    // a marker each, of those at nodes unused; markers made later are added
};

}  // namespace lithe
