#pragma once

#include "engine/assembly/batch.h"
#include "engine/model/scalar_body.h"

namespace lithe {

/// A rotor that turns with a joint's coordinate: the armature of a robot's drive. One coordinate of its own, coupled to
/// the joint's; only its kinetic energy ½ a ẋ² counts, no weight and no gyroscopic moment.
class Armature final : public ScalarBody {
 public:
  struct Parameters {
    double inertia = 1;  // a, kg m² of an angle, kg of a displacement
    double rate = 0;     // at the start
  };
  /// Throws SceneError for an inertia that is not positive, and for a value that is not finite.
  explicit Armature(Parameters parameters);

  BodyEnergy energy(const BodyState& state, const Vector3&) const override {
    return {.kinetic = 0.5 * mass() * state.v[0] * state.v[0]};
  }
};

extern template std::unique_ptr<BodyBatch> make_body_batch<Armature>();

}  // namespace lithe
