#pragma once

#include "engine/base/math.h"

namespace lithe {

class Body;

/// How much of a state an evaluation needs: each level contains the ones before.
enum class Level { position, velocity, acceleration };

/// A point, written {x, y, z} or as a vector; {} is the origin (an Eigen vector made of {} holds anything).
struct Point {
  Vector3 at = Vector3::Zero();
  Point() = default;
  Point(double x, double y, double z) : at(x, y, z) {}
  template <class Derived>
  Point(const Eigen::MatrixBase<Derived>& vector) : at(vector) {}  // NOLINT: implicit on purpose
};

/// A frame on a body: a point, a node, the mean of some nodes. A handle, passed by value; made by its body.
struct Marker {
  const Body* body = nullptr;
  int index = -1;
  bool operator==(const Marker&) const = default;
};

/// For a marker whose elastic columns change with the deformation: the contribution of a wrench on it to the tangent.
class DeflectedMarker {
 public:
  virtual ~DeflectedMarker() = default;
  /// linear += ∂(elasticᵀ w)/∂eta for a constant wrench in body axes: entries of the body's linear-linear block, as
  /// Coordinates::pattern orders them.
  virtual void add_load_stiffness(const Vector3& force, const Vector3& torque, double* linear) const = 0;
};

/// For a marker that moves with two frames of its body, as one between two nodes of a beam does:
///   (v, w) = Σ J_k (p_dot_k, omega_k),   p_dot_k in world axes, omega_k in those of the frame.
class MarkerBetween {
 public:
  struct Share {
    int frame;
    Matrix6 J;
  };
  Share shares[2];

  virtual ~MarkerBetween() = default;
  /// K += ∂(J_1ᵀ W, J_2ᵀ W)/∂(positions and turns of both frames) for a constant wrench in world axes; rotations by
  /// axes of the frames. What Newton does not need may be left out.
  virtual void add_load_stiffness(const Vector3& force, const Vector3& torque,
                                  Eigen::Matrix<double, 12, 12>& K) const = 0;
};

/// Motion of a marker in world axes, and its Jacobian by the velocities of its body.
///   (v, w) = J v_body,   (v_dot, w_dot) = J v_body_dot + (bias_v, bias_w)
/// J is never stored: for a body with a frame (rotation A, marker at r in body axes) and linear coordinates eta
///   J = [E, -A r~, A B; 0, A, A T],   elastic = [B; T] (6 x n, body axes, column-major; null if eta does not move it).
/// A body without frame has A = E and only the elastic columns. Of a body with several frames, v_body is the velocity
/// of one frame, A its rotation, and "body axes" are those of that frame.
struct MarkerKinematics {
  const Matrix3* A = nullptr;
  const double* elastic = nullptr;
  const DeflectedMarker* deflected = nullptr;  // null: the columns are constant
  const MarkerBetween* between = nullptr;      // null: it is fixed in one frame, if its body has any
  int frame = 0;                               // of several frames, the one that it is fixed in
  Vector3 r;                                   // position in body axes
  Vector3 p;                                   // position
  Matrix3 R;                                   // marker axes to world axes
  Vector3 v, w;  // velocity of the point, angular velocity; last, for most evaluations do not need them
  Vector3 bias_v, bias_w;
};

/// A marker as a joint or force sees it; `index` is its place in the element's marker list.
struct MarkerView {
  const Vector3& p;
  const Matrix3& R;
  const Vector3 &v, &w;
  int index;

  MarkerView(const MarkerKinematics& k, int place) : p(k.p), R(k.R), v(k.v), w(k.w), index(place) {}
  auto x() const { return R.col(0); }
  auto y() const { return R.col(1); }
  auto z() const { return R.col(2); }
};

/// Force and torque at a marker, world axes.
struct Wrench {
  Vector3 force, torque;
};
inline Wrench operator+(const Wrench& a, const Wrench& b) { return {a.force + b.force, a.torque + b.torque}; }
inline Wrench operator-(const Wrench& a, const Wrench& b) { return {a.force - b.force, a.torque - b.torque}; }
inline Wrench operator*(double s, const Wrench& w) { return {s * w.force, s * w.torque}; }
inline Wrench force(const Vector3& f) { return {f, Vector3::Zero()}; }
inline Wrench torque(const Vector3& t) { return {Vector3::Zero(), t}; }

}  // namespace lithe
