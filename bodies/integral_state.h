#pragma once

#include "engine/assembly/batch.h"
#include "engine/model/scalar_body.h"

namespace lithe {

/// The integral of a signal, for controllers: one coordinate of unit mass on which only its controller acts, so that
/// its rate is the integral of that force over time. It has no energy and is not affected by gravity.
class IntegralState final : public ScalarBody {
 public:
  struct Parameters {
    double start = 0;  // of the integral
  };
  /// Its coordinate()'s rate is the integral. Throws SceneError for a value that is not finite.
  explicit IntegralState(Parameters parameters);

  BodyEnergy energy(const BodyState&, const Vector3&) const override { return {}; }
  bool has_energy() const override { return false; }
};

extern template std::unique_ptr<BodyBatch> make_body_batch<IntegralState>();

}  // namespace lithe
