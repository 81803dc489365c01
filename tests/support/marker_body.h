#pragma once

#include <memory>
#include <vector>

#include "engine/assembly/batch_of.h"
#include "engine/model/body.h"

namespace lithe::test {

/// A marker that modes move and turn in the most general way (docs/equations.md 7.1), in body axes:
///   point c + Bm eta,   orientation exp((Theta eta)~) R0.
struct ModalMarker {
  Vector3 c{0, 0, 0};
  Matrix3X Bm{3, 0}, Theta{3, 0};  // 3 x n
  Matrix3 R0 = Matrix3::Identity();

  Vector3 point(const VectorX& eta) const;
  Matrix3 orientation(const VectorX& eta) const;
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
    explicit Cache(const MarkerBody& body);
  };

  explicit MarkerBody(Parameters parameters);

  Marker marker(int index = 0) const { return {this, index}; }

  Coordinates coordinates() const override { return {.frames = 1, .linear = modes()}; }
  std::unique_ptr<BodyCache> make_cache() const override;
  void initial_state(VectorRef q, VectorRef v) const override;
  void evaluate(const BodyState& state, Level) const override;
  void add_residual(const BodyState&, const double* v_dot, const Vector3& gravity, double* r) const override;
  void add_tangent(const BodyState&, const double*, const Vector3&, const TangentWeights& weights,
                   BodyTangent& S) const override;
  void marker_kinematics(const BodyState& state, int marker, Level level, MarkerKinematics& k) const override;
  BodyEnergy energy(const BodyState& state, const Vector3& gravity) const override;

 private:
  int modes() const { return static_cast<int>(parameters_.eta.size()); }
  Eigen::Map<const VectorX> eta(const BodyState& state) const { return {state.q + 7, modes()}; }

  Parameters parameters_;
};

}  // namespace lithe::test
