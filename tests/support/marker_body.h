#pragma once

#include <vector>

#include "engine/batch_of.h"
#include "engine/body.h"
#include "engine/checks.h"

namespace lithe::test {

/// A marker that modes move and turn in the most general way (EQUATIONS.md 7.1), in body axes:
///   point c + Bm eta,   orientation exp((Theta eta)~) R0.
struct ModalMarker {
  Vector3 c{0, 0, 0};
  Matrix3X Bm{3, 0}, Theta{3, 0};  // 3 x n
  Matrix3 R0 = Matrix3::Identity();

  Vector3 point(const VectorX& eta) const { return c + Bm * eta; }
  Matrix3 orientation(const VectorX& eta) const { return rotation_exp(Theta * eta) * R0; }
};

/// A floating frame with n modes and markers that they move. Its inertia is the unit matrix, so that tests see the
/// joint alone. It is also the proof that a new kind of body is one file that the engine knows nothing of.
class MarkerBody final : public Body {
 public:
  struct Parameters {
    std::vector<ModalMarker> markers;
    Vector3 position{0, 0, 0};                  // of the frame as drawn
    Matrix3 orientation = Matrix3::Identity();  // of the frame as drawn
    VectorX eta;                                // as drawn; its length is the number of modes
  };
  struct Cache : BodyCache {
    std::vector<Matrix6X> elastic;  // [Bm; Jl(phi) Theta] of each marker
    explicit Cache(const MarkerBody& body) : elastic(body.parameters_.markers.size(), Matrix6X(6, body.modes())) {}
  };

  explicit MarkerBody(Parameters parameters) : parameters_(std::move(parameters)) {
    require::rotation(parameters_.orientation, "orientation");
    for (const ModalMarker& m : parameters_.markers) require::rotation(m.R0, "R0");
  }

  Marker marker(int index = 0) const { return {this, index}; }

  Coordinates coordinates() const override { return {.frame = true, .linear = modes()}; }
  std::unique_ptr<BodyCache> make_cache() const override { return std::make_unique<Cache>(*this); }
  void initial_state(VectorRef q, VectorRef v) const override {
    q << parameters_.position, quaternion_of(parameters_.orientation), parameters_.eta;
    v.setZero();
  }
  void evaluate(const BodyState& state, Level) const override {
    auto& cache = static_cast<Cache&>(*state.cache);
    cache.A = rotation_matrix(Eigen::Map<const Vector4>(state.q + 3));
    for (int i = 0; i < marker_count(); ++i) {
      const ModalMarker& m = parameters_.markers[i];
      cache.elastic[i].topRows<3>() = m.Bm;
      cache.elastic[i].bottomRows<3>() = left_jacobian(m.Theta * eta(state)) * m.Theta;
    }
  }
  void add_residual(const BodyState&, const double* v_dot, const Vector3& gravity, double* r) const override {
    for (int i = 0; i < 6 + modes(); ++i) r[i] += v_dot[i];
    Eigen::Map<Vector3>(r) -= gravity;
  }
  void add_tangent(const BodyState&, const double*, const Vector3&, const TangentWeights& weights,
                   BodyTangent& S) const override {
    S.frame.diagonal().array() += weights.acceleration;
    S.linear.array() += weights.acceleration;
  }
  void marker_kinematics(const BodyState& state, int marker, Level level, MarkerKinematics& k) const override {
    const auto& cache = static_cast<const Cache&>(*state.cache);
    const ModalMarker& m = parameters_.markers[marker];
    const Matrix6X& elastic = cache.elastic[marker];
    const Vector3 phi = m.Theta * eta(state);
    k.r = m.point(eta(state));
    k.A = &cache.A;
    k.elastic = modes() > 0 ? elastic.data() : nullptr;
    k.p = Eigen::Map<const Vector3>(state.q) + cache.A * k.r;
    k.R = cache.A * m.orientation(eta(state));
    if (level == Level::position) return;
    const Eigen::Map<const Vector3> omega(state.v + 3);
    const Eigen::Map<const VectorX> eta_dot(state.v + 6, modes());
    const Vector3 r_dot = m.Bm * eta_dot, turn = elastic.bottomRows<3>() * eta_dot;
    k.v = Eigen::Map<const Vector3>(state.v) + cache.A * (omega.cross(k.r) + r_dot);
    k.w = cache.A * (omega + turn);
    if (level == Level::velocity) return;
    k.bias_v = cache.A * (omega.cross(omega.cross(k.r)) + 2 * omega.cross(r_dot));
    k.bias_w = cache.A * (omega.cross(turn) + left_jacobian_rate(phi, m.Theta * eta_dot));
  }
  BodyEnergy energy(const BodyState& state, const Vector3& gravity) const override {
    return {.kinetic = 0.5 * Eigen::Map<const VectorX>(state.v, 6 + modes()).squaredNorm(),
            .gravity = -gravity.dot(Eigen::Map<const Vector3>(state.q))};
  }
  int marker_count() const override { return static_cast<int>(parameters_.markers.size()); }

 private:
  int modes() const { return static_cast<int>(parameters_.eta.size()); }
  Eigen::Map<const VectorX> eta(const BodyState& state) const { return {state.q + 7, modes()}; }

  Parameters parameters_;
};

}  // namespace lithe::test
