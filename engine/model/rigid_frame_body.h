#pragma once

#include <vector>

#include "engine/base/lane_rotations.h"
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
/// Here in full, so that batches inline it; the destructor alone is not, so that only its source compiles the rest
/// for the table of virtual functions.
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
  ~RigidFrameBody() override;

  Coordinates coordinates() const override { return {.frames = 1, .linear = 0}; }
  std::unique_ptr<BodyCache> make_cache() const override { return std::make_unique<Cache>(*this); }
  void initial_state(VectorRef q, VectorRef v) const override {
    q << start_.pose.position, quaternion_of(start_.pose.axes);
    v << start_.velocity, start_.angular_velocity;
  }
  const RigidInertia& rigid_inertia() const { return inertia_; }

  void evaluate(const BodyState& state, Level level) const override {
    auto& cache = static_cast<Cache&>(*state.cache);
    const lanes::Columns A = lanes::rotation_columns(state.q + 3);
    lanes::store3x3(A, cache.A.data());
    if (level != Level::position) lanes::store3(A * lanes::load3(state.v + 3), cache.omega_world.data());
  }

  [[gnu::always_inline]] void add_residual(const BodyState& state, const double* v_dot, const Vector3& gravity,
                                           double* r) const override {
    using lanes::load3;
    const lanes::Columns J = lanes::load3x3(inertia_.inertia.data());
    const Lanes w = load3(state.v + 3), spin = J * w;
    lanes::store3(load3(r) + inertia_.mass * (load3(v_dot) - load3(gravity.data())), r);
    lanes::store3(load3(r + 3) + J * load3(v_dot + 3) + lanes::cross(w, spin), r + 3);
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
    const lanes::Columns A = lanes::load3x3(cache.A.data());
    const Lanes r = lanes::load3(m.position.data()), arm = A * m.position;
    lanes::store3(lanes::load3(state.q) + arm, k.p.data());
    lanes::store3x3(m.turned ? A * lanes::load3x3(m.axes.data()) : A, k.R.data());
    lanes::store3(r, k.r.data());
    k.A = &cache.A;
    k.elastic = nullptr;
    if (level == Level::position) return;
    const Lanes w = lanes::load3(cache.omega_world.data()), swing = lanes::cross(w, arm);
    lanes::store3(w, k.w.data());
    lanes::store3(lanes::load3(state.v) + swing, k.v.data());
    if (level == Level::velocity) return;
    lanes::store3(lanes::cross(w, swing), k.bias_v.data());
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

  /// Bodies lie scattered in memory; batches fetch them ahead of evaluate(): first the body, then what it points to.
  void prefetch() const { __builtin_prefetch(&markers_); }
  void prefetch_markers() const {
    const auto* first = reinterpret_cast<const char*>(markers_.data());
    for (int line = 0; line < 3; ++line) __builtin_prefetch(first + 64 * line);  // of two markers
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
