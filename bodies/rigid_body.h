#pragma once

#include "engine/assembly/batch.h"
#include "engine/model/rigid_frame_body.h"

namespace lithe {

/// Inertia about the centre of mass in body axes, kg m²: principal moments, or the full symmetric matrix.
struct Inertia {
  Matrix3 matrix = Matrix3::Identity();
  Inertia(double xx, double yy, double zz) : matrix(Vector3(xx, yy, zz).asDiagonal()) {}
  Inertia(const Vector3& principal) : matrix(principal.asDiagonal()) {}  // NOLINT: implicit on purpose
  Inertia(const Matrix3& full) : matrix(full) {}                         // NOLINT
};

/// Rigid body; its frame is at the centre of mass.
///   m (p̈ - g) = f,   J ω̇ + ω × (J ω) = t   (J, ω, t in body axes; engine/model/rigid_frame_body.h)
class RigidBody final : public RigidFrameBody {
 public:
  struct Parameters {
    double mass = 1;                            // kg
    Inertia inertia{1, 1, 1};                   // kg m², about the centre of mass, body axes
    Vector3 position{0, 0, 0};                  // of the centre of mass, world axes, m
    Matrix3 orientation = Matrix3::Identity();  // body axes to world axes
    Vector3 velocity{0, 0, 0};                  // of the centre of mass, world axes, m/s
    Vector3 angular_velocity{0, 0, 0};          // body axes, rad/s
  };
  /// Throws SceneError for mass <= 0, an inertia that no real body has, a matrix that is not a rotation, NaN.
  explicit RigidBody(Parameters parameters);

  const Parameters& parameters() const { return parameters_; }
  /// A frame at `position` from the centre of mass (body axes, m), with axes `orientation` (marker axes to body axes).
  Marker marker(const Point& position = {}, const Matrix3& orientation = Matrix3::Identity());
  /// A frame at `point` of the world where the body is drawn (m), with axes `orientation` (marker axes to world axes).
  Marker marker_at_world(const Point& point, const Matrix3& orientation = Matrix3::Identity());

 private:
  const Parameters parameters_;
};

extern template std::unique_ptr<BodyBatch> make_body_batch<RigidBody>();

}  // namespace lithe
