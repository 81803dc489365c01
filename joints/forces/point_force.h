#pragma once

#include "engine/assembly/batch.h"
#include "engine/model/adjustable.h"
#include "engine/model/force_element.h"

namespace lithe {

/// Constant force and torque at a marker, in axes that stay with the world (a dead load) or turn with the marker (a
/// follower, like a thruster). Only a dead force has a potential, V = -F · p; none has one whose factor is an Input.
class PointForce final : public Force</*markers=*/1, /*rows=*/0> {
 public:
  enum class Axes { world, marker };
  struct Parameters {
    Vector3 force{0, 0, 0};   // N
    Vector3 torque{0, 0, 0};  // N m
    Axes axes = Axes::world;
    Adjustable factor = 1;  // of both, for an Input
  };

  /// Throws SceneError for a value that is not finite.
  explicit PointForce(Parameters parameters);

  bool depends_on_time() const override { return parameters_.factor.varies(); }
  void evaluate(double time, std::span<const MarkerView> markers, ForceRows& rows) const override {
    const MarkerView& A = markers[0];
    const double factor = parameters_.factor.at(time);
    const Vector3 F = factor * parameters_.force, T = factor * parameters_.torque;
    if (parameters_.axes == Axes::marker) {
      rows.add_load(A, {A.R * F, A.R * T});
    } else {
      rows.add_load(A, {F, T});
      if (!parameters_.factor.varies()) rows.add_energy(-F.dot(A.p));
    }
  }

 private:
  const Parameters parameters_;
};

extern template std::unique_ptr<ForceBatch> make_force_batch<PointForce>();

}  // namespace lithe
