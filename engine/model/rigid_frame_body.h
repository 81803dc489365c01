#pragma once

#include <vector>

#include "engine/model/body.h"

namespace lithe {

/// Position and axes (to world axes) of a frame that moves with a body, at the reference of that body.
struct FramePose {
  Vector3 position = Vector3::Zero();
  Matrix3 axes = Matrix3::Identity();
};

/// Enough to move a rigid body without asking it (engine/forward/).
struct RigidInertia {
  double mass;      // kg
  Matrix3 inertia;  // kg m², about the origin of the body's frame, which is its centre of mass; body axes
};

/// The motion of a rigid body whose frame is at the centre of mass; derived classes define how it is drawn.
///   m (p̈ - g) = f,   J ω̇ + ω × (J ω) = t   (J, ω, t in body axes)
/// Here in full, so that batches inline it.
class RigidFrameBody : public Body {
 public:
  struct Start {
    FramePose pose{};                   // as drawn
    Vector3 velocity{0, 0, 0};          // of the centre of mass, world axes, m/s
    Vector3 angular_velocity{0, 0, 0};  // body axes, rad/s
  };
  struct Cache : BodyCache {
    Vector3 omega_world = Vector3::Zero();
    explicit Cache(const RigidFrameBody&) {}
  };

  Coordinates coordinates() const override { return {.frames = 1, .linear = 0}; }
  std::unique_ptr<BodyCache> make_cache() const override { return std::make_unique<Cache>(*this); }
  void initial_state(VectorRef q, VectorRef v) const override {
    q << start_.pose.position, quaternion_of(start_.pose.axes);
    v << start_.velocity, start_.angular_velocity;
  }
  const RigidInertia& rigid_inertia() const { return inertia_; }

  void evaluate(const BodyState& state, Level level) const override {
    auto& cache = static_cast<Cache&>(*state.cache);
    cache.A = rotation_matrix(Eigen::Map<const Vector4>(state.q + 3));
    if (level != Level::position) cache.omega_world = cache.A * Eigen::Map<const Vector3>(state.v + 3);
  }

  [[gnu::always_inline]] void add_residual(const BodyState& state, const double* v_dot, const Vector3& gravity,
                                           double* r) const override {
    const Eigen::Map<const Vector3> w(state.v + 3), a(v_dot), w_dot(v_dot + 3);
    const auto& [mass, J] = inertia_;
    Eigen::Map<Vector3>(r) += mass * (a - gravity);
    Eigen::Map<Vector3>(r + 3) += J * w_dot + w.cross(Vector3(J * w));
  }

  [[gnu::always_inline]] void add_tangent(const BodyState& state, const double*, const Vector3&,
                                          const TangentWeights& weights, BodyTangent& S) const override {
    const auto& [mass, J] = inertia_;
    for (int i = 0; i < 3; ++i) S.frame(i, i) += weights.acceleration * mass;
    S.frame.bottomRightCorner<3, 3>() += weights.acceleration * J;
    if (weights.velocity == 0) return;
    // ∂(ω × J ω)/∂ω = ω~ J - (J ω)~
    const Eigen::Map<const Vector3> w(state.v + 3);
    S.frame.bottomRightCorner<3, 3>() += weights.velocity * (skew(w) * J - skew(J * w));
  }

  [[gnu::always_inline]] void marker_kinematics(const BodyState& state, int marker, Level level,
                                                MarkerKinematics& k) const override {
    const auto& cache = static_cast<const Cache&>(*state.cache);
    const PlacedMarker& m = markers_[marker];
    const Vector3 arm = cache.A * m.position;
    k.p = Eigen::Map<const Vector3>(state.q) + arm;
    if (m.turned)
      k.R = cache.A * m.axes;
    else
      k.R = cache.A;
    k.r = m.position;
    k.A = &cache.A;
    k.elastic = nullptr;
    if (level == Level::position) return;
    k.w = cache.omega_world;
    const Vector3 swing = k.w.cross(arm);
    k.v = Eigen::Map<const Vector3>(state.v) + swing;
    if (level == Level::velocity) return;
    k.bias_v = k.w.cross(swing);
    k.bias_w.setZero();
  }

  BodyEnergy energy(const BodyState& state, const Vector3& gravity) const override {
    const Eigen::Map<const Vector3> p(state.q), v(state.v), w(state.v + 3);
    const auto& [mass, J] = inertia_;
    BodyEnergy e;
    e.kinetic = 0.5 * mass * v.squaredNorm() + 0.5 * w.dot(J * w);
    e.gravity = -mass * gravity.dot(p);
    return e;
  }

 protected:
  RigidFrameBody(const RigidInertia& inertia, const Start& start) : inertia_(inertia), start_(start) {}
  /// In body axes, from the centre of mass.
  Marker place_marker(const Vector3& position, const Matrix3& axes) {
    markers_.push_back({position, axes != Matrix3::Identity(), axes});
    return new_marker();
  }

 private:
  struct PlacedMarker {
    Vector3 position;
    bool turned;  // axes are not those of the body
    Matrix3 axes;
  };
  const RigidInertia inertia_;
  const Start start_;
  std::vector<PlacedMarker> markers_;
};

/// Null unless the body is a rigid one: with a frame at its centre of mass alone, no force of its own, and markers
/// fixed in it.
inline const RigidInertia* rigid_inertia_of(const Body& body) {
  const auto* rigid = dynamic_cast<const RigidFrameBody*>(&body);
  return rigid ? &rigid->rigid_inertia() : nullptr;
}

}  // namespace lithe
