#pragma once

#include <memory>
#include <nlohmann/json.hpp>

#include "bodies/flexible/flexible_body.h"
#include "engine/model/system_graph.h"

namespace lithe::oracle {

/// Deeply nested lists stacked to a matrix with as many columns as the innermost list has entries.
MatrixX matrix3(const nlohmann::json& nested);

/// Invariants of a case: from m_ij or S with nodes and B, or as the file lists them.
InertiaIntegrals integrals_of(const nlohmann::json& data);

/// q (quaternion normalised) and v of a state in the file; v_dot zero if it has none.
struct Motion {
  VectorX q, v, v_dot;
  explicit Motion(const nlohmann::json& state);
};

/// The case's body in a graph of its own, evaluated at the states of the file.
class Evaluated {
 public:
  explicit Evaluated(const nlohmann::json& data) : Evaluated(data, integrals_of(data)) {}
  Evaluated(const nlohmann::json& data, InertiaIntegrals integrals);

  void set(const nlohmann::json& state);
  FlexibleBody& body() { return *body_; }
  BodyState state() const { return {motion_->q.data(), motion_->v.data(), cache_.get()}; }
  const double* v_dot() const { return motion_->v_dot.data(); }
  Marker marker() const { return marker_; }
  Marker node_marker(int node);
  MarkerKinematics kinematics(Marker marker) const;
  VectorX generalized(Marker marker, const Vector3& force, const Vector3& torque) const;  // Jv^T F + Jw^T N
  Vector6 acceleration(Marker marker) const;                                              // J v_dot + bias

 private:
  MatrixX jacobian(const MarkerKinematics& k) const;

  SystemGraph graph_;
  FlexibleBody* body_;
  Marker marker_;
  std::unique_ptr<Motion> motion_;
  std::unique_ptr<BodyCache> cache_;
};

/// M, f_v and gravity by nodes (NodalInertia over all 3n coordinates), reduced by B.
struct NodalForm {
  MatrixX M;
  VectorX f_v, f_gravity;
  NodalForm(const nlohmann::json& data, const nlohmann::json& state);
};

}  // namespace lithe::oracle
